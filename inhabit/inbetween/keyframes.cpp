#include "inhabit/inbetween/keyframes.h"

#include <cmath>

#include <algorithm>
#include <charconv>
#include <random>
#include <set>
#include <string_view>

#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/motion/transfer.h"

namespace inhabit::inbetween {
namespace {

constexpr double kLeastRate = 12;  // frames a second, of motion

/// "a,b,,c" -> a, b, "", c.
std::vector<std::string_view> parts(std::string_view text) {
  std::vector<std::string_view> out;
  while (true) {
    const size_t comma = text.find(',');
    out.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return out;
    text.remove_prefix(comma + 1);
  }
}

/// The number that the whole of `text` is.
template <class Number>
bool read(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::vector<int64_t> listed_frames(const std::string& text, int64_t frames, const std::string& name) {
  const std::string subject = name + " " + text;
  std::vector<int64_t> out;
  for (const std::string_view part : parts(text)) {
    int64_t t = 0;
    if (!read(part, t)) throw Error(subject, "are none of every:N, random:P, ends or a list of frames such as 0,30,95");
    if (t < 0 || t >= frames)
      throw Error(subject, "frame " + std::to_string(t) + " is outside the clip, whose last frame is " +
                               std::to_string(frames - 1));
    out.push_back(t);
  }
  return out;
}

std::vector<int64_t> key_frames(const std::string& text, int64_t frames, uint64_t seed, const std::string& name) {
  const std::string subject = name + " " + text;
  if (frames < 2) throw Error(subject, "a clip of " + std::to_string(frames) + " frames has no two key frames");
  const int64_t last = frames - 1;
  std::set<int64_t> keys = {0, last};
  const std::string_view all = text;
  if (all.substr(0, 6) == "every:") {
    int64_t step = 0;
    if (!read(all.substr(6), step)) throw Error(subject, "every:N needs a whole number of frames");
    if (step < 1) throw Error(subject, "every:N needs N of at least 1");
    for (int64_t t = 0; t < last; t += std::min(step, frames)) keys.insert(t);
  } else if (all.substr(0, 7) == "random:") {
    double p = 0;
    if (!read(all.substr(7), p)) throw Error(subject, "random:P needs a probability");
    if (!(p > 0 && p <= 1)) throw Error(subject, "random:P needs P above 0 and at most 1");
    std::mt19937_64 random(seed);
    for (int64_t t = 0; t < frames; ++t)
      if (chance(random, p)) keys.insert(t);
  } else if (text != "ends") {
    for (const int64_t t : listed_frames(text, frames, name)) keys.insert(t);
  }
  return {keys.begin(), keys.end()};
}

PosesInTime poses_at_times(const std::vector<Clip>& poses, const std::vector<double>& seconds, double rate,
                           const std::vector<std::string>& names) {
  if (seconds.size() != poses.size())
    throw Error("--times",
                std::to_string(seconds.size()) + " are named for " + std::to_string(poses.size()) + " poses");
  double own = 0;
  for (const Clip& pose : poses) own = std::max(own, pose.rate);
  if (own >= kLeastRate) rate = own;
  std::vector<Clip> sources, standard;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (i > 0 && std::llround((seconds[i] - seconds[0]) * rate) <= std::llround((seconds[i - 1] - seconds[0]) * rate))
      throw Error("--times", "are not in order, a frame or more apart");
    if ((seconds[i] - seconds[0]) * rate > 100'000) throw Error("--times", "are more than 55 minutes apart");
    sources.push_back(slice(poses[i], 0, 1));
    standard.push_back(slice(retarget(poses[i], names[i]), 0, 1));
    const auto bones = [&](size_t k) { return standard[k].skeleton.offsets.slice(0, 1); };
    if ((bones(i) - bones(0)).abs().max().item<double>() > 0.02)
      throw Error(names[i], "has other bones than " + names[0]);
  }
  Clip all = joined_poses(sources);
  PosesInTime out;
  out.standard = all.frames() == 0;
  if (out.standard) all = joined_poses(standard);
  all.rate = rate;
  for (const double second : seconds) out.keys.push_back(std::llround((second - seconds[0]) * rate));
  std::vector<int64_t> pose_of;
  for (size_t k = 0; k + 1 < out.keys.size(); ++k)
    pose_of.insert(pose_of.end(), static_cast<size_t>(out.keys[k + 1] - out.keys[k]), static_cast<int64_t>(k));
  pose_of.push_back(static_cast<int64_t>(out.keys.size()) - 1);
  out.clip = frames_at(all, pose_of);
  return out;
}

PosesInTime frames_at_times(const Clip& clip, const std::vector<int64_t>& frames, const std::vector<double>& seconds,
                            const std::string& name) {
  std::vector<Clip> poses;
  poses.reserve(frames.size());
  for (const int64_t frame : frames) poses.push_back(slice(clip, frame, frame + 1));
  return poses_at_times(poses, seconds, clip.rate, std::vector<std::string>(frames.size(), name));
}

torch::Tensor key_groups(const std::string& joints, const Skeleton& file) {
  if (joints.empty()) return torch::ones({kKeyGroups});
  torch::Tensor groups = torch::zeros({kKeyGroups});
  for (const std::string_view part : parts(joints)) {
    const int joint = part == "root" ? 0 : standard_joint_called(std::string(part), file);
    if (joint < 0)
      throw Error("--joints " + joints,
                  "\"" + std::string(part) + "\" is no joint; there are root, " + joint_names_for(file));
    groups[kJointGroups + joint] = 1;
  }
  groups[kRootTranslationGroup] = groups[kJointGroups];
  return groups;
}

std::vector<int64_t> key_joints_of(const torch::Tensor& groups) {
  std::vector<int64_t> out;
  for (int64_t j = 0; groups.defined() && j < kStandardJoints; ++j)
    if (groups[kJointGroups + j].item<bool>()) out.push_back(j);
  return out;
}

torch::Tensor feature_mask(const torch::Tensor& groups) {
  if (!groups.defined() || groups.dim() < 1 || groups.size(-1) != kKeyGroups)
    throw Error("mask", "is not (..., " + std::to_string(kKeyGroups) + ")");
  std::vector<int64_t> group;
  group.insert(group.end(), 3, kRootTranslationGroup);
  group.insert(group.end(), 6, kRootOrientationGroup);
  group.insert(group.end(), 6 * (kStandardJoints - 1), kBodyRotationsGroup);
  for (int64_t j = 0; j < kStandardJoints; ++j) group.insert(group.end(), 3, kJointGroups + j);
  return groups.index_select(-1, torch::tensor(group, torch::TensorOptions(torch::kLong).device(groups.device())));
}

}  // namespace inhabit::inbetween
