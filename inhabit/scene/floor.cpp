#include "inhabit/scene/floor.h"

#include <cmath>

#include "inhabit/math/quantile.h"
#include "inhabit/motion/floor.h"

namespace inhabit {

using torch::Tensor;

namespace {

constexpr double kAbove = 0.3, kNear = 0.3;  // metres: rays start above the feet; a floor is no farther from theirs
constexpr double kAround = 0.25;             // metres on the ground: points of a cloud that are below a foot
constexpr int64_t kPlaces = 64;              // of feet that are looked at
constexpr double kLeast = 0.25;              // of the places must be above something

}  // namespace

double floor_under(const Clip& poses, const SceneQuery& scene) {
  const double assumed = floor_under(poses);
  const Tensor balls = poses.joints.slice(1, 10, 12).reshape({-1, 3});  // of the standard joints
  const int64_t step = (balls.size(0) + kPlaces - 1) / kPlaces;
  Tensor from = balls.slice(0, 0, balls.size(0), step).to(torch::kFloat32).contiguous().clone();
  const Tensor down = torch::tensor({0.F, -1.F, 0.F}).expand_as(from).contiguous();
  from.select(1, 1).clamp_min_(assumed).add_(kAbove);
  std::vector<double> heights;
  const RayHits below = scene.cast(from, down);
  const Tensor hits = below.points.index({below.hit}).select(1, 1).contiguous();
  for (int64_t i = 0; i < hits.numel(); ++i) heights.push_back(static_cast<double>(hits.data_ptr<float>()[i]));
  std::erase_if(heights, [&](double y) { return std::abs(y - assumed) > kNear; });
  if (static_cast<double>(heights.size()) >= kLeast * static_cast<double>(from.size(0))) return median(heights);

  heights.clear();
  for (const Eigen::Vector3f& point : scene.solid().points) {
    const auto y = static_cast<double>(point.y());
    if (std::abs(y - assumed) > kNear / 2) continue;
    for (int64_t i = 0; i < from.size(0); ++i) {
      const float* p = from.data_ptr<float>() + 3 * i;
      if (std::hypot(point.x() - p[0], point.z() - p[2]) > kAround) continue;
      heights.push_back(y);
      break;
    }
  }
  return heights.empty() ? assumed : median(heights);
}

Scene assumed_floor(const Clip& clip) {
  const Tensor path = clip.root_path(), low = std::get<0>(path.min(0)), high = std::get<0>(path.max(0)),
               middle = (low + high) / 2;
  Scene scene =
      floor_scene(12.0 + (high - low).max().item<double>(), middle[0].item<double>(), middle[2].item<double>());
  scene.meshes[0].vertices.select(1, 1).add_(floor_under(clip));
  return scene;
}

Scene raised(const Scene& scene, double by) {
  Scene out = scene;
  const torch::Tensor up = torch::tensor({0.F, static_cast<float>(by), 0.F});
  for (Mesh& mesh : out.meshes) mesh.vertices = mesh.vertices + up;
  if (out.points.defined()) out.points = out.points + up;
  return out;
}

}  // namespace inhabit
