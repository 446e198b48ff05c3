#include "inhabit/motion/loop.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {

Clip looped(const Clip& clip, double seconds, const std::string& subject) {
  const int64_t frames = clip.frames();
  if (frames < 4) throw Error(subject, "has " + std::to_string(frames) + " frames: four are needed for a loop");
  const int64_t seam = std::clamp<int64_t>(std::llround(seconds * clip.rate), 1, frames / 3), last = frames - seam;
  const GroundTransform to_origin = canonical_transform(clip, last), to_start = canonical_transform(clip, 0).inverse();
  const Clip end = transformed(transformed(slice(clip, last, frames), to_origin), to_start);
  std::vector<double> weights;  // of the start; eased, so that speeds and accelerations pass over as well
  torch::Tensor eased = torch::empty({seam, 1, 1});
  for (int64_t t = 0; t < seam; ++t) {
    const double gone = static_cast<double>(t) / static_cast<double>(seam);
    weights.push_back(gone * gone * gone * (10 - gone * (15 - 6 * gone)));
    eased.data_ptr<float>()[t] = static_cast<float>(weights.back());
  }
  const Clip start = slice(clip, 0, seam);
  Clip out = slice(clip, 0, last + 1);
  if (clip.rotations.defined() && clip.trans.defined()) {
    const Clip seam_poses = mixed(end, start, weights);
    for (torch::Tensor Clip::*part : {&Clip::rotations, &Clip::trans, &Clip::translations}) {
      if (!(clip.*part).defined()) continue;
      out.*part = torch::cat({seam_poses.*part, (clip.*part).slice(0, seam, last + 1)});
    }
    out.joints = torch::cat({seam_poses.joints, clip.joints.slice(0, seam, last + 1)});
  } else {
    const torch::Tensor joints = end.joints + eased * (start.joints - end.joints);
    out.joints = torch::cat({joints, clip.joints.slice(0, seam, last + 1)});
  }
  return out;
}

}  // namespace inhabit
