#include "inhabit/body/proportions.h"

namespace inhabit {

std::array<Eigen::Vector3d, kStandardJoints> builtin_rest_joints() {
  constexpr double h = kBuiltinStature, floor = -kBuiltinPelvisHeight;
  // Fractions of stature (Winter, figure 4.1): hip 0.530, knee 0.285, shoulder 0.818, upper arm 0.186, forearm 0.146.
  // The hip landmark is the greater trochanter's top, 1.5 cm above the joint's centre; the ankle joint lies above the
  // malleolus line used there; the shoulder's centre is 4 cm inside and 1 cm below the acromion (0.129 from the
  // middle), so the upper arm from centre to centre is 3.5 cm shorter than from the acromion.
  const double hip = floor + 0.530 * h - 0.015, knee = floor + 0.285 * h, ankle = floor + 0.080;
  const double shoulder_x = 0.129 * h - 0.040, shoulder_y = floor + 0.818 * h - 0.010;
  const double elbow_x = shoulder_x + 0.186 * h - 0.035, wrist_x = elbow_x + 0.146 * h;
  std::array<Eigen::Vector3d, kStandardJoints> p;
  p[0] = {0, 0, 0};
  p[3] = {0, 0.105, -0.020};
  p[6] = {0, 0.230, -0.022};
  p[9] = {0, 0.288, -0.008};
  p[12] = {0, 0.490, -0.040};
  p[15] = {0, 0.578, 0.004};
  for (int side = 0; side < 2; ++side) {
    const double x = side == 0 ? 1 : -1;
    p[1 + side] = {x * 0.085, hip, 0.002};
    p[4 + side] = {x * 0.096, knee, 0.006};
    p[7 + side] = {x * 0.100, ankle, -0.032};
    p[10 + side] = {x * 0.114, floor + 0.025, 0.098};
    p[13 + side] = {x * 0.072, 0.407, -0.022};
    p[16 + side] = {x * shoulder_x, shoulder_y, -0.036};
    p[18 + side] = {x * elbow_x, shoulder_y - 0.006, -0.046};
    p[20 + side] = {x * wrist_x, shoulder_y, -0.044};
  }
  return p;
}

std::array<Eigen::Vector3d, kStandardJoints> builtin_joint_direction(BuiltinBeta beta) {
  const auto rest = builtin_rest_joints();
  const auto& parents = standard_parents();
  std::array<Eigen::Vector3d, kStandardJoints> direction;
  for (int j = 0; j < kStandardJoints; ++j) {
    if (j == 0) {
      direction[j].setZero();
      continue;
    }
    const Eigen::Vector3d offset = rest[j] - rest[parents[j]];
    Eigen::Vector3d change = Eigen::Vector3d::Zero();  // of the offset from the parent
    const bool leg_bone = j == 4 || j == 5 || j == 7 || j == 8;
    const bool arm_bone = j >= 18;
    const bool spine_bone = j == 3 || j == 6 || j == 9 || j == 12;
    if (beta == kStature) change = 0.04 * offset;
    if (beta == kLegs && leg_bone) change = 0.04 * offset;
    if (beta == kArms && arm_bone) change = 0.04 * offset;
    if (beta == kTorso && spine_bone) change = 0.04 * offset;
    if (beta == kTorso && (j == 13 || j == 14))
      change.y() = 0.04 * offset.y();  // collars keep their height on the spine
    if (beta == kShoulders && (j == 13 || j == 14 || j == 16 || j == 17)) change.x() = 0.045 * offset.x();
    if (beta == kHips && (j == 1 || j == 2)) change.x() = 0.06 * offset.x();
    direction[j] = direction[parents[j]] + change;
  }
  return direction;
}

}  // namespace inhabit
