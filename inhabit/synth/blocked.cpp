#include "inhabit/synth/blocked.h"

#include <algorithm>

#include "inhabit/body/body_model.h"
#include "inhabit/each_item.h"
#include "inhabit/error.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

Clip straight_between(const Clip& window, int64_t every) {
  PoseTrack track = pose_track(window);
  for (int64_t t = 0; t + 1 < track.frames(); t += every)
    interpolate_between(track, t, std::min(t + every, track.frames() - 1));
  Clip out = person_of(window);
  set_pose(out, track);
  return out;
}

BlockedWindows measure_clip(const Clip& clip, const CollisionMeter& meter, const BlockedOptions& options) {
  BlockedWindows out;
  out.clips = 1;
  for (int64_t first = 0; first + options.frames <= clip.frames(); first += options.stride) {
    const Clip window = slice(clip, first, first + options.frames);
    const double real = meter.measure(window).frame_ratio();
    const double straight = meter.measure(straight_between(window, options.every)).frame_ratio();
    ++out.windows;
    out.real += real;
    out.straight += straight;
    out.colliding += real > 0 ? 1 : 0;
    out.blocked += real == 0 && straight > 0 ? 1 : 0;
  }
  return out;
}

}  // namespace

BlockedWindows blocked_windows(const Dataset& dataset, const std::string& split, const BlockedOptions& options) {
  if (options.every < 1 || options.stride < 1 || options.frames < 3 || options.clips < 0)
    throw Error("windows", "have a length under 3 frames, or keys or starts under 1 frame apart");
  std::vector<DatasetClip> clips = dataset.split(split);
  std::erase_if(clips, [&](const DatasetClip& c) { return c.scene.empty() || c.frames < options.frames; });
  if (options.clips > 0 && static_cast<int64_t>(clips.size()) > options.clips) {
    for (int64_t i = 0; i < options.clips; ++i)
      clips[static_cast<size_t>(i)] =
          clips[static_cast<size_t>(i * static_cast<int64_t>(clips.size()) / options.clips)];
    clips.resize(static_cast<size_t>(options.clips));
  }
  std::vector<BlockedWindows> found(clips.size());
  each_item(static_cast<int64_t>(clips.size()), {}, [&](int64_t item) {
    const auto i = static_cast<size_t>(item);
    const CollisionMeter meter(builtin_body(), load_scene(dataset, clips[i].scene));
    found[i] = measure_clip(load_clip(dataset, clips[i]), meter, options);
  });
  BlockedWindows out;
  for (const BlockedWindows& one : found) {
    out.clips += one.clips, out.windows += one.windows;
    out.colliding += one.colliding, out.blocked += one.blocked;
    out.straight += one.straight, out.real += one.real;
  }
  if (out.windows > 0) {
    out.straight /= static_cast<double>(out.windows);
    out.real /= static_cast<double>(out.windows);
  }
  return out;
}

}  // namespace inhabit
