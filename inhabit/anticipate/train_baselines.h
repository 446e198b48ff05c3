#pragma once
#include <string>

#include "inhabit/anticipate/sample.h"
#include "inhabit/train/stages.h"

namespace inhabit::anticipate {

/// Training of what ours is compared with, by the name of its stage: "seq2seq", "ltd" and "hisrep" by their joint error
/// (validated by their pose error over a second); "vae" and "dlow" by DLow's losses and the weights of its released
/// configuration, and "mix_match" by those of "vae" (validated by the nearest of ten futures over a second, DLow by
/// that of all its futures); "grammar", validated as "vae", by the error of the nearest of its rollouts and a
/// discriminator of whole forecasts. Lengths in these losses are metres; a standardised feature of the root motion
/// counts as 0.1 m. Learning rate and steps are config.baselines' for all. The network, new, is among `networks` from
/// then on. Throws Error(run.out, ...) where "dlow" finds no VAE in the model file.
TrainTask baseline_task(const std::string& name, Networks& networks, const Data& data,
                        const std::vector<Sequence>& validation, const TrainRun& run);

}  // namespace inhabit::anticipate
