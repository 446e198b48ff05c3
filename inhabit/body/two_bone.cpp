#include "inhabit/body/two_bone.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/quaternion.h"

namespace inhabit {

TwoBone solve_two_bone(const Eigen::Vector3d& start, double upper_length, double lower_length,
                       const Eigen::Vector3d& target, const Eigen::Vector3d& pole, double softness) {
  const double full = upper_length + lower_length;
  const Eigen::Vector3d to_target = target - start;
  double distance = to_target.norm();
  const Eigen::Vector3d along =
      distance > 1e-9 ? Eigen::Vector3d(to_target / distance) : Eigen::Vector3d(-Eigen::Vector3d::UnitY());
  const double slack = softness * full, exact = full - slack;
  if (distance > exact) distance = slack > 0 ? exact + slack * (1 - std::exp(-(distance - exact) / slack)) : full;
  distance = std::max({distance, std::abs(upper_length - lower_length), 1e-6});

  Eigen::Vector3d side = pole - pole.dot(along) * along;
  if (side.squaredNorm() < 1e-12) side = along.unitOrthogonal();
  side.normalize();
  const double x = (upper_length * upper_length - lower_length * lower_length + distance * distance) / (2 * distance);
  const double y = std::sqrt(std::max(0.0, upper_length * upper_length - x * x));
  return {start + x * along + y * side, start + distance * along, side.cross(along)};
}

Limb leg(Side side) {
  return side == Side::left ? Limb{1, 4, 7, Eigen::Vector3d::UnitZ()} : Limb{2, 5, 8, Eigen::Vector3d::UnitZ()};
}

Limb arm(Side side) {
  return side == Side::left ? Limb{16, 18, 20, -Eigen::Vector3d::UnitZ()} : Limb{17, 19, 21, -Eigen::Vector3d::UnitZ()};
}

LimbPose solve_limb(const Bones& bones, const Limb& limb, const Eigen::Quaterniond& parent_rotation,
                    const Eigen::Vector3d& start, const Eigen::Vector3d& target, const Eigen::Vector3d& pole,
                    double softness) {
  const Eigen::Vector3d &upper = bones.offsets[limb.mid], &lower = bones.offsets[limb.end];
  LimbPose pose;
  pose.joints = solve_two_bone(start, upper.norm(), lower.norm(), target, pole, softness);
  const Eigen::Vector3d upper_now = pose.joints.mid - start, lower_now = pose.joints.end - pose.joints.mid;
  // The hinge, not the pole, fixes the twist: at rest it is normal to the upper bone and the rest pole, now to the
  // bending plane. One axis for both bones makes the middle joint rotate about that axis alone.
  const Eigen::Vector3d rest_hinge = limb.rest_pole.cross(upper);
  pose.start_global = rotation_between_frames(upper, rest_hinge, upper_now, pose.joints.hinge);
  pose.mid_global = rotation_between_frames(lower, rest_hinge, lower_now, pose.joints.hinge);
  pose.start_rotation = parent_rotation.conjugate() * pose.start_global;
  pose.mid_rotation = pose.start_global.conjugate() * pose.mid_global;
  return pose;
}

void move_limb_end(const Bones& bones, const Limb& limb, const Eigen::Vector3d& move, const BonesPose& pose,
                   std::vector<Eigen::Quaterniond>& local) {
  const Eigen::Vector3d &start = pose.positions[limb.start], &mid = pose.positions[limb.mid],
                        &end = pose.positions[limb.end];
  const Eigen::Vector3d straight = end - start;
  Eigen::Vector3d pole =
      mid - start - straight * ((mid - start).dot(straight) / std::max(1e-12, straight.squaredNorm()));
  if (pole.norm() < 1e-3) pole = pose.rotations[limb.start] * limb.rest_pole;
  const TwoBone solved =
      solve_two_bone(start, bones.offsets[limb.mid].norm(), bones.offsets[limb.end].norm(), end + move, pole, 0);
  const Eigen::Quaterniond upper = Eigen::Quaterniond::FromTwoVectors(mid - start, solved.mid - start) *
                                   pose.rotations[limb.start],
                           lower = Eigen::Quaterniond::FromTwoVectors(end - mid, solved.end - solved.mid) *
                                   pose.rotations[limb.mid];
  const int parent = bones.parents[limb.start];
  local[limb.start] = (pose.rotations[parent].conjugate() * upper).normalized();
  local[limb.mid] = (upper.conjugate() * lower).normalized();
  local[limb.end] = (lower.conjugate() * pose.rotations[limb.end]).normalized();
}

}  // namespace inhabit
