#include "inhabit/anticipate/sample.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "inhabit/anticipate/released_labels.h"
#include "inhabit/error.h"
#include "inhabit/motion/local_pose.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

constexpr int64_t kLeastPast = 8, kLeastFuture = 10;

/// `frames` rows from `first` on; before the first and after the last row these repeat.
Tensor rows(const Tensor& all, int64_t first, int64_t frames) {
  return all.index_select(0, torch::arange(first, first + frames).clamp(0, all.size(0) - 1));
}

std::map<std::string, std::vector<size_t>> by_action(const std::vector<Sequence>& sequences) {
  std::map<std::string, std::vector<size_t>> out;
  for (size_t i = 0; i < sequences.size(); ++i) out[sequences[i].action].push_back(i);
  return out;
}

}  // namespace

std::string shown_name(const Sequence& recording) {
  const bool trained_on = recording.split.empty() || recording.split == "train";
  return recording.name + (trained_on ? "" : " (" + recording.split + ")");
}

std::vector<Sequence> sequences_of(const std::vector<ActionMotion>& motions, const std::string& split,
                                   const Skeleton& skeleton, double rate) {
  std::vector<Sequence> out;
  for (const ActionMotion& motion : motions) {
    const int64_t stride = std::max<int64_t>(1, std::llround(motion.clip.rate / rate));
    if (motion.split != split || motion.clip.frames() <= stride) continue;
    const Tensor joints = on_skeleton(motion.clip, skeleton).joints;
    out.push_back(
        {motion.name, motion.action, joint_features(joints.slice(0, 0, c10::nullopt, stride)), joints, stride, split});
  }
  return out;
}

Skeleton training_skeleton(const std::vector<ActionMotion>& motions, const std::string& source) {
  for (const ActionMotion& motion : motions)
    if (motion.split == "train" && motion.clip.frames() > 1) return motion.clip.skeleton;
  throw Error(source, "has no training recording");
}

std::vector<std::string> action_names(const std::vector<Sequence>& sequences) {
  std::vector<std::string> out;
  for (const auto& [action, members] : by_action(sequences)) out.push_back(action);
  return out;
}

Tensor intention_poses(const Tensor& features) { return features.narrow(-1, 0, kPoseFeatures).contiguous(); }

IntentionClusters cluster_recordings(const std::vector<Sequence>& recordings, const Config& config, uint64_t seed) {
  std::vector<Tensor> poses;
  for (const Sequence& recording : recordings)
    for (const Tensor& features : {recording.features, mirrored_features(recording.features)})
      poses.push_back(intention_poses(features));
  if (config.released) return cluster_released(poses, config.labels, seed);
  return cluster_intentions(poses, config.labels, config.clusters, config.naive_clusters, seed);
}

std::vector<Remembered> remembered_motion(const std::vector<Sequence>& recordings, int64_t kappa) {
  std::vector<Tensor> features;
  std::vector<std::string> actions;
  for (const Sequence& r : recordings) {
    features.push_back(r.features);
    actions.push_back(r.action);
  }
  const std::vector<Tensor> typical = typical_motion(features, actions, kappa);
  std::vector<Remembered> out;
  for (size_t i = 0; i < recordings.size(); ++i)
    out.push_back({(features[i] / kMemoryUnit).round().clamp(-32767, 32767) * kMemoryUnit, typical[i]});
  return out;
}

Tensor observation(const Tensor& features, int64_t now, int64_t observed) {
  return rows(features, now - observed, observed);
}

std::vector<Cut> test_windows(const std::vector<Sequence>& sequences, const Config& config, int64_t per_action) {
  const auto second = static_cast<int64_t>(config.rate);
  std::vector<Cut> out;
  for (const auto& [action, members] : by_action(sequences)) {
    std::vector<Cut> possible;
    for (const size_t i : members) {
      const int64_t frames = sequences[i].features.size(0);
      const int64_t latest = frames - second >= config.observed ? frames - second : frames - kLeastFuture;
      if (latest < config.kappa) continue;
      for (int64_t now = std::min<int64_t>(config.observed, latest); now <= latest; ++now) possible.push_back({i, now});
    }
    const auto count = static_cast<int64_t>(possible.size()), n = std::min(count, per_action);
    for (int64_t i = 0; i < n; ++i) out.push_back(possible[static_cast<size_t>((2 * i + 1) * count / (2 * n))]);
  }
  return out;
}

Data::Data(std::vector<Sequence> sequences, const Networks& networks) : config_(networks.config) {
  for (const Sequence& sequence : sequences)
    for (const Tensor& features : {sequence.features, mirrored_features(sequence.features)}) {
      features_.push_back(networks.scale.to_network(features));
      labels_.push_back(intention_labels(intention_poses(features), networks.clusters));
    }
  std::map<std::string, std::vector<Cut>> windows;
  size_t most = 0;
  int64_t number = 0;
  actions_.resize(sequences.size());
  for (const auto& [action, members] : by_action(sequences)) {
    for (const size_t i : members) actions_[i] = number;
    ++number;
    for (const size_t i : members)
      for (int64_t now = kLeastPast; now + kLeastFuture <= sequences[i].features.size(0); ++now)
        windows[action].push_back({i, now});
    most = std::max(most, windows[action].size());
  }
  for (const auto& [action, some] : windows)
    for (size_t i = 0; i < std::min(most, 8 * some.size()); ++i) windows_.push_back(some[i % some.size()]);
}

Data::Sample Data::sample(int64_t index, bool mirrored) const {
  const auto& [sequence, now] = windows_[static_cast<size_t>(index)];
  const Tensor& features = features_[2 * sequence + (mirrored ? 1 : 0)];
  const int64_t first = now - config_.observed, frames = config_.observed + config_.future;
  const int64_t labels = config_.observed + std::max(config_.training.label_frames, config_.future + config_.gamma - 1);
  return {rows(features, first, frames),
          rows(labels_[2 * sequence + (mirrored ? 1 : 0)], first, labels),
          std::max<int64_t>(0, -first),
          std::min(frames, features.size(0) - first),
          std::min(labels, features.size(0) - first),
          static_cast<int64_t>(sequence),
          actions_[sequence]};
}

}  // namespace inhabit::anticipate
