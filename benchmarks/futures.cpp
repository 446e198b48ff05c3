// Futures of thirty seconds: tensor operators step by step, plain loops, and the floor that the matrix products of the
// decoder set by themselves.
#include <benchmark/benchmark.h>

#include "inhabit/anticipate/fast_futures.h"
#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/io/files.h"
#include "inhabit/motion/local_pose.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/nn/parallel_chunks.h"
#include "inhabit/thread_variables.h"

namespace {

using namespace inhabit;
using torch::Tensor;

constexpr int64_t kFrames = 750;

/// The shipped model after the bundled walk.
struct Input {
  anticipate::Networks networks = anticipate::load_networks(INHABIT_SOURCE_DIR "/models/anticipate-cmu.safetensors");
  Tensor past;
  anticipate::FutureNoise noise;
  explicit Input(int64_t samples) {
    const std::string path = INHABIT_SOURCE_DIR "/examples/data/walk.npz";
    const Clip walk = on_skeleton(resample(retarget(read_clip(path), path), 25, path), networks.skeleton);
    past = anticipate::observation(anticipate::joint_features(walk.joints), walk.frames(), networks.config.observed)
               .unsqueeze(0);
    noise = anticipate::draw_noise(networks.config, samples, kFrames, 1);
  }
};

void plain(benchmark::State& state) {
  const Input in(state.range(0));
  at::set_num_threads(static_cast<int>(state.range(1)));
  for (auto _ : state)
    benchmark::DoNotOptimize(anticipate::plain_futures(in.networks, in.past, in.noise, kFrames).features);
}

void fast(benchmark::State& state) {
  const Input in(state.range(0));
  at::set_num_threads(static_cast<int>(state.range(1)));
  const anticipate::FastFutures network(in.networks);
  const Tensor got = network.forward(in.past, in.noise, kFrames).features,
               expected = anticipate::plain_futures(in.networks, in.past, in.noise, kFrames).features;
  const double error = ((got - expected).abs().max() / expected.abs().max()).item<double>();
  if (!(error < 1e-5)) return state.SkipWithError("fast and plain outputs differ");
  state.counters["error"] = error;
  for (auto _ : state) benchmark::DoNotOptimize(network.forward(in.past, in.noise, kFrames).features);
}

/// What the futures follow, by itself.
void memory(benchmark::State& state) {
  const Input in(state.range(0));
  at::set_num_threads(static_cast<int>(state.range(1)));
  const anticipate::FastFutures network(in.networks);
  for (auto _ : state) benchmark::DoNotOptimize(network.follow(in.past, in.noise, kFrames).features);
}

/// The decoder's products of one frame, all rows at once, as often as there are frames.
void products(benchmark::State& state) {
  const int64_t samples = state.range(0), hidden = anticipate::Config().hidden;
  at::set_num_threads(static_cast<int>(state.range(1)));
  const torch::NoGradGuard no_gradients;
  const Tensor x = torch::randn({samples, hidden});
  std::vector<Tensor> weights;
  weights.push_back(
      torch::randn({2 * anticipate::kFeatureCount + anticipate::Config().intention_features, 3 * hidden}));
  for (int i = 0; i < 5; ++i) weights.push_back(torch::randn({hidden, 3 * hidden}));
  weights.push_back(torch::randn({hidden, anticipate::kFeatureCount}));
  std::vector<Tensor> out;
  for (const Tensor& w : weights) out.push_back(torch::empty({samples, w.size(1)}));
  for (auto _ : state)
    for (int64_t t = 0; t < kFrames; ++t)
      for (size_t i = 0; i < weights.size(); ++i) at::mm_out(out[i], x.slice(1, 0, weights[i].size(0)), weights[i]);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"futures", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
  for (const int64_t futures : {1, 50})
    for (const int64_t threads : {1, 2}) b->Args({futures, threads});
}
BENCHMARK(plain)->Name("futures/plain")->Apply(sizes);
BENCHMARK(fast)->Name("futures/fast")->Apply(sizes);
BENCHMARK(memory)->Name("futures/memory")->Apply(sizes);
BENCHMARK(products)->Name("futures/products")->Apply(sizes);

}  // namespace

int main(int argc, char** argv) {
  start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
