#pragma once
#include <torch/types.h>

#include "inhabit/forecast/config.h"
#include "inhabit/forecast/network.h"

namespace inhabit::forecast {

/// Eq. 7 from DCT coefficients: the basis is orthonormal, so the squared error of the first L coefficients differs from
/// that of the contact maps only by the energy above L, which no prediction can change. Mean over frames, joints and
/// points.
/// @param predicted, truth (B, J*L, N) coefficients over past + future frames.
torch::Tensor contact_map_loss(const torch::Tensor& predicted, const torch::Tensor& truth, const Config& config);

/// Terms of Eq. 13, each a scalar.
struct MotionLosses {
  torch::Tensor root;     ///< Eq. 10
  torch::Tensor local;    ///< Eq. 11
  torch::Tensor contact;  ///< Eq. 12
  torch::Tensor total;    ///< Eq. 13
};

/// @param future (B, T, J, 3) true joints; @param contact_points (B, T, J, 4) true contact points.
MotionLosses motion_losses(const MotionForecast& forecast, const torch::Tensor& future,
                           const torch::Tensor& contact_points, const Config& config);

/// Terms of the articulated network's loss, each a scalar. They are what evaluations measure: distances, not their
/// squares, so that a future that goes one way or another is not drawn to the middle.
struct ArticulatedLosses {
  torch::Tensor path;      ///< metres, mean distance of the root
  torch::Tensor pose;      ///< metres, mean distance of the other joints relative to the root
  torch::Tensor contact;   ///< Eq. 12, with true contact points whatever the network is conditioned on
  torch::Tensor velocity;  ///< metres a frame, mean distance between steps of joints; the first is from the last pose
  torch::Tensor total;     ///< their sum by config.training's weights
};

/// @param last (B, J, 3) the last observed joints, future (B, T, J, 3) and contact_points (B, T, J, 4) the true ones.
ArticulatedLosses articulated_losses(const MotionForecast& forecast, const torch::Tensor& last,
                                     const torch::Tensor& future, const torch::Tensor& contact_points,
                                     const Config& config);

}  // namespace inhabit::forecast
