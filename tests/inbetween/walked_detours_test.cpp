// Protects the detours that people walked, which the denoiser is trained to keep to: where the line is blocked alone,
// from key to key, without the sway of steps, at even speed.
#include "inhabit/inbetween/walked_detours.h"

#include <gtest/gtest.h>

#include "inbetween/table_detour.h"
#include "inbetween/whole_keys.h"

namespace inhabit::inbetween {
namespace {

/// A second in place, three on a half circle around the table with the sway of steps, one a second.
Clip walked_half_circle() {
  Clip clip = table_detour(121, 30).ends;
  const Tensor t = torch::arange(121, torch::kFloat32), on = ((t - 30).clamp_min(0) / 90) * M_PI;
  const Tensor radius = kAway + 0.03 * torch::sin(on * 6);
  const Tensor root = torch::stack({radius * torch::sin(on), torch::zeros({121}), -radius * torch::cos(on)}, 1);
  Tensor moved = root - clip.joints.select(1, 0);
  moved.select(1, 1).zero_();
  clip.trans = clip.trans + moved;
  clip.joints = clip.joints + moved.unsqueeze(1);
  return clip;
}

TEST(WalkedDetours, AreThePathThatWasTakenAtEvenSpeed) {
  const SceneDistances scene(table_room());
  const Clip walked = walked_half_circle();
  const Tensor detours = walked_detours(poses_of(walked), whole_keys(121, {0, 120}), scene);
  EXPECT_EQ(detours[0].abs().max().item<float>(), 0);
  EXPECT_EQ(detours[120].abs().max().item<float>(), 0);
  const Tensor part = torch::linspace(0, 1, 121), from = walked.joints[0][0], to = walked.joints[120][0];
  const auto along = [&](int64_t axis) { return from[axis] + part * (to[axis] - from[axis]); };
  const Tensor path = torch::stack({along(0), along(2)}, 1) + detours;  // (121, x z)
  const Tensor off = path.norm(2, {1}) - kAway;
  // The mean over a second of a circle lies within it.
  const double half = M_PI / 6, within = kAway * (1 - std::sin(half) / half);
  EXPECT_LT((off + within).slice(0, 25, 96).abs().max().item<double>(), 0.012)
      << "on the circle, without the sway of 3 cm";
  EXPECT_GT(path[60][0].item<double>(), 0.9 * kAway) << "half of the path in half of the time";
  const Tensor speed = path.diff(1, 0).norm(2, {1});
  EXPECT_NEAR(speed.max().item<double>(), speed.mean().item<double>(), 0.1 * speed.mean().item<double>());
  EXPECT_EQ(walked_detours(poses_of(walked), whole_keys(121, {0, 120}), SceneDistances()).abs().max().item<float>(), 0)
      << "nothing stands there";
}

}  // namespace
}  // namespace inhabit::inbetween
