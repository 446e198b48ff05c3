#pragma once
#include <torch/types.h>

#include "inhabit/forecast/config.h"

namespace inhabit::forecast {

/// DCT coefficients of the padded past contact maps (Eq. 1-5), the contact network's input: (B, L*J, N), coefficient l
/// of joint j in row l*J + j. No gradients.
/// @param scene (B, N, 3) metres; @param past (B, P, J, 3) world joints.
torch::Tensor contact_features(const torch::Tensor& scene, const torch::Tensor& past, const Config& config);

/// DCT coefficients (B, L*J, N) of the contact maps of a whole motion (B, P+T, J, 3), in the same layout: what the
/// contact network is to predict. The DCT is orthonormal, so the squared error of the maps (Eq. 7) is the squared error
/// of these coefficients plus a constant (what the maps hold beyond the first L): training needs no maps.
torch::Tensor contact_targets(const torch::Tensor& scene, const torch::Tensor& joints, const Config& config);

/// Contact maps (B, frames, joints, N), frames = P+T, that coefficients (B, L*J, N) stand for (Eq. 5). Differentiable.
torch::Tensor contact_maps_from_dct(const torch::Tensor& contact_dct, int64_t frames, int64_t joints);

/// Contact points (B, T, J, 4) of the future frames: the scene point of largest contact value (the first of equals) and
/// 1 where that value exceeds the threshold, else zeros.
/// @param contact_dct (B, L*J, N) predicted coefficients; @param scene (B, N, 3).
torch::Tensor contact_points(const torch::Tensor& scene, const torch::Tensor& contact_dct, const Config& config);

/// Contact points (B, T, J, 4) of a motion that is known: the scene point closest to each joint, where its contact
/// value exceeds the threshold. @param joints (B, T, J, 3) world.
torch::Tensor true_contact_points(const torch::Tensor& scene, const torch::Tensor& joints, const Config& config);

/// Ankles and balls of the feet among the standard joints: (22) bool.
torch::Tensor foot_joints();

}  // namespace inhabit::forecast
