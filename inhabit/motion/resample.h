#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// The clip at another frame rate. Frame 0 stays, the last new frame is the last that is not after the old end.
/// Rotations by slerp between the neighbouring frames, the root (trans) and joints that translate by the cubic Hermite
/// spline with central differences (Catmull-Rom), exact for paths of constant acceleration; then `joints` by forward
/// kinematics, plus the interpolated difference there was to it (a person's joints that the posed skeleton only comes
/// near to). Without rotations `joints` by the cubic. Actions and contacts are those of the nearest frame; a hand's
/// target point is interpolated while it holds, object places linearly and by slerp. Going down skips frames without a
/// filter. Throws Error(subject, ...) where the rate is not in (0, 1000], or the clip has no frame or would have over
/// 50 million joint places.
Clip resample(const Clip& clip, double rate, const std::string& subject = "motion");

/// The same with new frames placed so that one of them is frame `frame` of the clip as it is: as many before it as the
/// clip reaches back. @param at set to its number among the new ones.
Clip resample_through(const Clip& clip, double rate, int64_t frame, int64_t& at, const std::string& subject = "motion");

/// The clip at any times, counted in its frames and clamped to them, in the same way. The rate stays what it was.
Clip at_frames(const Clip& clip, const std::vector<double>& frames);

/// Places of something (T, ...) at such times, by the cubic.
torch::Tensor at_frames(const torch::Tensor& places, const std::vector<double>& frames);

}  // namespace inhabit
