// Autoregressive decoding of one forecast at the paper's size: tensor operators against plain loops.
#include <benchmark/benchmark.h>

#include "inhabit/forecast/fast_motion_network.h"
#include "room_cloud.h"

namespace {

using namespace inhabit;
using torch::Tensor;

struct Input {
  forecast::Config config = forecast::preset("paper");
  forecast::MotionNetwork network{nullptr};
  Tensor past, points;
  Input() {
    torch::manual_seed(1);
    network = forecast::MotionNetwork(config);
    network->eval();
    past = somebody(config.past, config.joints);
    points = torch::rand({1, config.future, config.joints, 4});
  }
};

void plain(benchmark::State& state) {
  Input in;
  torch::NoGradGuard no_gradients;
  for (auto _ : state) benchmark::DoNotOptimize(in.network->forward(in.past, in.points).local);
}
BENCHMARK(plain)->Name("motion_decode/plain")->Unit(benchmark::kMillisecond)->UseRealTime();

void fast(benchmark::State& state) {
  Input in;
  torch::NoGradGuard no_gradients;
  const forecast::FastMotionNetwork network(in.network);
  const Tensor got = network.forward(in.past, in.points).local,
               expected = in.network->forward(in.past, in.points).local;
  const double error = ((got - expected).abs().max() / expected.abs().max()).item<double>();
  if (!(error < 1e-5)) return state.SkipWithError("fast and plain outputs differ");
  state.counters["error"] = error;
  for (auto _ : state) benchmark::DoNotOptimize(network.forward(in.past, in.points).local);
}
BENCHMARK(fast)->Name("motion_decode/fast")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
