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
inline constexpr int64_t kOrientFeature = 3, kBodyFeature = 9, kJointFeature = 135;

/// (T, 201) of a clip on the standard skeleton, which has rotations; in the frame that the clip is in.
torch::Tensor clip_features(const Clip& clip);

/// Local rotations (..., 22, 3, 3) that features (..., 201) name.
torch::Tensor feature_rotations(const torch::Tensor& features);

/// Joint positions (..., T, 22, 3) by forward kinematics from the features' rotations and root.
/// @param features (..., T, 201); @param offsets (..., 22, 3) metres, the bones of each person.
torch::Tensor feature_joints(const torch::Tensor& features, const torch::Tensor& offsets);

/// `like` with the motion that `features` (T, 201) name: rotations, trans, and joints by forward kinematics.
Clip clip_of_features(const torch::Tensor& features, const Clip& like);

/// The same motion of somebody whose joints' frames are turned by `turns` (22, 3, 3) at rest, as another body model or
/// recording may have them: R_j becomes A_parent^T R_j A_j, and so do `bones` (22, 3), which become A_parent^T bone_j.
/// Joint positions stay.
torch::Tensor with_rest_turned(const torch::Tensor& features, const torch::Tensor& turns, torch::Tensor& bones);

/// interpolate_given (sampler.h) with rotations by slerp, the short way round: 6D numbers on straight lines all but
/// vanish between poses that are turned far from each other, and name any rotation there. @param scale what `given` is
/// standardised by.
torch::Tensor interpolate_given_poses(const GivenFeatures& given, const FeatureScale& scale);

/// lead_to_given (sampler.h) over `lead` frames, with what a rotation is missed by made up for as a turn.
torch::Tensor lead_poses_to_given(const torch::Tensor& found, GivenFeatures given, int64_t lead,
                                  const FeatureScale& scale);

/// Features (T, 201) of noise level `level`: every rotation turned by `level` degrees and the root moved by `level`
/// centimetres (standard deviations of each component), joints by forward kinematics; first and last frame stay clean
/// (section 4). @param bones (22, 3) metres.
torch::Tensor noisy_features(const torch::Tensor& features, const torch::Tensor& bones, double level,
                             std::mt19937_64& random);

/// A body's measures at rest (7) metres: pelvis to head, shoulder to shoulder, left shoulder to wrist, hip to hip,
/// pelvis to left foot, depth of the chest, depth of the hips (supplement 7.3).
/// @param betas (B') or undefined for the mean shape.
torch::Tensor body_shape_features(const BodyModel& model, const torch::Tensor& betas);

}  // namespace inhabit::inbetween
