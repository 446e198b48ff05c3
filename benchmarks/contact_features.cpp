// Contact maps and their DCT features at the paper's size: plain tensor operators against the fused loops.
#include <benchmark/benchmark.h>

#include "inhabit/forecast/features.h"
#include "inhabit/math/dct.h"
#include "room_cloud.h"

namespace {

using namespace inhabit;
using torch::Tensor;

struct Input {
  forecast::Config config = forecast::preset("paper");
  Tensor scene, past, contact;
  Input() {
    torch::manual_seed(1);
    scene = room_cloud(config.inference.points);
    past = somebody(config.past, config.joints);
    contact = forecast::contact_features(scene, past, config);
  }
};

Tensor plain_features(const Input& in) {
  torch::NoGradGuard no_gradients;
  const Tensor distance = (in.past.unsqueeze(3) - in.scene.unsqueeze(1).unsqueeze(1)).norm(2, 4);  // (1, P, J, N)
  const Tensor map = torch::exp(-0.5 * distance.square() / (in.config.sigma * in.config.sigma));
  const Tensor padded = torch::cat({map, map.slice(1, in.config.past - 1).expand({1, in.config.future, -1, -1})}, 1);
  return dct_matrix(in.config.frames(), in.config.contact_coefficients)
      .matmul(padded.flatten(2))
      .view({1, -1, in.scene.size(1)});
}

void plain(benchmark::State& state) {
  const Input in;
  for (auto _ : state) benchmark::DoNotOptimize(plain_features(in));
}
BENCHMARK(plain)->Name("contact_features/plain")->Unit(benchmark::kMillisecond)->UseRealTime();

void fused(benchmark::State& state) {
  const Input in;
  const double error = (plain_features(in) - in.contact).abs().max().item<double>();
  if (!(error < 1e-5)) return state.SkipWithError("fused and plain features differ");
  state.counters["error"] = error;
  for (auto _ : state) benchmark::DoNotOptimize(forecast::contact_features(in.scene, in.past, in.config));
}
BENCHMARK(fused)->Name("contact_features/fused")->Unit(benchmark::kMillisecond)->UseRealTime();

void plain_contact_points(benchmark::State& state) {
  const Input in;
  for (auto _ : state)
    benchmark::DoNotOptimize(forecast::contact_maps_from_dct(in.contact, in.config.frames(), in.config.joints).max(3));
}
BENCHMARK(plain_contact_points)->Name("contact_points/plain")->Unit(benchmark::kMillisecond)->UseRealTime();

void fused_contact_points(benchmark::State& state) {
  const Input in;
  for (auto _ : state) benchmark::DoNotOptimize(forecast::contact_points(in.scene, in.contact, in.config));
}
BENCHMARK(fused_contact_points)->Name("contact_points/fused")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
