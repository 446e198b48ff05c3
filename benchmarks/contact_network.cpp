// The contact network at the paper's size: plain dense evaluation, then the fast one on the same input. Equality is
// asserted; `ratio` is dense time over fast time in this run. Time is what one waits, CPU the sum over all threads;
// OMP_NUM_THREADS says how many there are.
#include <benchmark/benchmark.h>

#include <chrono>

#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/thread_variables.h"
#include "room_cloud.h"

namespace {

using namespace inhabit;
using torch::Tensor;

struct Case {
  forecast::ContactNetwork network{nullptr};
  Tensor scene, past, contact;
  double dense_seconds = 0;

  explicit Case(const std::string& preset) {
    torch::manual_seed(1);
    const forecast::Config config = forecast::preset(preset);
    network = forecast::ContactNetwork(config);
    for (auto& buffer : network->named_buffers()) {
      if (buffer.value().is_floating_point()) buffer.value().uniform_(0.5, 1.5);  // statistics as if trained
    }
    network->eval();
    for (const auto& module : network->modules(false)) {
      if (auto* layer = module->as<nn::PointVoxelConvImpl>()) layer->dense = true;
    }
    scene = room_cloud(config.inference.points);
    past = somebody(config.past, config.joints);
    contact = forecast::contact_features(scene, past, config);
  }
};

Case& paper_case() {
  static Case instance("paper");
  return instance;
}

void dense(benchmark::State& state) {
  torch::NoGradGuard no_gradients;
  Case& the = paper_case();
  double least = 1e9;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(the.network->forward(the.scene, the.contact, the.past));
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  the.dense_seconds = least;
}
BENCHMARK(dense)
    ->Name("contact_network/paper/dense")
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Iterations(5);

void fast(benchmark::State& state) {
  Case& the = paper_case();
  forecast::FastContactNetwork network(the.network);
  const Tensor got = network.forward(the.scene, the.contact, the.past);
  {
    torch::NoGradGuard no_gradients;
    const Tensor expected = the.network->forward(the.scene, the.contact, the.past);
    const double error = ((got - expected).abs().max() / (expected - the.contact).abs().max()).item<double>();
    if (!(error < 1e-4)) return state.SkipWithError("fast and dense outputs differ");
    state.counters["error"] = error;
  }
  double least = 1e9;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(network.forward(the.scene, the.contact, the.past));
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  if (the.dense_seconds > 0) state.counters["ratio"] = the.dense_seconds / least;
}
BENCHMARK(fast)
    ->Name("contact_network/paper/fast")
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Iterations(30);

void compact(benchmark::State& state) {
  Case the("compact");
  forecast::FastContactNetwork network(the.network);
  for (auto _ : state) benchmark::DoNotOptimize(network.forward(the.scene, the.contact, the.past));
}
BENCHMARK(compact)
    ->Name("contact_network/compact/fast")
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace

int main(int argc, char** argv) {
  inhabit::start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
