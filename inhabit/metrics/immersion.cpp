#include "inhabit/metrics/immersion.h"

#include <fmt/format.h>

#include <algorithm>

#include "inhabit/motion/resample.h"

namespace inhabit {
namespace {

constexpr int64_t kFramesOfStretch = 8;  ///< that are looked at

}  // namespace

std::string Immersion::text() const {
  return depth > 0 ? fmt::format("{:.0f} mm in {}", depth * 1000, object) : std::string();
}

std::vector<Immersion> immersions_of(const CollisionMeter& meter, const Clip& clip,
                                     const std::vector<int64_t>& frames) {
  std::vector<Immersion> out;
  if (frames.empty()) return out;
  out.reserve(frames.size());
  const Collision found = meter.measure(at_frames(clip, std::vector<double>(frames.begin(), frames.end())));
  const std::vector<std::string> objects = meter.nearest_objects(found.deepest);
  for (size_t k = 0; k < frames.size(); ++k) {
    const auto depth = found.depth[static_cast<int64_t>(k)].item<double>();
    out.push_back({frames[k], depth, depth > 0 ? objects[k] : ""});
  }
  return out;
}

std::vector<Immersion> immersions_of_stretches(const CollisionMeter& meter, const Clip& clip,
                                               const torch::Tensor& collides) {
  std::vector<int64_t> frames, stretch_of;
  const torch::Tensor flags = collides.to(torch::kBool).contiguous();
  const bool* inside = flags.data_ptr<bool>();
  int64_t stretches = 0;
  for (int64_t first = 0, last = 0; first < flags.numel(); first = last) {
    last = first + 1;
    if (!inside[first]) continue;
    while (last < flags.numel() && inside[last]) ++last;
    const int64_t count = std::min(kFramesOfStretch, last - first);
    for (int64_t k = 0; k < count; ++k) {
      frames.push_back(first + (2 * k + 1) * (last - first) / (2 * count));
      stretch_of.push_back(stretches);
    }
    ++stretches;
  }
  std::vector<Immersion> out(static_cast<size_t>(stretches));
  const std::vector<Immersion> found = immersions_of(meter, clip, frames);
  for (size_t k = 0; k < found.size(); ++k) {
    Immersion& deepest = out[static_cast<size_t>(stretch_of[k])];
    if (deepest.object.empty() || found[k].depth > deepest.depth) deepest = found[k];
  }
  return out;
}

}  // namespace inhabit
