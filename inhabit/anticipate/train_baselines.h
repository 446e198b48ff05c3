#pragma once
#include <string>

#include "inhabit/anticipate/sample.h"
#include "inhabit/train/stages.h"

namespace inhabit::anticipate {

/// Training of what ours is compared with, by the name of its stage: "seq2seq", "ltd" and "hisrep" by their joint error
/// (validated by it over a second), "vae", "dlow" and "mix_match" by their papers' losses (validated by the nearest of
/// ten futures over a second). Lengths in their losses are metres; root motion counts as in
/// root_reconstruction_loss. The network, new, is among `networks` from then on. Throws Error(run.out, ...) where
/// "dlow" finds no VAE in the model file.
TrainTask baseline_task(const std::string& name, Networks& networks, const Data& data,
                        const std::vector<Sequence>& validation, const TrainRun& run);

}  // namespace inhabit::anticipate
