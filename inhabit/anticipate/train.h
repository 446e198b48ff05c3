#pragma once
#include "inhabit/anticipate/config.h"
#include "inhabit/io/read_options.h"
#include "inhabit/train/stages.h"

namespace inhabit::anticipate {

/// Trains ours (3.1, 3.2; stage "intention"), and what it is compared with: the residual sequence-to-sequence GRU
/// ("seq2seq"), LTD ("ltd") and HisRep ("hisrep"), in that order, and on request a VAE ("vae"), DLow ("dlow"),
/// Mix-and-Match ("mix_match") and the generative grammar ("grammar"). Labels are clustered first. Ours is validated by
/// 1 - NDMS over ten seconds of the validation recordings, the others by their pose error over one
/// (train_baselines.h).
/// @param run data is one set, as read_motion_set takes it. @param notes gets the files that were missing. Returns
/// false when it was interrupted; resuming gives the same numbers.
bool train(const TrainRun& run, const Config& config, Notes* notes = nullptr);

}  // namespace inhabit::anticipate
