// Where the surfaces of a scene are: scene_queries SCENE
#include <inhabit/io/scene_file.h>
#include <inhabit/scene/query.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const inhabit::SceneQuery query(inhabit::read_scene_file(argv[1]).scene);
  const torch::Tensor points = torch::tensor({{0.F, 1.F, 0.F}, {0.F, 0.1F, 0.F}, {0.5F, 0.4F, 0.5F}});  // metres
  const inhabit::ClosestPoints nearest = query.closest(points);
  const torch::Tensor inside = query.inside(points);
  for (int64_t i = 0; i < points.size(0); ++i)
    std::printf("point %lld: %.2f m to the nearest surface, %s\n", static_cast<long long>(i),
                nearest.distances[i].item<double>(), inside[i].item<bool>() ? "inside" : "outside");

  const torch::Tensor from = torch::tensor({{0.F, 1.5F, 0.F}}), down = torch::tensor({{0.F, -1.F, 0.F}});
  std::printf("the ray down meets a surface after %.2f m\n", query.cast(from, down).distances[0].item<double>());
}
