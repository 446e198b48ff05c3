#include "inhabit/io/upright.h"

#include "inhabit/math/rotation.h"

namespace inhabit {

void turn_upright(Clip& clip) {
  using torch::Tensor;
  const Tensor turn = torch::tensor({1.F, 0.F, 0.F, 0.F, 0.F, 1.F, 0.F, -1.F, 0.F}).view({3, 3});
  auto turned = [&](const Tensor& points) { return points.matmul(turn.t()); };
  const Tensor root = clip.skeleton.offsets.defined() ? clip.skeleton.offsets[0] : torch::zeros({3});
  if (clip.joints.defined()) clip.joints = turned(clip.joints);
  if (clip.trans.defined()) clip.trans = turned(clip.trans + root) - root;
  if (clip.rotations.defined()) {
    clip.rotations = clip.rotations.clone();
    clip.rotations.select(1, 0).copy_(
        matrix_to_axis_angle(turn.matmul(axis_angle_to_matrix(clip.rotations.select(1, 0)))));
  }
  if (clip.hand_targets.defined()) {
    clip.hand_targets = clip.hand_targets.clone();
    clip.hand_targets.narrow(2, 0, 3).copy_(turned(clip.hand_targets.narrow(2, 0, 3)));
  }
  if (clip.object_pose.defined() && clip.object_pose.numel() > 0) {
    const Tensor place = turned(clip.object_pose.narrow(2, 0, 3));
    const Tensor angle = matrix_to_axis_angle(turn.matmul(axis_angle_to_matrix(clip.object_pose.narrow(2, 3, 3))));
    clip.object_pose = torch::cat({place, angle}, 2);
  }
}

}  // namespace inhabit
