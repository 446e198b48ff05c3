#pragma once
#include <string>
#include <vector>

#include "inhabit/forecast/config.h"
#include "inhabit/train/loop.h"

namespace inhabit::forecast {

struct Training {
  std::vector<std::string> data;  ///< native data set folders
  std::string out;                ///< model file; its best weights by validation are written as training goes on
  std::string preset = "compact";
  enum class Stage { contact, motion, trajectory, adapt, both, all } stage = Stage::both;
  torch::Device device = torch::kCPU;
  bool resume = false;
  uint64_t seed = 1;
  int64_t contact_steps = 0, motion_steps = 0, adapt_steps = 0;  ///< 0: the preset's
  int64_t batch = 0;                                             ///< 0: the preset's
};

/// Trains stage by stage (3.3): the contact network, then the motion network with true contact points, then the same
/// without contact points. A last stage, adapt, which the paper has not, goes on with the motion network on batches of
/// which half have the contact points that the contact network predicts: trained on true ones alone it trusts every
/// mistake of the first network. LTD, which is only compared with, is trained by stage trajectory and by all.
/// `out`.log.jsonl is the log, `out`.checkpoint.safetensors where an interrupted run goes on. Returns false when it was
/// interrupted.
bool train(const Training& options);

}  // namespace inhabit::forecast
