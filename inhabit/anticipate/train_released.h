#pragma once
#include "inhabit/anticipate/sample.h"
#include "inhabit/train/loop.h"

namespace inhabit::anticipate {

/// Training of the authors' networks with their losses (preset "paper"): ten times the mean joint distance of 20
/// frames, weight (21 - f) / 20 up to frame tau_rec and 0 after, and a discriminator of all 20 poses; cross-entropy of
/// the first ten labels, and a discriminator of all 50. Networks are made anew.
/// @param validate as in TrainTask
TrainTask released_task(Networks& networks, const Data& data, std::function<double()> validate, torch::Device device);

}  // namespace inhabit::anticipate
