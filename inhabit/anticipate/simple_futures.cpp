#include "inhabit/anticipate/simple_futures.h"

#include <cmath>

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

constexpr int64_t kFade = 10;       // frames in which the difference to the observed pose fades
constexpr int64_t kLeastNext = 10;  // frames that must follow a word, so that something is remembered

/// What goes on in a recording, (..., T, F), blended into from the observed pose. @param apart (..., 1, F) what
/// differs there.
Tensor faded(const Tensor& next, const Tensor& apart) {
  const Tensor time = (torch::arange(1, next.size(-2) + 1).to(torch::kFloat32) / kFade).clamp_max(1);
  return next + (0.5F * (1 + torch::cos(time * static_cast<float>(M_PI)))).unsqueeze(1) * apart;
}

}  // namespace

Tensor held_future(const Tensor& past, int64_t frames) {
  Tensor out = past.slice(0, past.size(0) - 1).expand({frames, -1}).clone();
  out.slice(1, kPoseFeatures, kPoseFeatures + 3).zero_();  // no step, no turn
  return out;
}

Tensor constant_velocity_future(const Tensor& past, int64_t frames) {
  const Tensor last = past[-1];
  Tensor velocity = last - past[-2];
  velocity.slice(0, kPoseFeatures).zero_();  // the root motion is a velocity itself
  return last + torch::arange(1, frames + 1).unsqueeze(1) * velocity;
}

Retrieval::Retrieval(const std::vector<Sequence>& recordings, int64_t kappa) : kappa_(kappa) {
  std::vector<Tensor> words;
  for (const Sequence& recording : recordings)
    for (const Tensor& features : {recording.features, mirrored_features(recording.features)}) {
      const int64_t last = features.size(0) - kLeastNext;  // the word's end at the latest
      if (last < kappa) continue;
      words.push_back(pose_words(feature_poses(features.slice(0, 0, last)), kappa));
      for (int64_t end = kappa; end <= last; ++end) ends_.push_back({features_.size(), end});
      features_.push_back(features);
    }
  if (!words.empty()) index_.emplace(torch::cat(words));
}

Tensor Retrieval::future(const Tensor& past, int64_t frames) const {
  Tensor out = past;
  while (out.size(0) < past.size(0) + frames) {
    const Tensor seen = out.slice(0, out.size(0) - kappa_);
    const Cut at = ends_[static_cast<size_t>(index_->nearest(pose_words(feature_poses(seen), kappa_)).item<int64_t>())];
    const Tensor& recording = features_[at.sequence];
    out = torch::cat({out, faded(recording.slice(0, at.now), (out[-1] - recording[at.now - 1]).unsqueeze(0))});
  }
  return out.slice(0, past.size(0), past.size(0) + frames);
}

Tensor memory_future(const MotionMemory& memory, const Tensor& past, const Tensor& choice) {
  const Followed followed = memory.follow(past.unsqueeze(0), choice);
  const Tensor before = followed.features.slice(1, 0, 1) - followed.changes.slice(1, 0, 1);
  return faded(followed.features, past[-1] - before);
}

}  // namespace inhabit::anticipate
