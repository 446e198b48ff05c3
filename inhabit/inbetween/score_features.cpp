#include "inhabit/inbetween/score_features.h"

#include "inhabit/error.h"
#include "inhabit/metrics/diversity.h"
#include "inhabit/metrics/frechet.h"

namespace inhabit::inbetween {

using torch::Tensor;

Tensor features_of(const std::vector<ScoredClip>& clips, const MotionAutoencoder& network) {
  std::vector<Tensor> out, windows;
  const auto encode = [&] {
    if (!windows.empty()) out.push_back(motion_features(network, torch::stack(windows)));
    windows.clear();
  };
  for (const ScoredClip& of : clips)
    for (int64_t t = 0; t + kFeatureFrames <= of.clip.frames(); t += kFeatureFrames) {
      windows.push_back(of.clip.joints.slice(0, t, t + kFeatureFrames));
      if (windows.size() == 64) encode();
    }
  encode();
  if (out.empty())
    throw Error(clips.empty() ? "motions" : clips.front().name,
                "has no window of " + std::to_string(kFeatureFrames) + " frames at 30 a second");
  return torch::cat(out);
}

FidScore score_fid(const Tensor& features, const Tensor& reference) {
  for (const Tensor& set : {features, reference})
    if (set.size(0) < 2)
      throw Error("FID", "needs two windows of " + std::to_string(kFeatureFrames) +
                             " frames at 30 a second or more, of motion and of reference");
  const FrechetReference real = frechet_reference(reference);
  return {real.distance(features), features.size(0), reference.size(0), real.dimensions()};
}

double score_diversity(const Tensor& features) {
  if (features.size(0) < 2)
    throw Error("diversity", "needs two windows of " + std::to_string(kFeatureFrames) + " frames at 30 a second");
  return average_pairwise_distance(features.unsqueeze(1))[0].item<double>();
}

}  // namespace inhabit::inbetween
