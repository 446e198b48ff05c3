#pragma once
#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/motion/clip.h"

namespace inhabit {

/// Somebody who strides along +Z at 1 m/s from (x, z), arms and legs swinging.
inline Clip striding(int64_t frames, double x, double z, int64_t from = 0) {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.rotations = torch::zeros({frames, kStandardJoints, 3});
  const torch::Tensor seconds = torch::arange(from, from + frames).to(torch::kFloat32) / 30.0;
  const torch::Tensor swing = torch::sin(seconds * 6.0);
  clip.rotations.select(2, 0).select(1, 1).copy_(0.4 * swing);
  clip.rotations.select(2, 0).select(1, 2).copy_(-0.4 * swing);
  clip.rotations.select(2, 0).select(1, 4).copy_(0.35 * (1 - swing));
  clip.rotations.select(2, 0).select(1, 5).copy_(0.35 * (1 + swing));
  clip.rotations.select(2, 2).select(1, 16).fill_(-1.2);
  clip.rotations.select(2, 2).select(1, 17).fill_(1.2);
  clip.rotations.select(2, 1).select(1, 0).copy_(0.2 * swing);
  clip.trans = torch::stack({torch::full({frames}, x), torch::zeros({frames}), seconds + z}, 1).to(torch::kFloat32);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const torch::Tensor lift = -clip.joints.select(2, 1).min() + 0.02;
  clip.trans.select(1, 1).add_(lift);
  clip.joints.select(2, 1).add_(lift);
  return clip;
}

}  // namespace inhabit
