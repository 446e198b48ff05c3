// Detours around what blocks the line between two keys (the first of blocked_rooms): A* over the floor plan, and
// PathNet.
#include <benchmark/benchmark.h>

#include "inhabit/inbetween/blocked_rooms.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/learned_detours.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/thread_variables.h"

namespace {

using namespace inhabit;
using torch::Tensor;

struct Question {
  inbetween::BlockedRoom room;
  inbetween::Poses keys;
  inbetween::SceneDistances scene;
  Tensor groups = torch::zeros({121, inbetween::kKeyGroups});

  Question()
      : room(inbetween::blocked_rooms(1, 121, 30, 1).front()), keys(inbetween::poses_of(room.ends)), scene(room.scene) {
    for (const int64_t key : {0, 120}) groups[key].fill_(1);
  }
};

const Question& question() {
  static const Question asked;
  return asked;
}

void searched(benchmark::State& state) {
  const Question& q = question();
  for (auto _ : state) benchmark::DoNotOptimize(inbetween::detours_of_poses(q.keys, q.groups, q.scene));
}

void learned(benchmark::State& state) {
  const torch::NoGradGuard no_gradients;
  const Question& q = question();
  const inbetween::PathNet network =
      inbetween::load_networks(INHABIT_SOURCE_DIR "/models/inbetween-compact.safetensors").path;
  for (auto _ : state) benchmark::DoNotOptimize(inbetween::learned_detours(network, q.keys, q.groups, q.scene, 1, 1));
}

BENCHMARK(searched)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(learned)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

int main(int argc, char** argv) {
  inhabit::start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
