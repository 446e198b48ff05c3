// A frame of chair interaction: PoseNet and ControlNet in LibTorch's operators, then the fast evaluations on the same
// rows, for one person and for a hundred at once. Equality is asserted; `error` is relative to the largest output,
// `ratio` LibTorch's time over the fast one's in this run, `fps` how often a second all of them are moved on. LibTorch
// blends the experts' weights for one person, as the release does; for a hundred it blends their outputs, which needs
// less memory. "frame" is all of LivePerson::step(): features, both networks, blending and bones, person by person;
// `allocations` is how often it calls operator new, counted over 100 frames.
// OMP_NUM_THREADS says how many threads there are.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <map>
#include <new>

#include "inhabit/interact/fast_control_network.h"
#include "inhabit/interact/fast_pose_network.h"
#include "inhabit/interact/features.h"
#include "inhabit/interact/live_person.h"
#include "inhabit/interact/recording.h"
#include "inhabit/scene/shapes.h"
#include "inhabit/thread_variables.h"

namespace {

std::atomic<int64_t> calls_of_new{0};

}  // namespace

void* operator new(size_t bytes) {
  calls_of_new.fetch_add(1, std::memory_order_relaxed);
  if (void* memory = std::malloc(std::max<size_t>(1, bytes))) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace {

using namespace inhabit;
using interact::PoseNetwork;
using torch::Tensor;

struct Case {
  interact::Config config;
  PoseNetwork pose{nullptr};
  interact::ControlNetwork control{nullptr};
  std::map<std::string, double> seconds;  ///< of LibTorch, by network and number of people

  explicit Case(const std::string& preset)
      : config(interact::preset(preset)), pose(interact::pose_sizes(config)), control(config) {
    torch::manual_seed(1);
    pose->eval();
    control->eval();
  }
};

Case& case_of(const std::string& preset) {
  static Case compact("compact"), paper("paper");
  return preset == "paper" ? paper : compact;
}

Tensor rows_for(const Case& the, int64_t people) {
  torch::manual_seed(2);
  return torch::randn({people, the.pose->sizes.row});
}

/// One person's frame with blended weights.
Tensor with_blended_weights(PoseNetwork& network, const Tensor& x) {
  std::vector<Tensor> codes;
  int64_t first = 0;
  for (size_t i = 0; i < network->encoders.size(); ++i) {
    const int64_t width = network->sizes.inputs[i];
    codes.push_back(network->encoders[i]->forward(x.narrow(1, first, width)));
    first += width;
  }
  const Tensor gates = network->gates(x)[0];
  Tensor h = torch::cat(codes, 1)[0];
  const auto& experts = *network->experts;
  for (size_t layer = 0; layer < experts.weights.size(); ++layer) {
    h = torch::tensordot(gates, experts.weights[layer], {0}, {0}).mv(h) + gates.matmul(experts.biases[layer]);
    if (layer + 1 < experts.weights.size()) h = torch::elu(h);
  }
  return h.unsqueeze(0);
}

Tensor plain_pose(Case& the, const Tensor& x) {
  return x.size(0) == 1 ? with_blended_weights(the.pose, x) : the.pose->forward(x);
}

/// Least seconds that `work` takes in this benchmark's iterations.
template <class Work>
double measure(benchmark::State& state, const Work& work) {
  double least = 1e9;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    work();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  state.counters["fps"] = 1 / least;
  return least;
}

void pose_plain(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  Case& the = case_of(preset);
  const Tensor x = rows_for(the, people);
  the.seconds["pose" + std::to_string(people)] = measure(state, [&] { benchmark::DoNotOptimize(plain_pose(the, x)); });
}

void pose_fast(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  Case& the = case_of(preset);
  const interact::FastPoseNetwork fast(the.pose);
  interact::FastPoseNetwork::Workspace workspace;
  const Tensor x = rows_for(the, people), expected = plain_pose(the, x);
  Tensor y = torch::empty_like(expected);
  const auto frame = [&] { fast.forward(x.data_ptr<float>(), people, y.data_ptr<float>(), workspace); };
  frame();
  const double error = ((y - expected).abs().max() / expected.abs().max()).item<double>();
  if (!(error < 1e-4)) return state.SkipWithError("fast and plain outputs differ");
  state.counters["error"] = error;
  const double least = measure(state, frame), plain = the.seconds["pose" + std::to_string(people)];
  if (plain > 0) state.counters["ratio"] = plain / least;
}

void control_plain(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  Case& the = case_of(preset);
  const Tensor pose = torch::randn({people, the.config.pose_size()}),
               control = torch::randn({people, the.config.control_size()});
  interact::ControlState carried = the.control->start(people);
  the.seconds["control" + std::to_string(people)] =
      measure(state, [&] { benchmark::DoNotOptimize(the.control->step(pose, control, carried)); });
}

void control_fast(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  Case& the = case_of(preset);
  const interact::FastControlNetwork fast(the.control);
  interact::FastControlNetwork::Workspace workspace;
  const Tensor pose = torch::randn({people, fast.pose_size()}), control = torch::randn({people, fast.control_size()});
  Tensor carried = torch::empty({people, fast.state_size()}), out = torch::empty_like(control);
  for (int64_t i = 0; i < people; ++i) fast.start(carried[i].data_ptr<float>());
  interact::ControlState plain_carried = the.control->start(people);
  const auto frame = [&] {
    fast.step(pose.data_ptr<float>(), control.data_ptr<float>(), people, carried.data_ptr<float>(),
              out.data_ptr<float>(), workspace);
  };
  double error = 0;
  for (int t = 0; t < 30; ++t) {
    frame();
    const Tensor expected = the.control->step(pose, control, plain_carried);
    error = std::max(error, ((out - expected).abs().max() / expected.abs().max()).item<double>());
  }
  if (!(error < 1e-4)) return state.SkipWithError("fast and plain outputs differ");
  state.counters["error"] = error;
  const double least = measure(state, frame), plain = the.seconds["control" + std::to_string(people)];
  if (plain > 0) state.counters["ratio"] = plain / least;
}

/// Whole frames of people who stand at a chair, both hands on their way to contacts out of reach, so that ControlNet
/// runs in every frame. The networks' outputs are their means, those of somebody who stands: time is the same.
interact::Networks standing_networks(const Case& the) {
  interact::Networks n;
  n.config = the.config;
  n.pose = the.pose;
  n.control = the.control;
  const interact::InputLayout in = interact::input_layout(the.config);
  const interact::OutputLayout out = interact::output_layout(the.config);
  n.input_scale = {torch::zeros({in.size}), torch::ones({in.size})};
  n.output_scale = {torch::zeros({out.size}), torch::full({out.size}, 1e-6)};
  const Clip person = interact::standing_clip({0, 0}, 0);
  const interact::Recording r = interact::record(person, interact::label(person, std::nullopt), "benchmark");
  const interact::State state = interact::state_at(r, 0);
  interact::build_target(out, state, state, n.output_scale.mean.data_ptr<float>());
  return n;
}

void whole_frame(benchmark::State& state, const std::string& preset, int64_t people) {
  const torch::NoGradGuard no_gradients;
  const interact::Engine engine(standing_networks(case_of(preset)));
  interact::Chair chair;
  chair.name = "high stool";
  MeshBuilder seat;
  seat.box({0, 0.425, 0}, {0.25, 0.425, 0.25});
  chair.mesh = seat.mesh(chair.name, {0.5F, 0.5F, 0.5F});
  chair.seat_height = 0.85;
  const auto around = std::make_shared<const interact::Surroundings>(Scene{"room", {chair.mesh}, {}});
  std::vector<interact::LivePerson> persons;
  for (int64_t i = 0; i < people; ++i) {
    persons.emplace_back(engine, interact::standing_clip({0, 0}, 0));
    persons.back().sit_on(chair, around, {Eigen::Vector3d(0.9, 0.5, 0.5), Eigen::Vector3d(-0.9, 0.5, 0.5)});
  }
  const auto frame = [&] {
    for (interact::LivePerson& person : persons) person.step();
  };
  for (int i = 0; i < 30; ++i) frame();  // the distances around them are sampled once
  if (!persons.front().state().wanted[0]) return state.SkipWithError("no hand is on its way");
  const int64_t before = calls_of_new;
  constexpr int kCounted = 100;
  for (int i = 0; i < kCounted; ++i) frame();
  state.counters["allocations"] = static_cast<double>(calls_of_new - before) / kCounted;
  state.counters["people_at_30fps"] = static_cast<double>(people) / (30 * measure(state, frame));
}

}  // namespace

int main(int argc, char** argv) {
  start_with_thread_variables(argv);
  for (const std::string preset : {"paper", "compact"})
    for (const int64_t people : {1, 100})
      for (const auto& [name, run] : {std::pair("pose/plain", &pose_plain),
                                      {"pose/fast", &pose_fast},
                                      {"control/plain", &control_plain},
                                      {"control/fast", &control_fast},
                                      {"frame", &whole_frame}}) {
        const std::string full = "interact/" + preset + "/" + std::to_string(people) + "/" + name;
        benchmark::RegisterBenchmark(full.c_str(),
                                     [run, preset, people](benchmark::State& state) { run(state, preset, people); })
            ->Unit(benchmark::kMicrosecond)
            ->UseRealTime()
            ->MinTime(0.5);
      }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
