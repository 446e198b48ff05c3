#pragma once
#include <vector>

#include "inhabit/anticipate/features.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/metrics/motion_words.h"

namespace inhabit::anticipate {

/// How plausible futures are beside recordings of their action (not in the paper): NDMS (Eq. 12) of each word with the
/// nearest one of every recording by itself, mean over recordings without the one that is most like it. A future that
/// replays a recording scores no more than that recording scores beside the others, as it would beside a recording that
/// nobody has seen; one that moves as most people do scores more.
class PlausibilityLoss {
 public:
  /// @param recordings to train on; words of their mirror images count as theirs. @param kappa frames of a word
  /// @param softness metres a frame, as ndms() takes it (metrics/ndms.h)
  PlausibilityLoss(const std::vector<Sequence>& recordings, int64_t kappa, double softness = 5e-4);

  /// 1 - the mean over windows and words. @param features (B, T, F) metres and radians; @param actions (B) int64, as
  /// Data::Sample has them; @param starts (B, V) int64, first frames of the words that are looked at.
  torch::Tensor operator()(const torch::Tensor& features, const torch::Tensor& actions,
                           const torch::Tensor& starts) const;

 private:
  int64_t kappa_;
  double softness_;
  std::vector<std::vector<WordIndex>> words_;  // of each action and recording
};

}  // namespace inhabit::anticipate
