#pragma once
#include <optional>
#include <vector>

#include "inhabit/anticipate/motion_memory.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/metrics/motion_words.h"

namespace inhabit::anticipate {

// Futures that need no training: what every method is compared with. Observations (t, F) and futures (frames, F) are
// features in metres and radians.

/// The last pose stays where it is.
torch::Tensor held_future(const torch::Tensor& past, int64_t frames);

/// Joints go on as from the frame before the last to the last; the root's step and turn stay, and so does its height.
torch::Tensor constant_velocity_future(const torch::Tensor& past, int64_t frames);

/// Remembering: the training recording whose motion word is nearest to the last observed one goes on. The difference to
/// the observed pose fades over ten frames. Where the recording ends, the next is looked for in the same way.
class Retrieval {
 public:
  /// @param kappa frames of a word. Recordings and their mirror images are kept.
  Retrieval(const std::vector<Sequence>& recordings, int64_t kappa);

  /// Whether a recording has a word with something after it.
  bool empty() const { return !index_; }
  /// (frames, F) after an observation.
  torch::Tensor future(const torch::Tensor& past, int64_t frames) const;

 private:
  int64_t kappa_;
  std::vector<torch::Tensor> features_;
  std::vector<Cut> ends_;  // of each word: its recording, and the frame after its last
  std::optional<WordIndex> index_;
};

/// (S, frames, F): what a memory draws, and nothing learned: the difference to the observed pose fades over ten frames.
/// @param choice (S, frames, 3) uniform numbers in [0, 1).
torch::Tensor memory_future(const MotionMemory& memory, const torch::Tensor& past, const torch::Tensor& choice);

}  // namespace inhabit::anticipate
