#include "inhabit/motion/observe.h"

#include <spdlog/fmt/fmt.h>

#include "inhabit/error.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"

namespace inhabit {

Observed observe(const Clip& clip, int64_t start, double rate, int64_t least, const std::string& name) {
  if (start > clip.frames())
    throw Error(name, fmt::format("frame {} is beyond the end ({} frames)", start, clip.frames()));
  const int64_t asked = start < 0 ? clip.frames() : start;
  Observed out;
  int64_t last = -1;
  if (asked > 0) out.motion = resample_through(retarget(clip, name), rate, asked - 1, last, name);
  out.start = last + 1;
  if (out.start < least)
    throw Error(name, fmt::format("has {} frames at {:g} a second before the start; at least {} are needed", out.start,
                                  rate, least));
  return out;
}

}  // namespace inhabit
