#pragma once
#include <torch/types.h>

#include <algorithm>

#include "inhabit/inbetween/poses.h"
#include "inhabit/inbetween/scene_probe.h"

namespace inhabit::inbetween {

/// (T, 22, 3) metres: joints of poses.
inline torch::Tensor places_of(const Poses& poses) {
  torch::Tensor out = torch::empty({poses.frames(), kStandardJoints, 3});
  for (size_t i = 0; i < poses.joints.size(); ++i)
    std::copy_n(poses.joints[i].data(), 3, out.data_ptr<float>() + 3 * i);
  return out;
}

/// (T, 38, 3) metres: what guarded_points() should be of poses.
inline torch::Tensor guarded_places_of(const Poses& poses) {
  torch::Tensor ends = torch::empty({poses.frames(), static_cast<int64_t>(kLimbEnds), 3});
  float* to = ends.data_ptr<float>();
  for (int64_t t = 0; t < poses.frames(); ++t)
    for (const LimbEnd& end : limb_ends()) {
      const size_t at = Poses::at(t, end.joint);
      const Eigen::Vector3f place = poses.joints[at] + poses.rotations[at] * end.offset;
      to = std::copy_n(place.data(), 3, to);
    }
  return torch::cat({body_points(places_of(poses)), ends}, 1);
}

}  // namespace inhabit::inbetween
