#pragma once
#include <string>
#include <vector>

#include "inhabit/anticipate/config.h"
#include "inhabit/io/read_options.h"
#include "inhabit/train/loop.h"

namespace inhabit::anticipate {

struct Training {
  std::string data;  ///< as read_motion_set takes it
  std::string out;   ///< model file; its best weights by validation are written as training goes on
  Config config;
  enum class Stage { intention, seq2seq, trajectory, all } stage = Stage::all;
  bool resume = false;
  uint64_t seed = 1;
  int64_t steps = 0;  ///< of each stage; 0: 1600 for ours, 2000 for the compared ones
  int64_t batch = 32;
};

/// Trains ours (3.1, 3.2), the residual sequence-to-sequence GRU and LTD, in that order. Labels are clustered first. An
/// earlier stage's networks in `out` are kept. Ours is validated by 1 - NDMS over ten seconds of the validation
/// recordings, the others by their joint error over one. `notes` gets the files that were missing.
/// Returns false when it was interrupted; resuming gives the same numbers.
bool train(const Training& options, Notes* notes = nullptr);

}  // namespace inhabit::anticipate
