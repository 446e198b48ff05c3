#include "inhabit/inbetween/window_scores.h"

#include <string>

#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/foot_skating.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

constexpr double kLowPelvis = 0.85;  // of the length of thigh and shin

void add_collisions(WindowScores& out, size_t first, const Collision& collision) {
  out.sum[first] = collision.frame_ratio();
  out.sum[first + 1] = collision.vertex_ratio();
  out.sum[first + 2] = collision.penetration() * 1000;
  for (size_t m = first; m < first + 3; ++m) out.weight[m] = 1;
}

/// Over the frames in `mask`: fractions count by frames, the deepest by windows.
void add_collisions(WindowScores& out, size_t first, const Collision& collision, const Tensor& mask) {
  if (!mask.defined()) return;
  const auto count = static_cast<double>(mask.sum().item<int64_t>());
  if (count == 0) return;
  out.sum[first] = collision.frame_ratio(mask) * count;
  out.sum[first + 1] = collision.vertex_ratio(mask) * count;
  out.weight[first] = out.weight[first + 1] = count;
  out.sum[first + 2] = collision.penetration(mask) * 1000;
  out.weight[first + 2] = 1;
}

}  // namespace

Tensor sitting_frames(const Clip& clip) {
  const Tensor bones = clip.skeleton.offsets.norm(2, 1);
  const double leg = (bones[4] + bones[7]).item<double>();
  Tensor out = clip.root_path().select(1, 1) < kLowPelvis * leg;
  if (!clip.action.defined()) return out;
  for (size_t a = 0; a < clip.action_names.size(); ++a) {
    const std::string& name = clip.action_names[a];
    if (name.rfind("sit", 0) == 0 || name == "lean_back" || name == "stand_up")
      out = out | (clip.action == static_cast<int64_t>(a));
  }
  return out;
}

WindowScores window_scores(const Clip& clip, const Compared& with, const CollisionMeter& meter,
                           const CollisionTolerance& tolerance) {
  WindowScores out;
  const auto set = [&](Measure m, double value) {
    out.sum[m] = value;
    out.weight[m] = 1;
  };
  set(kSkating, foot_skating(clip).fraction());
  const Dynamics moves = dynamics(clip);
  set(kJerk, moves.jerk);
  set(kAcceleration, moves.acceleration);
  out.sum[kJerkRatio] = moves.jerk;
  out.weight[kJerkRatio] = dynamics(with.truth).jerk;
  const Tensor distance = (clip.joints - with.truth.joints).to(torch::kDouble).norm(2, {2}) * 1000;  // (T, J)
  Tensor at_keys = distance.index_select(0, torch::tensor(with.keys));
  if (!with.joints.empty()) at_keys = at_keys.slice(0, 1, -1).index_select(1, torch::tensor(with.joints));
  if (at_keys.numel() > 0) set(kKeyError, at_keys.mean().item<double>());
  if (with.known) set(kError, distance.mean().item<double>());
  const std::vector<Collision> collisions = meter.measure(clip, {tolerance, kNoTolerance});
  add_collisions(out, kFrames, collisions[0]);
  add_collisions(out, kExactFrames, collisions[1]);
  add_collisions(out, kCloseFrames, collisions[0], with.close);
  add_collisions(out, kUprightFrames, collisions[0], with.upright);
  return out;
}

}  // namespace inhabit::inbetween
