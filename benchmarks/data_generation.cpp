#include <benchmark/benchmark.h>

#include "inhabit/body/body_model.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/person.h"
#include "inhabit/synth/room.h"

// How much faster than real time clips are made, on one core: seconds of motion for a second of work.

namespace {

void make_rooms(benchmark::State& state) {
  uint64_t seed = 0;
  for (auto _ : state) {
    std::mt19937_64 random(seed++);
    benchmark::DoNotOptimize(inhabit::make_room(random).scene());
  }
}
BENCHMARK(make_rooms)->Unit(benchmark::kMillisecond);

void live_in_rooms(benchmark::State& state) {
  torch::set_num_threads(1);
  const inhabit::BodyModel& body = inhabit::builtin_body();
  uint64_t seed = 0;
  double seconds = 0;
  for (auto _ : state) {
    std::mt19937_64 random(inhabit::item_seed(1, seed++));
    const inhabit::Room room = inhabit::make_room(random);
    seconds += inhabit::live(room, body, random).seconds();
  }
  state.counters["times_real_time"] = benchmark::Counter(seconds, benchmark::Counter::kIsRate);
}
BENCHMARK(live_in_rooms)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
