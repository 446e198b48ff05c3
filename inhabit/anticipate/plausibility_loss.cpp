#include "inhabit/anticipate/plausibility_loss.h"

#include <algorithm>

#include "inhabit/metrics/ndms.h"

namespace inhabit::anticipate {

using torch::Tensor;

PlausibilityLoss::PlausibilityLoss(const std::vector<Sequence>& recordings, int64_t kappa, double softness)
    : kappa_(kappa), softness_(softness) {
  const std::vector<std::string> actions = action_names(recordings);
  words_.resize(actions.size());
  for (const Sequence& recording : recordings) {
    if (recording.features.size(0) < kappa) continue;
    const auto action = std::find(actions.begin(), actions.end(), recording.action) - actions.begin();
    words_[static_cast<size_t>(action)].emplace_back(
        torch::cat({pose_words(feature_poses(recording.features), kappa),
                    pose_words(feature_poses(mirrored_features(recording.features)), kappa)}));
  }
}

Tensor PlausibilityLoss::operator()(const Tensor& features, const Tensor& actions, const Tensor& starts) const {
  const int64_t windows = features.size(0);
  const Tensor poses = word_poses(feature_poses(features).flatten(0, 1)).view({windows, features.size(1), -1, 3});
  const Tensor at = (starts.unsqueeze(2) + torch::arange(kappa_)).flatten(1);  // (B, V kappa)
  const Tensor all = poses.flatten(2).gather(1, at.unsqueeze(2).expand({-1, -1, poses.size(2) * 3}));
  std::vector<Tensor> scores;
  for (size_t action = 0; action < words_.size(); ++action) {
    const Tensor rows = (actions == static_cast<int64_t>(action)).nonzero().flatten();
    if (rows.size(0) == 0 || words_[action].empty()) continue;
    const Tensor words = all.index_select(0, rows).view({-1, kappa_, poses.size(2), 3});
    std::vector<Tensor> each;
    for (const WordIndex& recording : words_[action])
      each.push_back(plausibility(words, recording, NdmsForm::equation, softness_));
    const Tensor of = torch::stack(each);  // (R, N)
    const auto others = static_cast<double>(std::max<size_t>(1, each.size() - 1));
    scores.push_back((each.size() > 1 ? of.sum(0) - of.amax(0) : of.sum(0)) / others);
  }
  return scores.empty() ? torch::zeros({}) : 1 - torch::cat(scores).mean();
}

}  // namespace inhabit::anticipate
