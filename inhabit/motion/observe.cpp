#include "inhabit/motion/observe.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/motion/pose_track.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"

namespace inhabit {

namespace {

/// The clip left-padded by `count` frames, in which it goes as it does from its first frame to its second.
Clip left_padded(const Clip& clip, int64_t count) {
  std::vector<int64_t> frames(static_cast<size_t>(count), 0);
  for (int64_t t = 0; t < clip.frames(); ++t) frames.push_back(t);
  const torch::Tensor at = torch::tensor(frames);
  Clip out = clip;
  for (torch::Tensor* t : {&out.joints, &out.rotations, &out.trans, &out.translations, &out.action, &out.contact,
                           &out.hand_targets, &out.object_pose})
    if (t->defined()) *t = t->index_select(0, at);
  if (clip.frames() < 2) return out;
  const auto go_back = [&](const torch::Tensor& places, int64_t k) {
    places[count - k] -= k * (places[count + 1] - places[count]);
  };
  const torch::Tensor joints = out.joints;
  for (int64_t k = count; k > 0; --k) go_back(joints, k);
  if (!clip.rotations.defined() || !clip.trans.defined()) return out;
  PoseTrack track = pose_track(out);
  for (int64_t k = count; k > 0; --k) {
    const auto frame = static_cast<size_t>(count - k), first = static_cast<size_t>(count);
    track.trans[frame] -= static_cast<double>(k) * (track.trans[first + 1] - track.trans[first]);
    for (int j = 0; j < track.joints; ++j) {
      const Eigen::AngleAxisd step(track.at(count, j).conjugate() * track.at(count + 1, j));
      const double angle = step.angle() > M_PI ? step.angle() - 2 * M_PI : step.angle();
      track.at(count - k, j) =
          track.at(count, j) * Eigen::Quaterniond(Eigen::AngleAxisd(-static_cast<double>(k) * angle, step.axis()));
    }
  }
  Clip posed = out;
  set_pose(posed, track);
  posed.joints = joints;  // a person's joints that the posed skeleton only comes near to
  return posed;
}

}  // namespace

Observed observe(const Clip& clip, int64_t start, double rate, int64_t least, const std::string& name) {
  if (start < -1) throw Error("start", "is under 0");
  if (start > clip.frames())
    throw Error(name, fmt::format("frame {} is beyond the end ({} frames)", start, clip.frames()));
  const int64_t asked = start < 0 ? clip.frames() : start;
  Observed out;
  int64_t last = -1;
  if (asked > 0) out.motion = resample_through(retarget(clip, name), rate, asked - 1, last, name);
  out.start = last + 1;
  // A second of a slower file, 15 frames at 15 Hz, reaches back less than a second: its first frame stands for the time
  // from there on to the next, and what came before is as from there on.
  if (asked > 0 && out.start < least &&
      static_cast<double>(asked) / clip.rate >= static_cast<double>(least) / rate - 1e-6) {
    out.motion = left_padded(out.motion, least - out.start);
    out.start = least;
  }
  if (out.start < least)
    throw Error(name,
                fmt::format("has {} frames at {:g} a second before the start; at least {} are needed", asked, clip.rate,
                            std::llround(std::ceil(static_cast<double>(least) / rate * clip.rate - 1e-6))));
  return out;
}

}  // namespace inhabit
