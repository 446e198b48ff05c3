// Mish with its gradient over what a training batch of the in-betweening network holds at its first level: tensor
// operators and ours.
#include "inhabit/nn/mish.h"

#include <ATen/Parallel.h>
#include <benchmark/benchmark.h>
#include <torch/torch.h>

namespace {

using torch::Tensor;

template <Tensor (*activation)(const Tensor&)>
void both_ways(benchmark::State& state) {
  torch::manual_seed(1);
  at::set_num_threads(static_cast<int>(state.range(0)));
  const Tensor x = torch::randn({32, 96, 128}).requires_grad_(), gradient = torch::randn_like(x);
  for (auto _ : state) benchmark::DoNotOptimize(torch::autograd::grad({activation(x)}, {x}, {gradient})[0]);
}

Tensor plain(const Tensor& x) { return torch::mish(x); }

BENCHMARK_TEMPLATE(both_ways, plain)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_TEMPLATE(both_ways, inhabit::nn::mish)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
