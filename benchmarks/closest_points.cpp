// Closest points on a room's surface through SceneQuery, against looking at every triangle: same points, same answers.
// Run: closest_points_benchmark
#include <benchmark/benchmark.h>

#include "inhabit/scene/occupancy.h"
#include "inhabit/scene/query.h"
#include "inhabit/scene/sampling.h"
#include "inhabit/scene/triangle.h"

namespace {

using namespace inhabit;

/// A hilly ground of 2 n n triangles, 6 m on a side.
Scene ground(int64_t n) {
  const torch::Tensor step = torch::linspace(-3, 3, n + 1);
  const std::vector<torch::Tensor> at = torch::meshgrid({step, step}, "ij");
  Mesh mesh;
  mesh.vertices =
      torch::stack({at[0], 0.3 * torch::sin(3 * at[0]) * torch::cos(2 * at[1]), at[1]}, 2).view({-1, 3}).contiguous();
  const torch::Tensor first = (torch::arange(n).unsqueeze(1) * (n + 1) + torch::arange(n)).reshape({-1});
  mesh.faces = torch::cat(
      {torch::stack({first, first + 1, first + n + 2}, 1), torch::stack({first, first + n + 2, first + n + 1}, 1)});
  Scene scene;
  scene.meshes.push_back(std::move(mesh));
  return scene;
}

torch::Tensor near_points(int64_t count) {
  torch::manual_seed(1);
  return torch::rand({count, 3}) * torch::tensor({6.F, 2.F, 6.F}) - torch::tensor({3.F, 0.F, 3.F});
}

void closest_brute_force(benchmark::State& state) {
  const Solid solid = make_solid(ground(state.range(0)));
  const torch::Tensor points = near_points(1000);
  const float* p = points.data_ptr<float>();
  for (auto _ : state) {
    double sum = 0;
#pragma omp parallel for reduction(+ : sum)
    for (int64_t i = 0; i < 1000; ++i) {
      const Eigen::Vector3f at(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
      float best = HUGE_VALF;
      for (size_t f = 0; f < solid.faces.size(); ++f) {
        best = std::min(
            best, (closest_on_triangle<float>(at, solid.corner(f, 0), solid.corner(f, 1), solid.corner(f, 2)) - at)
                      .squaredNorm());
      }
      sum += static_cast<double>(std::sqrt(best));
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(closest_brute_force)->Arg(71)->Unit(benchmark::kMillisecond)->UseRealTime();

void closest_query(benchmark::State& state) {
  const SceneQuery query(ground(state.range(0)));
  const torch::Tensor points = near_points(1000);
  for (auto _ : state) benchmark::DoNotOptimize(query.closest(points).distances.data_ptr<float>());
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(closest_query)->Arg(71)->Arg(707)->Unit(benchmark::kMillisecond)->UseRealTime();

void signed_distance_query(benchmark::State& state) {
  const SceneQuery query(ground(state.range(0)));
  const torch::Tensor points = near_points(1000);
  for (auto _ : state) benchmark::DoNotOptimize(query.signed_distance(points).data_ptr<float>());
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(signed_distance_query)->Arg(71)->Arg(707)->Unit(benchmark::kMillisecond)->UseRealTime();

void build_query(benchmark::State& state) {
  const Scene scene = ground(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(SceneQuery(scene).solid().bodies);
}
BENCHMARK(build_query)->Arg(71)->Arg(707)->Unit(benchmark::kMillisecond)->UseRealTime();

void occupancy_default_grid(benchmark::State& state) {
  const Solid solid = make_solid(ground(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(occupancy_grid(solid, {0, 0.9, 0}, 0.3).data_ptr<float>());
}
BENCHMARK(occupancy_default_grid)->Arg(71)->Arg(707)->Unit(benchmark::kMillisecond)->UseRealTime();

void sample_5000_near(benchmark::State& state) {
  const Scene scene = ground(state.range(0));
  std::mt19937_64 random(1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        sample_points_near(scene, torch::tensor({0.F, 0.9F, 0.F}), 2.5, 5000, random).data_ptr<float>());
  }
}
BENCHMARK(sample_5000_near)->Arg(71)->Arg(707)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
