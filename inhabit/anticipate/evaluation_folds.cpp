#include "inhabit/anticipate/evaluation_folds.h"

#include "inhabit/error.h"

namespace inhabit::anticipate {
namespace {

/// The model's memory as its settings have it now, without the validation recordings where these are what it is
/// measured on.
std::shared_ptr<const MotionMemory> memory_for(const Networks& networks, const std::string& split,
                                               const std::string& file) {
  std::vector<Remembered> recordings;
  for (const Remembered& r : networks.memory->recordings())
    if (split != "val" || !r.validation) recordings.push_back(r);
  return make_memory(std::move(recordings), networks.clusters, networks.config, file);
}

/// A memory of a fold's recordings whose places have no labels.
void remember(Fold& fold, const std::string& data) {
  Networks& n = fold.networks;
  IntentionClusters one;
  one.poses = torch::zeros({1, kPoseFeatures});
  n.memory = make_memory(remembered_motion(fold.training, n.config.kappa), one, n.config, data);
}

/// The recordings of `split` for a model, or of a model's fold, and all others that it may remember.
Fold fold_of(const std::vector<ActionMotion>& motions, const std::string& source, const std::string& split,
             Networks networks) {
  const double rate = networks.config.rate;
  if (networks.skeleton.size() == 0) networks.skeleton = training_skeleton(motions, source);
  const auto of = [&](const std::string& name) { return sequences_of(motions, name, networks.skeleton, rate); };
  Fold fold{networks, of(split), {}};
  if (split == "train") return fold;
  fold.training = of("train");
  if (split != "val")
    for (Sequence& s : of("val")) fold.training.push_back(std::move(s));
  return fold;
}

}  // namespace

std::vector<Fold> evaluation_folds(const std::string& data, const std::string& split,
                                   const std::vector<std::pair<std::string, Networks>>& models, const Config& config,
                                   Notes* notes) {
  const bool by_turns = split == "left-out";
  for (const auto& [file, networks] : models) {
    if (by_turns && networks.config.training.folds == 0)
      throw Error(file, "was trained on every recording: --split left-out takes models trained with training.folds");
    if (networks.config.rate != models.front().second.config.rate)
      throw Error(file, "has another frame rate than " + models.front().first);
  }
  if (!by_turns && models.size() > 1) throw Error("--model", "several are for --split left-out, one for each fold");
  const double rate = models.empty() ? config.rate : models.front().second.config.rate;
  const std::vector<ActionMotion> motions = read_motion_set(data, kDatabaseStride * rate, notes);
  std::vector<Fold> out;
  if (by_turns && models.empty())
    for (int64_t folds = single_folds(motions), fold = 0; fold < folds; ++fold) {
      Networks none;
      none.config = config;
      out.push_back(fold_of(left_out_fold(motions, folds, fold), data, "left_out", none));
      remember(out.back(), data);
    }
  for (auto [file, networks] : models) {
    if (networks.memory) networks.memory = memory_for(networks, split, file);
    const auto& training = networks.config.training;
    out.push_back(by_turns ? fold_of(left_out_fold(motions, training.folds, training.fold), data, "left_out", networks)
                           : fold_of(motions, data, split, networks));
  }
  return out;
}

}  // namespace inhabit::anticipate
