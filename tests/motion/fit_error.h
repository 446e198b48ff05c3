#pragma once
#include "inhabit/body/kinematics.h"
#include "inhabit/motion/clip.h"

/// How far the posed skeleton is from `joints`: metres over all frames and joints.
struct FitError {
  double mean = 0, max = 0;
};
inline FitError fit_error(const inhabit::Clip& clip) {
  const torch::Tensor posed = inhabit::joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const torch::Tensor error = (posed - clip.joints).norm(2, -1);
  return {error.mean().item<double>(), error.max().item<double>()};
}
