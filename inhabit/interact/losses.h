#pragma once
#include <torch/types.h>

#include "inhabit/interact/config.h"
#include "inhabit/interact/contact_network.h"
#include "inhabit/interact/control_network.h"
#include "inhabit/interact/sample.h"

namespace inhabit::interact {

/// Eq. 3 over standardised rows (B, 536) of rollouts: errors count squared up to `linear_from` deviations and linearly
/// beyond, so that one that has got lost does not drown the others; the wrists' count `hand_weight` times. Where all
/// are small and the weight is 1 it is their mean square.
torch::Tensor frame_loss(const OutputLayout& layout, const torch::Tensor& output, const torch::Tensor& target,
                         double hand_weight, double linear_from);

/// Eq. 2 and the release's term of the first point. Means over what hands with a contact have.
struct ControlLosses {
  torch::Tensor total;       ///< weighted by Config::Training
  torch::Tensor trajectory;  ///< metres^2 of the planned points
  torch::Tensor phase;       ///< of the planned phases
  torch::Tensor straight;    ///< metres^2 from the straight line that went in
  torch::Tensor first;       ///< metres^2 of the planned first point, at the next frame
};
/// @param output, control, target (..., 56); @param wanted (..., 2).
ControlLosses control_losses(const torch::Tensor& output, const torch::Tensor& control, const torch::Tensor& target,
                             const torch::Tensor& wanted, const Config::Training& weights);

/// What a ControlNet was given and said.
struct ControlRun {
  torch::Tensor control;  ///< (T, B, 56) that went in
  torch::Tensor output;   ///< (T, B, 56) that came out
};
/// Runs it over sequences. At each frame and hand, with probability `own`, the straight line starts where its own plan
/// put the hand (scheduled sampling; no gradient goes that way); phases are the true ones. Draws from torch's
/// generator.
ControlRun run_control(ControlNetwork& network, const ControlSequences& sequences, double own);

/// The straight lines (..., 42) from the first points of a control signal (..., 56), seen in axes rotated by `rotation`
/// (..., 2) cosine and sine.
torch::Tensor next_lines(const torch::Tensor& output, const torch::Tensor& rotation);

/// Eq. 4: mean distance of the two contacts (metres) + beta x KL divergence.
struct ContactLosses {
  torch::Tensor total;       ///< what is minimised
  torch::Tensor distance;    ///< metres
  torch::Tensor divergence;  ///< KL, from N(0, I)
};
/// The loss of a batch of contacts and their chairs.
/// @param noise normal, of the latent code's shape; @param beta weight of the divergence
ContactLosses contact_losses(ContactNetwork& network, const ContactRows& rows, const torch::Tensor& noise, double beta);

}  // namespace inhabit::interact
