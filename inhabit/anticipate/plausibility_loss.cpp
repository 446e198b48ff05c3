#include "inhabit/anticipate/plausibility_loss.h"

#include <algorithm>

#include "inhabit/metrics/motion_words.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

/// Eq. 12 as in metrics/ndms.h, with lengths that are rounded off: (N) of words (N, kappa, J, 3).
Tensor similarity(const Tensor& words, const Tensor& others, double softness) {
  constexpr double kRest = 1e-6;  // metres a frame, far under any motion
  const auto velocity = [](const Tensor& w) { return w.slice(1, 1) - w.slice(1, 0, -1); };
  const auto length = [&](const Tensor& v) { return (v.square().sum(3) + softness * softness).sqrt(); };
  const Tensor a = velocity(words), b = velocity(others), length_a = length(a), length_b = length(b);
  const Tensor direction = (a * b).sum(3) / (length_a * length_b);
  const Tensor ratio = torch::minimum(length_a, length_b) / torch::maximum(length_a, length_b);
  const Tensor at_rest = torch::maximum(a.detach().norm(2, {3}), b.norm(2, {3})) < kRest;
  return (0.5 * (1 + direction) * ratio).masked_fill(at_rest, 0).mean({1, 2});
}

/// The nearest of `others` (M, ...) to each of `words` (N, ...): (N, ...).
Tensor nearest(const Tensor& words, const Tensor& others) {
  const Tensor a = words.flatten(1), b = others.flatten(1);
  const Tensor closeness = 2 * a.mm(b.t()) - b.square().sum(1);
  return others.index_select(0, closeness.argmax(1));
}

}  // namespace

PlausibilityLoss::PlausibilityLoss(const std::vector<Sequence>& recordings, int64_t kappa, double softness)
    : kappa_(kappa), softness_(softness) {
  const std::vector<std::string> actions = action_names(recordings);
  words_.resize(actions.size());
  for (const Sequence& recording : recordings) {
    if (recording.features.size(0) < kappa) continue;
    const auto action = std::find(actions.begin(), actions.end(), recording.action) - actions.begin();
    words_[static_cast<size_t>(action)].push_back(
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
    for (const Tensor& recording : words_[action]) {
      Tensor like;
      {
        const torch::NoGradGuard no_gradients;
        like = nearest(words, recording);
      }
      each.push_back(similarity(words, like, softness_));
    }
    const Tensor of = torch::stack(each);  // (R, N)
    const auto others = static_cast<double>(std::max<size_t>(1, each.size() - 1));
    scores.push_back((each.size() > 1 ? of.sum(0) - of.amax(0) : of.sum(0)) / others);
  }
  return scores.empty() ? torch::zeros({}) : 1 - torch::cat(scores).mean();
}

}  // namespace inhabit::anticipate
