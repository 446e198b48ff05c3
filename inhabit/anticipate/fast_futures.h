#pragma once
#include <vector>

#include "inhabit/anticipate/futures.h"
#include "inhabit/nn/row_layers.h"

namespace inhabit::anticipate {

/// Inference-only evaluation of ours on the CPU: the same futures as plain_futures(), decoded in plain loops over
/// chunks of samples, without a graph and without allocating per frame. Holds a copy of the weights; forward() may be
/// called from several threads.
class FastFutures {
 public:
  explicit FastFutures(const Networks& networks);

  /// @param past (1, t, F) or (S, t, F) metres and radians; `noise` of S samples and at least `frames` frames.
  Futures forward(const torch::Tensor& past, const FutureNoise& noise, int64_t frames) const;

  /// What the futures of a model with a memory follow, as followed_motion() has it.
  Followed follow(const torch::Tensor& past, const FutureNoise& noise, int64_t frames) const;

 private:
  void draw_intention(const float* code, const float* gumbel, int64_t frames, int64_t* labels) const;
  /// @param followed, changes what is followed, standardised, `words` frames a sample; null without a memory.
  void decode(const float* code, const float* z, const float* pose, const int64_t* labels, const float* followed,
              const float* changes, int64_t samples, int64_t frames, float* out) const;

  std::shared_ptr<const MotionMemory> memory_;
  Config config_;
  FeatureScale scale_;
  nn::RowGru intention_encoder_, intention_decoder_, pose_encoder_, layers_[3];
  nn::RowLayer intention_out_, pose_out_;
  std::vector<float> pull_;                          ///< (F) weight of the target pose
  std::vector<float> look_ahead_, look_ahead_bias_;  ///< (gamma, C, features), (features)
};

}  // namespace inhabit::anticipate
