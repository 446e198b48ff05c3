#include "inhabit/inbetween/interpolate_around.h"

#include <algorithm>

#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/heading.h"
#include "inhabit/math/smooth_step.h"
#include "inhabit/motion/pose_track.h"
#include "inhabit/scene/floor.h"

namespace inhabit::inbetween {
namespace {

using Eigen::Vector2d;
using torch::Tensor;

constexpr double kTurning = 0.5;  // seconds around keys in which the heading comes back to theirs
constexpr int64_t kAlong = 3;     // frames to either side that tell where the path goes

}  // namespace

Clip along_way_around(const Clip& interpolated, const Clip& clip, const std::vector<int64_t>& keys,
                      const SceneQuery& scene) {
  Tensor groups = torch::zeros({clip.frames(), kMaskChannels});
  groups.index_fill_(0, torch::tensor(keys), 1);
  const Tensor aside = detours_of_clip(clip, groups, scene, floor_under(frames_at(clip, keys), scene));
  if (aside.abs().max().item<double>() == 0) return interpolated;
  const auto offset = aside.accessor<float, 2>();
  PoseTrack track = pose_track(interpolated);
  for (size_t k = 0; k + 1 < keys.size(); ++k) {
    const int64_t from = keys[k], to = keys[k + 1];
    if (to - from < 2 || aside.slice(0, from + 1, to).abs().max().item<double>() == 0) continue;
    const Vector2d begin = on_ground(track.trans[static_cast<size_t>(from)]),
                   end = on_ground(track.trans[static_cast<size_t>(to)]);
    const auto place = [&](int64_t t) -> Vector2d {
      const double u = static_cast<double>(t - from) / static_cast<double>(to - from);
      return begin + u * (end - begin) + Vector2d(offset[t][0], offset[t][1]);
    };
    for (int64_t t = from + 1; t < to; ++t) {
      const Vector2d here = place(t), along = place(std::min(to, t + kAlong)) - place(std::max(from, t - kAlong));
      track.trans[static_cast<size_t>(t)].x() = here.x();
      track.trans[static_cast<size_t>(t)].z() = here.y();
      const double near = static_cast<double>(std::min(t - from, to - t)) / (kTurning * clip.rate);
      const double turn = smooth_step(near) * wrapped(inhabit::heading_of(along) - inhabit::heading_of(end - begin));
      track.at(t, 0) = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()) * track.at(t, 0);
    }
  }
  Clip out = interpolated;
  set_pose(out, track);
  return out;
}

}  // namespace inhabit::inbetween
