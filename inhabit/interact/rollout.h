#pragma once
#include <functional>
#include <vector>

#include "inhabit/interact/sample.h"
#include "inhabit/interact/sense_noise.h"

namespace inhabit::interact {

/// A predictor on PoseNet's rows as they are (B, 4344) and contacts (B, 8) -> (B, 536).
using PoseFunction = std::function<torch::Tensor(const torch::Tensor& input, const torch::Tensor& contacts)>;

/// Rows of what a network makes of recordings by itself: from each of the given frames it goes on for `frames` frames
/// with its own outputs, hands and goals as recorded. A row's target leads from where it got to, to the recording's
/// next frame: what a step must do to come back (Ross et al. 2011). (frames x B) rows, frame by frame.
/// @param noise of each of the given frames' senses, or empty.
PoseRows rollout(const Data& data, const std::vector<int64_t>& indices, int64_t frames, const PoseFunction& predict,
                 const std::vector<SenseNoise>& noise = {});

}  // namespace inhabit::interact
