#include "inhabit/metrics/foot_skating.h"

namespace inhabit {

FootSkating foot_skating(const Clip& clip, double height, double distance) {
  FootSkating out;
  out.frames = std::max<int64_t>(0, clip.frames() - 1);
  if (out.frames == 0) return out;
  const torch::Tensor feet = foot_positions(clip.joints);
  const torch::Tensor now = feet.slice(0, 0, -1), next = feet.slice(0, 1);
  const torch::Tensor slides = (now.select(2, 1) < height) & ((next - now).norm(2, 2) > distance);
  out.skating = slides.any(1).sum().item<int64_t>();
  return out;
}

}  // namespace inhabit
