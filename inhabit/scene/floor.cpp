#include "inhabit/scene/floor.h"

#include "inhabit/motion/feet.h"

namespace inhabit {

double floor_under(const Clip& poses, const SceneQuery&) { return floor_under(poses); }

Scene assumed_floor(const Clip& clip) {
  const torch::Tensor path = clip.root_path(), low = std::get<0>(path.min(0)), high = std::get<0>(path.max(0)),
                      middle = (low + high) / 2;
  Scene scene =
      floor_scene(12.0 + (high - low).max().item<double>(), middle[0].item<double>(), middle[2].item<double>());
  // The lowest joint is the ball of a foot, some 2 cm above the sole.
  const double floor = clip.joints.select(2, 1).min().item<double>() - 0.02;
  scene.meshes[0].vertices.select(1, 1).add_(floor);
  return scene;
}

}  // namespace inhabit
