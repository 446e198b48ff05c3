#include "inhabit/inbetween/interpolate_around.h"

#include "inhabit/inbetween/config.h"
#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/heading.h"
#include "inhabit/motion/pose_track.h"
#include "inhabit/scene/floor.h"

namespace inhabit::inbetween {

using Eigen::Vector2d;
using torch::Tensor;

Clip move_around_obstacles(const Clip& interpolated, const Clip& clip, const std::vector<int64_t>& keys,
                           const SceneQuery& scene) {
  Tensor groups = torch::zeros({clip.frames(), kMaskChannels});
  groups.index_fill_(0, torch::tensor(keys), 1);
  const Tensor aside = detours_of_clip(clip, groups, scene, floor_under(frames_at(clip, keys), scene));
  if (aside.abs().max().item<double>() == 0) return interpolated;
  const auto offset = aside.accessor<float, 2>();
  PoseTrack track = pose_track(interpolated);
  std::vector<Vector2d> straight(track.trans.size());
  for (size_t k = 0; k + 1 < keys.size(); ++k) {
    const Vector2d begin = on_ground(track.trans[static_cast<size_t>(keys[k])]),
                   end = on_ground(track.trans[static_cast<size_t>(keys[k + 1])]);
    for (int64_t t = keys[k]; t <= keys[k + 1]; ++t)
      straight[static_cast<size_t>(t)] =
          begin + static_cast<double>(t - keys[k]) / static_cast<double>(keys[k + 1] - keys[k]) * (end - begin);
  }
  const std::vector<double> yaws = yaws_along(straight, aside, keys);
  for (size_t k = 0; k + 1 < keys.size(); ++k) {
    if (keys[k + 1] - keys[k] < 2 || aside.slice(0, keys[k] + 1, keys[k + 1]).abs().max().item<double>() == 0) continue;
    for (int64_t t = keys[k] + 1; t < keys[k + 1]; ++t) {
      const auto frame = static_cast<size_t>(t);
      track.trans[frame].x() = straight[frame].x() + offset[t][0];
      track.trans[frame].z() = straight[frame].y() + offset[t][1];
      track.at(t, 0) = Eigen::AngleAxisd(yaws[frame], Eigen::Vector3d::UnitY()) * track.at(t, 0);
    }
  }
  Clip out = interpolated;
  set_pose(out, track);
  return out;
}

}  // namespace inhabit::inbetween
