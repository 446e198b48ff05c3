#include "inhabit/io/write_options.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/motion/loop.h"
#include "inhabit/motion/resample.h"

namespace inhabit {
namespace {

constexpr double kSeam = 0.5;  // seconds

/// First frame, and the one after the last.
std::pair<int64_t, int64_t> between(const Clip& clip, const WriteOptions& options) {
  const auto first = static_cast<int64_t>(std::ceil(options.from * clip.rate - 1e-6));
  const int64_t last =
      options.to ? std::min(clip.frames(), static_cast<int64_t>(std::floor(*options.to * clip.rate + 1e-6)) + 1)
                 : clip.frames();
  const std::string has =
      fmt::format("the motion has {} frames at {:g} a second, {:.2f} s", clip.frames(), clip.rate, clip.seconds());
  if (first >= clip.frames()) throw Error(fmt::format("--from {:g}", options.from), "is beyond the end: " + has);
  if (first >= last)
    throw Error(fmt::format("--from {:g} --to {:g}", options.from, options.to.value_or(0)), "leave nothing: " + has);
  return {first, last};
}

Clip with_up(Clip clip, UpAxis up, const std::string& path) {
  if (up == UpAxis::automatic) return clip;
  const std::string format = extension_of(path);
  // Of another format than it came from: units and channels are ours.
  const bool same = clip.file.format == format || (clip.file.format == "smpl" && format == "npz");
  if (!same) {
    clip.file = {};
    clip.file.format = format;
    clip.file.metres_per_unit = 0.01;
  }
  clip.file.z_up = up == UpAxis::z;
  return clip;
}

}  // namespace

void require_written_as(const WriteOptions& options, const std::string& path) {
  const std::string format = extension_of(path);
  if (options.up == UpAxis::z && format != "bvh" && format != "npz")
    throw Error(path, "is +Y up by its format; --out-up z is for .bvh and .npz");
  if (options.to && *options.to < options.from)
    throw Error(fmt::format("--from {:g} --to {:g}", options.from, *options.to), "leave nothing");
}

Clip to_be_written(const Clip& clip, const WriteOptions& options, const std::string& path) {
  if (!options.any()) return clip;
  require_written_as(options, path);
  const auto [first, last] = between(clip, options);
  Clip out = slice(clip, first, last);
  if (options.loop) out = looped(out, kSeam, path);
  if (options.rate > 0) out = resample(out, options.rate, path);
  return with_up(std::move(out), options.up, path);
}

torch::Tensor frames_written(const Clip& clip, const WriteOptions& options) {
  const Clip out = to_be_written(clip, options, "motion.npz");
  const auto [first, last] = between(clip, options);
  const torch::Tensor at = (torch::arange(out.frames(), torch::kFloat64) * (clip.rate / out.rate)).round() + first;
  return at.to(torch::kInt64).clamp_max(last - 1);
}

}  // namespace inhabit
