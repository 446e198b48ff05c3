#pragma once
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/residual_batch.h"
#include "inhabit/inbetween/schedule.h"
#include "inhabit/train/loop.h"

namespace inhabit::inbetween {

/// Of one evaluation of the denoiser at each window's diffusion step: the residual (simple), joints, their velocities,
/// feet that stand, points of the body deeper in obstacles than the true ones. "mm" is reported only.
Losses denoising_losses(const Networks& networks, const DiffusionSchedule& schedule, const ResidualBatch& batch,
                        bool bfloat16);

/// Of motion as it is sampled in use, with `inference.steps` evaluations that gradients pass through. A network that is
/// trained on squared errors and asked a few times only answers the mean of what could happen: slow, smooth, the same
/// for every seed. So each window is sampled twice, and each of residuals, joints, velocities, accelerations and jerks
/// is scored by the energy score (Gneiting and Raftery 2007), E|y - x| - E|y - y'| / 2, which is least where samples y
/// are distributed as the true x is. @param batch of `twice`
Losses deployed_losses(const Networks& networks, const DiffusionSchedule& schedule, const ResidualBatch& batch,
                       bool bfloat16);

/// Of FootContactNet, which alone gets gradients: the cross-entropy of the contacts that it predicts for motion as it
/// is sampled in use ("total"), and the fraction of feet and frames that it is right about ("right"). Where a sampled
/// foot steps elsewhere than the true one, the true contacts are not its own: each foot and frame counts exp(-distance
/// / 10 cm), of the sampled foot from the true one.
Losses contact_losses(const Networks& networks, const DiffusionSchedule& schedule, const ResidualBatch& batch,
                      bool bfloat16);

/// How fast feet near the floor go, as foot_skating() but with gradients and stricter: low x robust(speed), low falling
/// from 1 to 0 around 5 cm, speed beyond 8 mm a frame in units of 2 cm, the mean over ankles and balls of both feet. A
/// sample takes its steps at other times than the truth does: what must not happen is that its own footholds slide.
/// @param joints (B, T, 22, 3) metres, floor at y = 0. @param moving (B, T - 1, 1) 1 where a step counts
torch::Tensor sliding_loss(const torch::Tensor& joints, const torch::Tensor& moving);

/// How much faster feet go than the truth's in the same window ever do: robust(speed - limit) where that is positive,
/// the limit being the truth's fastest step of an ankle or ball, at least 8 cm a frame, in units of 2 cm; the mean over
/// ankles and balls of both feet. Feet that are held back while they are low make up for it in the air: nothing else
/// that is scored names their speed. @param joints, truth (B, T, 22, 3) metres. @param moving as above
torch::Tensor swinging_loss(const torch::Tensor& joints, const torch::Tensor& truth, const torch::Tensor& moving);

/// How deep guarded_points are in obstacles beyond `room`: the sum over points of ((room - distance) / 5 cm)^2 where
/// that is positive, the mean over frames and over the windows that are `kept`. @param points (B, T, 38, 3) metres,
/// world, of B windows, each in its own scene. @param room (B, T, 38) ResidualBatch::room. @param kept (B)
/// ResidualBatch::kept
torch::Tensor penetration_loss(const std::vector<SceneDistances>& scenes, const torch::Tensor& points,
                               const torch::Tensor& room, const torch::Tensor& kept);

/// How much nearer to obstacles the root comes than `passes`: robust(passes - distance) where that is positive, in
/// units of 10 cm, the mean over frames, the three heights of root_column and the windows that are `kept`. Of two
/// samples that are as far from the truth, one on either side, the energy score takes both alike; only the one nearer
/// to the obstacle brushes it with a hand. @param root (B, T, 3) metres, world. @param passes (B, T, 3)
/// ResidualBatch::passes. @param kept (B) ResidualBatch::kept
torch::Tensor clearance_loss(const std::vector<SceneDistances>& scenes, const torch::Tensor& root,
                             const torch::Tensor& passes, const torch::Tensor& kept);

/// The energy score of two samples, elements of `a` and `b` (..., D), of `truth` (..., D): (...). @param least what the
/// square of a distance is increased by, so that its root is smooth
torch::Tensor energy_score(const torch::Tensor& a, const torch::Tensor& b, const torch::Tensor& truth, double least);

}  // namespace inhabit::inbetween
