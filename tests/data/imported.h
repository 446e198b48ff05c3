#pragma once
#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "inhabit/data/import_dataset.h"
#include "inhabit/data/window_set.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"

// What tests of imported data sets look at.

namespace inhabit {

inline ImportResult imported(const std::string& format, const std::string& from, const std::string& to) {
  return import_dataset(open_import_set(format, from), to);
}

inline const DatasetClip& clip_called(const Dataset& data, const std::string& source) {
  for (const DatasetClip& clip : data.clips)
    if (clip.source == source) return clip;
  throw Error(data.folder, "has no clip of " + source);
}

/// Metres between where two people go, moved so that they begin at one place, at most.
inline double off(const Clip& is, const Clip& should) {
  const int64_t T = std::min(is.frames(), should.frames());
  torch::Tensor a = is.root_path().slice(0, 0, T), b = should.root_path().slice(0, 0, T);
  return ((a - a[0]) - (b - b[0])).norm(2, 1).max().item<double>();
}

/// The same of knees, ankles, elbows and wrists, left and right told apart.
inline double limbs_off(const Clip& is, const Clip& should) {
  const int64_t T = std::min(is.frames(), should.frames());
  double most = 0;
  for (const int64_t j : {4, 5, 7, 8, 18, 19, 20, 21}) {
    const torch::Tensor a = is.joints.slice(0, 0, T).select(1, j) - is.joints[0][0],
                        b = should.joints.slice(0, 0, T).select(1, j) - should.joints[0][0];
    most = std::max(most, (a - b).norm(2, 1).max().item<double>());
  }
  return most;
}

/// How much their joints' rotation matrices differ, at most.
inline double turned(const Clip& is, const Clip& should) {
  return (axis_angle_to_matrix(is.rotations) - axis_angle_to_matrix(should.rotations)).abs().max().item<double>();
}

inline int64_t windows_of(const std::string& folder, const std::string& split) {
  const WindowSet windows({folder}, split, 60, 30, 30, [](const Dataset&) {});
  for (int64_t w = 0; w < windows.size(); ++w) {
    windows.load_clip(windows.clip_key(w));
    EXPECT_FALSE(windows.load_scene(windows.scene_key(w)).empty());
  }
  return windows.size();
}

/// Seconds that a joint is in contact.
inline double touching(const Clip& clip, int64_t joint) {
  return clip.contact.select(1, joint).sum().item<double>() / clip.rate;
}

/// Whether they stand in the beginning and sit in the end: the pelvis is lower, and the knees are bent.
inline bool sits(const Clip& clip) {
  const auto height = [&](int64_t t) { return clip.joints[t][0][1].item<double>(); };
  const torch::Tensor end = clip.joints[-1];
  const torch::Tensor thigh = end[4] - end[1], shin = end[7] - end[4];
  const double bend = (thigh.dot(shin) / (thigh.norm() * shin.norm())).item<double>();
  return height(0) > 0.8 && height(clip.frames() - 1) < 0.7 && bend < 0.6;
}

}  // namespace inhabit
