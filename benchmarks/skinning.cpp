// Skinning a 90-frame clip of the built-in body: the plain way is the full (V, J) weights times 3x4 transforms as one
// tensor product, which is what the differentiable path does. `levels` skins at the baseline of
// vector instructions and at the level in use by turns: `speedup` is the least time of the one over that of the other.
#include <benchmark/benchmark.h>

#include <chrono>

#include "inhabit/body/kinematics.h"
#include "inhabit/math/rotation.h"
#include "inhabit/math/simd.h"

namespace {

using namespace inhabit;

torch::Tensor poses(int64_t frames) {
  torch::manual_seed(1);
  return axis_angle_to_matrix(torch::randn({frames, 22, 3}) * 0.4);
}

void plain(benchmark::State& state) {
  const torch::NoGradGuard no_gradient;
  const BodyModel& body = builtin_body();
  const torch::Tensor rotations = poses(state.range(0)), trans = torch::zeros({state.range(0), 3});
  const torch::Tensor rest = body.joint_template;
  for (auto _ : state) {
    const Pose pose = forward_kinematics(body.skeleton.parents, body.skeleton.offsets, rotations, trans);
    const torch::Tensor shifts = pose.positions - pose.rotations.matmul(rest.unsqueeze(-1)).squeeze(-1);
    const torch::Tensor transforms = torch::cat({pose.rotations, shifts.unsqueeze(-1)}, -1).flatten(-2);
    const torch::Tensor blended = body.skin_weights.matmul(transforms).unflatten(-1, {3, 4});
    benchmark::DoNotOptimize(blended.narrow(-1, 0, 3).matmul(body.template_vertices.unsqueeze(-1)).squeeze(-1) +
                             blended.select(-1, 3));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

void fast(benchmark::State& state) {
  const torch::NoGradGuard no_gradient;
  const BodyModel& body = builtin_body();
  const torch::Tensor rotations = poses(state.range(0)), trans = torch::zeros({state.range(0), 3});
  for (auto _ : state) benchmark::DoNotOptimize(skin(body, {}, rotations, trans));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

/// By turns, so that other work on the machine slows both.
void levels(benchmark::State& state) {
  const torch::NoGradGuard no_gradient;
  const Simd chosen = simd_level();
  const BodyModel& body = builtin_body();
  const torch::Tensor rotations = poses(state.range(0)), trans = torch::zeros({state.range(0), 3});
  const auto seconds = [&](Simd level) {
    use_simd_level(level);
    const auto begin = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(skin(body, {}, rotations, trans));
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  double baseline = seconds(Simd::kBaseline), own = seconds(chosen);
  for (auto _ : state) {
    baseline = std::min(baseline, seconds(Simd::kBaseline));
    own = std::min(own, seconds(chosen));
  }
  use_simd_level(chosen);
  state.counters["baseline_ms"] = 1e3 * baseline;
  state.counters["chosen_ms"] = 1e3 * own;
  state.counters["speedup"] = baseline / own;
  state.SetLabel(simd_level_name(chosen));
}

}  // namespace

BENCHMARK(plain)->Arg(90)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(fast)->Arg(90)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(levels)->Arg(90)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_MAIN();
