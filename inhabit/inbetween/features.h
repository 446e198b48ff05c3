#pragma once
#include <torch/types.h>

#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/motion/clip.h"
#include "inhabit/nn/feature_scale.h"

namespace inhabit::inbetween {

// A frame is 201 numbers in the canonical frame (the first root above the origin, facing +Z): root joint (3, metres),
// root orientation (6D), the 21 other joints' rotations (6D, each relative to its parent), 22 joint positions (metres).
inline constexpr int64_t kOrientFeature = 3,  ///< where the root orientation begins
    kBodyFeature = 9,                         ///< where the other joints' rotations begin
    kJointFeature = 135;                      ///< where the joint positions begin

/// (T, 201) of a clip on the standard skeleton, which has rotations; in the frame that the clip is in.
torch::Tensor clip_features(const Clip& clip);

/// Local rotations (..., 22, 3, 3) of features (..., 201).
torch::Tensor feature_rotations(const torch::Tensor& features);

/// Joint positions (..., T, 22, 3) by forward kinematics from the features' rotations and root.
/// @param features (..., T, 201); @param offsets (..., 22, 3) metres, the bones of each person.
torch::Tensor feature_joints(const torch::Tensor& features, const torch::Tensor& offsets);

/// `like` with the motion of `features` (T, 201): rotations, trans, and joints by forward kinematics.
Clip clip_of_features(const torch::Tensor& features, const Clip& like);

/// The same motion with other rest frames: the frame of joint j at rest is rotated by A_j = rotations[j] (22, 3, 3), as
/// another body model or recording may define it. R_j becomes A_parent^T R_j A_j; `bones` (22, 3) are changed to
/// A_parent^T bone_j. Joint positions stay.
torch::Tensor with_rest_frames_rotated(const torch::Tensor& features, const torch::Tensor& rotations,
                                       torch::Tensor& bones);

/// interpolate_keys (sampler.h) with rotations by slerp over the shorter arc. Linear interpolation of 6D features
/// degenerates between rotations that are far apart: the result is near zero and stands for an arbitrary rotation.
/// @param scale what `constraints` is standardised by.
torch::Tensor interpolated_baseline(const KeyConstraints& constraints, const FeatureScale& scale);

/// Adds noise of `level` to features (T, 201): normal, with a standard deviation of `level` degrees for every component
/// of a rotation and `level` centimetres for every component of the root; joints by forward kinematics. The first and
/// the last frame stay clean (section 4). @param bones (22, 3) metres.
torch::Tensor noisy_features(const torch::Tensor& features, const torch::Tensor& bones, double level,
                             std::mt19937_64& random);

/// A body's measures at rest (7) metres: pelvis to head, shoulder to shoulder, left shoulder to wrist, hip to hip,
/// pelvis to left foot, depth of the chest, depth of the hips (supplement 7.3).
/// @param betas (B') or undefined for the mean shape.
torch::Tensor body_shape_features(const BodyModel& model, const torch::Tensor& betas);

}  // namespace inhabit::inbetween
