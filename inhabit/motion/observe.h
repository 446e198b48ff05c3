#pragma once
#include <cstdint>
#include <string>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// A clip as a forecasting system takes it: on the standard skeleton at the model's rate, and the first frame to be
/// forecast.
struct Observed {
  Clip motion;        ///< standard skeleton, at the model's rate
  int64_t start = 0;  ///< frames of `motion` before it are observed; the last of them is a frame of the clip as it is
};

/// @param start first frame to forecast, counted in `clip`; -1: its end. @param least frames that must be observed, at
/// `rate`. A file of fewer frames a second that has them in seconds (15 at 15 a second for 30 at 30) goes back by the
/// rest as it begins. Throws Error("start", ...) for other numbers under 0, Error(name, ...) where the skeleton cannot
/// be mapped, `start` is beyond the end, or less is there.
Observed observe(const Clip& clip, int64_t start, double rate, int64_t least, const std::string& name);

}  // namespace inhabit
