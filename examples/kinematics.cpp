// Forward kinematics of the built-in body: the right knee bent by a right angle.
#include <inhabit/body/body_model.h>
#include <inhabit/body/kinematics.h>

#include <cstdio>

int main() {
  const inhabit::Skeleton& skeleton = inhabit::builtin_body().skeleton;
  torch::Tensor rotations = torch::zeros({1, skeleton.size(), 3});  // (T, J, 3) axis-angle
  rotations[0][skeleton.find("right_knee")][0] = 1.5707963F;
  const torch::Tensor joints = inhabit::joint_positions(skeleton, rotations, torch::zeros({1, 3}))[0];
  const torch::Tensor shank = joints[skeleton.find("right_ankle")] - joints[skeleton.find("right_knee")];
  std::printf("ankle behind the knee: %.3f of the shank\n", -(shank[2] / shank.norm()).item<double>());
}
