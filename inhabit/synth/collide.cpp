#include "inhabit/synth/collide.h"

#include <algorithm>

namespace inhabit {

using Eigen::Vector3d;

double capsule_in_box(const Vector3d& a, const Vector3d& b, double radius, const Box& box) {
  constexpr int kSamples = 8;
  double nearest = 1e9;
  for (int k = 0; k <= kSamples; ++k) {
    const Vector3d p = a + (b - a) * (static_cast<double>(k) / kSamples);
    const Vector3d out = (p - box.center).cwiseAbs() - box.half;
    nearest = std::min(nearest, out.cwiseMax(0).norm() + std::min(out.maxCoeff(), 0.0));
  }
  return std::max(0.0, radius - nearest);
}

double deepest_in(const Furniture& piece, const std::vector<Capsule>& capsules, const Performance& performance) {
  const Eigen::Isometry3d to_own = piece.pose.inverse();
  const Eigen::AlignedBox3d bounds = piece.bounds();
  double deepest = 0;
  for (const Posed& pose : performance.pose)
    for (const Capsule& c : capsules) {
      if (c.joint >= kStandardJoints) continue;
      const Vector3d& at = pose.position[c.joint];
      const Eigen::Quaterniond& rotation = pose.global[c.joint];
      const Vector3d a = to_own * (at + rotation * Vector3d(c.a[0], c.a[1], c.a[2]));
      const Vector3d b = to_own * (at + rotation * Vector3d(c.b[0], c.b[1], c.b[2]));
      if (bounds.exteriorDistance(a) > (b - a).norm() + c.radius) continue;
      for (const Box& box : piece.boxes) deepest = std::max(deepest, capsule_in_box(a, b, c.radius, box));
    }
  return deepest;
}

double deepest_collision(const Room& room, const std::vector<Capsule>& capsules, const Performance& performance) {
  struct SolidBox {
    Box box;
    Eigen::Isometry3d to_own;
    int furniture;
  };
  std::vector<SolidBox> solids;
  auto add = [&](const Box& box, const Eigen::Isometry3d& pose, int furniture) {
    solids.push_back({box, pose.inverse(), furniture});
  };
  for (const Box& wall : room.walls) add(wall, Eigen::Isometry3d::Identity(), -2);
  for (size_t f = 0; f < room.furniture.size(); ++f)
    for (const Box& box : room.furniture[f].boxes) add(box, room.furniture[f].pose, static_cast<int>(f));

  constexpr double kBodyReach = 1.3;  // from the root to the farthest part
  double deepest = 0;
  for (size_t t = 0; t < performance.pose.size(); ++t) {
    const Posed& pose = performance.pose[t];
    for (const SolidBox& solid : solids) {
      if (solid.furniture == performance.seat[t]) continue;
      // A box's middle may be far along a wall: distance to the box itself decides.
      const Vector3d root = solid.to_own * pose.position[0];
      const Vector3d out = (root - solid.box.center).cwiseAbs() - solid.box.half;
      if (out.cwiseMax(0).squaredNorm() > kBodyReach * kBodyReach) continue;
      for (const Capsule& c : capsules) {
        if (c.joint >= kStandardJoints) continue;
        const Vector3d& at = pose.position[c.joint];
        const Eigen::Quaterniond& rotation = pose.global[c.joint];
        const Vector3d a = solid.to_own * (at + rotation * Vector3d(c.a[0], c.a[1], c.a[2]));
        const Vector3d b = solid.to_own * (at + rotation * Vector3d(c.b[0], c.b[1], c.b[2]));
        deepest = std::max(deepest, capsule_in_box(a, b, c.radius, solid.box));
      }
    }
  }
  return deepest;
}

}  // namespace inhabit
