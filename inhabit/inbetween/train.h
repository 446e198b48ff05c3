#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/inbetween/config.h"

namespace inhabit::inbetween {

struct Training {
  std::vector<std::string> data;  ///< native data set folders
  std::string from;               ///< model file that the weights start from; empty: at random
  std::string out;                ///< model file; its best weights by validation are written as training goes on
  Config config = preset("compact");
  bool resume = false;
  uint64_t seed = 1;
  int64_t steps = 20000;
  int64_t batch = 32;
  double learning_rate = 4e-4;  ///< the paper's 1e-4 goes with batches of 256 and many more steps
  int64_t stride = 30;          ///< frames from one window to the next
  bool half = false;            ///< weights are written in half precision
  bool bfloat16 = false;        ///< the network's products are made in bfloat16 (nn/bfloat16.h)
};

/// Trains the denoiser (3.2): one denoising step a sample, t drawn uniformly, key frames drawn at random, always with
/// the first and the last. Noise-aware where config.t_star > 0: key frames are noisy then and given for t >= t_star
/// alone. `out`.log.jsonl is the log, `out`.checkpoint.safetensors where an interrupted run goes on. Returns false when
/// it was interrupted.
bool train(const Training& options);

/// Trains the motion features that the Frechet distance is taken over, on the same windows; steps, batch and rate of
/// `options` count. Returns false when it was interrupted.
bool train_motion_features(const Training& options);

}  // namespace inhabit::inbetween
