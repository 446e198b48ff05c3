#pragma once
#include <torch/types.h>

#include "inhabit/body/body_model.h"

namespace inhabit {

/// How fit_body() looks for a body.
struct FitOptions {
  torch::Tensor weights;     ///< (22) how much each joint's error counts; undefined: all 1
  torch::Tensor betas;       ///< shape of the body; undefined: the mean, or found where fit_shape is set
  bool fit_shape = false;    ///< finds betas from the clip's median bone lengths
  double smoothness = 0.02;  ///< metres of joint error that weigh as much as a rotation of one radian between frames
};

/// What a fit found.
struct BodyFit {
  torch::Tensor rotations;  ///< (T, J, 3) axis-angle; zero for joints beyond the standard 22
  torch::Tensor trans;      ///< (T, 3)
  torch::Tensor betas;      ///< as given or found; undefined for the mean shape
  double mean_error = 0;    ///< metres, mean distance of the body's joints from the targets
  double max_error = 0;     ///< metres, the largest
};

/// The rotations that bring a body's first 22 joints nearest to `joints` (T, 22 or more, 3) metres, in closed form,
/// frame by frame, some ten microseconds each. Pelvis and chest are carried onto their joints as a whole (Kabsch);
/// every other bone points from where its joint came out at its target, so that a joint is off by no more than the
/// error of the bone's length. Spine and neck share the twist between pelvis and chest. Thighs and upper arms are
/// twisted so that knees and elbows bend as hinges do, by the planes of the limbs in this and neighbouring frames;
/// straight limbs are twisted as at rest. Joints at the ends (head, wrists, balls of the feet) keep their parents'
/// orientation.
/// @param betas (B) shape of the body; undefined: the mean. Throws Error as fit_body().
BodyFit fit_rotations(const BodyModel& model, const torch::Tensor& joints, const torch::Tensor& betas = {});

/// The same over all frames of a clip together, some thirty times slower: from fit_rotations() on, Levenberg-Marquardt
/// minimises joint error, rotation between frames, rotation beyond the model's joint limits, and twist, which positions
/// do not determine. For joints with noise, whose bone lengths may differ from the body's and from frame to frame.
/// Throws Error on wrong shapes or numbers that are not finite.
BodyFit fit_body(const BodyModel& model, const torch::Tensor& joints, const FitOptions& options = {});

/// Shape parameters (B) whose bone lengths come nearest to those of `joints` (T, 22 or more, 3): medians over the clip,
/// with a pull towards the mean shape of one standard deviation for a length error of 3 mm; none beyond 3 deviations.
torch::Tensor fit_shape(const BodyModel& model, const torch::Tensor& joints);

}  // namespace inhabit
