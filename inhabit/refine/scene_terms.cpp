#include "inhabit/refine/scene_terms.h"

#include <algorithm>
#include <cmath>

#include "inhabit/body/capsules.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kSpacing = 0.06;
// Metres: as metrics/collision.h has it for the skin, with some to spare.
constexpr double kSupportedGive = 0.03, kGive = 0.005;

/// Pelvis, thighs, spine, forearms and hands: what is sat, leaned and rested on.
bool supports(int joint) {
  constexpr std::array<int, 10> kJoints = {0, 1, 2, 3, 6, 9, 18, 19, 20, 21};
  return std::find(kJoints.begin(), kJoints.end(), joint) != kJoints.end();
}

}  // namespace

std::vector<BodyBall> body_balls(const BodyModel& body, const torch::Tensor& betas) {
  std::vector<BodyBall> out;
  for (const Capsule& c : shaped_capsules(body, betas)) {
    const Vector3d a(c.a[0], c.a[1], c.a[2]), b(c.b[0], c.b[1], c.b[2]);
    const int count = 1 + static_cast<int>(std::ceil((b - a).norm() / kSpacing));
    for (int i = 0; i < count; ++i) {
      const double along = count == 1 ? 0 : static_cast<double>(i) / (count - 1);
      out.push_back({{Attachment{c.joint, 1, a + along * (b - a)}},
                     static_cast<double>(c.radius),
                     supports(c.joint) ? kSupportedGive : kGive});
    }
  }
  return out;
}

Surroundings::Surroundings(const Scene& scene) {
  Scene solid;
  bool faces = false;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.faces.size(0) == 0) continue;
    faces = true;
    if (!is_floor(mesh.name)) solid.meshes.push_back(mesh);
  }
  if (faces) ground_ = std::make_unique<SceneQuery>(scene);
  if (!solid.meshes.empty()) solid_ = std::make_unique<SceneQuery>(solid);
}

Surroundings::~Surroundings() = default;

std::vector<double> Surroundings::floor_under(const Track& places) const {
  constexpr double kAbove = 0.3, kBelow = 1;
  std::vector<double> out(places.size(), std::nan(""));
  if (ground_ == nullptr) return out;
  torch::Tensor from = point_rows(places);
  from.select(1, 1).add_(kAbove);
  const torch::Tensor down = torch::tensor({0.F, -1.F, 0.F}).expand_as(from).contiguous();
  const RayHits hits = ground_->cast(from, down, kAbove + kBelow);
  for (size_t i = 0; i < out.size(); ++i) {
    const auto row = static_cast<int64_t>(i);
    if (hits.hit[row].item<bool>()) out[i] = hits.points[row][1].item<double>();
  }
  return out;
}

std::vector<PlaneTerm> Surroundings::planes(const std::vector<BodyBall>& balls, int first_ball, const Poses& poses,
                                            double reach, double weight) const {
  std::vector<PlaneTerm> out;
  if (solid_ == nullptr) return out;
  // A person is within 1.3 m of the pelvis: frames farther from everything have nothing to ask.
  constexpr double kBody = 1.3;
  std::vector<Vector3d> roots;
  for (const BonesPose& pose : poses) roots.push_back(pose.positions[0]);
  const torch::Tensor far = solid_->closest(point_rows(roots)).distances;
  std::vector<Vector3d> places;
  std::vector<std::pair<int64_t, size_t>> of;
  for (size_t t = 0; t < poses.size(); ++t) {
    if (far[static_cast<int64_t>(t)].item<double>() > kBody + reach) continue;
    for (size_t i = 0; i < balls.size(); ++i) {
      places.push_back(place_of(balls[i].point, poses[t]));
      of.emplace_back(static_cast<int64_t>(t), i);
    }
  }
  if (places.empty()) return out;
  const torch::Tensor asked = point_rows(places);
  const ClosestPoints closest = solid_->closest(asked);
  // Only what is near enough to matter, or deep inside, is worth asking which side it is on.
  constexpr double kDeepest = 0.25;
  std::vector<int64_t> near;
  const float* distances = closest.distances.data_ptr<float>();
  for (size_t i = 0; i < of.size(); ++i)
    if (distances[i] < std::max(kDeepest, balls[of[i].second].radius + reach)) near.push_back(static_cast<int64_t>(i));
  if (near.empty()) return out;
  const torch::Tensor inside = solid_->inside(asked.index_select(0, torch::tensor(near)));
  for (size_t k = 0; k < near.size(); ++k) {
    const auto i = static_cast<size_t>(near[k]);
    const auto& [frame, ball] = of[i];
    const bool is_inside = inside[static_cast<int64_t>(k)].item<bool>();
    if (!is_inside && distances[i] > balls[ball].radius + reach) continue;
    const float* q = closest.points.data_ptr<float>() + 3 * i;
    const Vector3d surface(q[0], q[1], q[2]);
    Vector3d normal = (places[i] - surface) * (is_inside ? -1 : 1);
    if (normal.norm() < 1e-4) {  // on the surface: the face says where out is, as far as it knows
      const float* n = closest.normals.data_ptr<float>() + 3 * i;
      normal = Vector3d(n[0], n[1], n[2]);
    }
    if (normal.norm() < 1e-6) continue;
    normal.normalize();
    out.push_back({frame, first_ball + static_cast<int>(ball), normal,
                   normal.dot(surface) + balls[ball].radius - balls[ball].give, weight, false});
  }
  return out;
}

}  // namespace inhabit::refine
