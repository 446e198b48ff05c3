#include "inhabit/scene/steering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "inhabit/math/rotation.h"

namespace inhabit {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;
using torch::Tensor;

namespace {

constexpr double kDegrees = M_PI / 180;
constexpr double kClearance = 0.35;                     // metres that the root keeps from obstacles
constexpr double kAhead = 2, kDecision = 0.2;           // seconds that a choice looks ahead, and between two of them
constexpr std::array<double, 2> kTurning = {0.8, 1.6};  // seconds for which a rate that is tried goes on
constexpr double kNearing = 0.15;                       // seconds in which the rate follows what is chosen
constexpr std::array<double, 15> kRates = {0,   -20, 20,   -45, 45,   -70, 70,  // degrees a second
                                           -95, 95,  -120, 120, -160, 160, -200, 200};
constexpr double kRateCost = 0.004, kChangeCost = 0.004;  // of (rate / 45 degrees a second)^2, and of its change
// A root nearer than that to something goes through it; one that has not been farther off yet: nearer by kDeeper.
constexpr double kThrough = 0.1, kDeeper = 0.05;  // metres
constexpr double kThroughCost = 4;                // of each second from there on
constexpr double kStandstill = 0.02;              // metres in the time ahead: nobody walks

/// Where the root goes, frame by frame, under a rotation that changes.
class Steering {
 public:
  Steering(std::vector<Vector2d> path, double rate, const FreeSpace& floor)
      : path_(std::move(path)), seconds_(1 / rate), floor_(floor) {}

  /// Radians that each frame is rotated by, and where its root is then.
  void run(std::vector<double>& angles, std::vector<Vector2d>& places) {
    const auto frames = static_cast<int64_t>(path_.size());
    const auto every = std::max<int64_t>(1, std::llround(kDecision / seconds_));
    angles.assign(path_.size(), 0);
    places = path_;
    double chosen = 0, rate = 0;
    for (int64_t t = 0; t + 1 < frames; ++t) {
      const auto i = static_cast<size_t>(t);
      kept_ = std::max(kept_, std::min(kClearance, clearance(places[i])));
      if (t % every == 0) chosen = choice(t, places[i], angles[i], rate);
      rate += (chosen - rate) * std::min(1.0, seconds_ / kNearing);
      angles[i + 1] = angles[i] + rate * seconds_;
      places[i + 1] = places[i] + step(t, angles[i]);
    }
  }

 private:
  /// Metres to what stands there; beyond the grid nothing does.
  double clearance(const Vector2d& at) const {
    const Vector2d last = floor_.point(floor_.nx - 1, floor_.nz - 1);
    const bool within = (at - floor_.origin).minCoeff() > 0 && (last - at).minCoeff() > 0;
    return within ? floor_.at(at) : FreeSpace::kFarthest;
  }

  /// A positive angle rotates +Z towards +X, as headings do.
  Vector2d step(int64_t t, double angle) const {
    const Vector2d moved = path_[static_cast<size_t>(t) + 1] - path_[static_cast<size_t>(t)];
    return Rotation2Dd(-angle) * moved;  // (x, z): the other way round than (x, y)
  }

  double choice(int64_t t, const Vector2d& from, double angle, double now) const {
    const int64_t end =
        std::min(static_cast<int64_t>(path_.size()) - 1, t + static_cast<int64_t>(std::llround(kAhead / seconds_)));
    if ((path_[static_cast<size_t>(end)] - path_[static_cast<size_t>(t)]).norm() < kStandstill) return 0;
    double best = 0, least = std::numeric_limits<double>::infinity();
    for (size_t tried = 0; tried < kRates.size() * kTurning.size(); ++tried) {
      const double rate = kRates[tried / kTurning.size()] * kDegrees;
      const auto turning = static_cast<int64_t>(std::llround(kTurning[tried % kTurning.size()] / seconds_));
      Vector2d at = from;
      double rotated = angle, cost = 0;
      bool through = false;
      for (int64_t k = t; k < end; ++k) {
        if (k - t < turning) rotated += rate * seconds_;
        at += step(k, rotated);
        const double clear = clearance(at), lacks = std::max(0.0, kept_ - clear) / kClearance;
        through = through || clear < std::min(kThrough, kept_ - kDeeper);
        cost += (through ? kThroughCost : lacks * lacks) * seconds_;
      }
      const auto relative = [](double r) { return r / (45 * kDegrees) * (r / (45 * kDegrees)); };
      cost += kRateCost * relative(rate) + kChangeCost * relative(rate - now);
      if (cost < least) least = cost, best = rate;
    }
    return best;
  }

  std::vector<Vector2d> path_;
  double seconds_;  // of a frame
  const FreeSpace& floor_;
  double kept_ = -FreeSpace::kFarthest;  // metres that are kept: as many as there were so far, kClearance at most
};

}  // namespace

Clip steered(const Clip& clip, const FreeSpace& floor) {
  const int64_t frames = clip.frames();
  if (frames < 2) return clip;
  const Tensor root = clip.root_path().to(torch::kFloat64).contiguous();
  const auto r = root.accessor<double, 2>();
  std::vector<Vector2d> path, places;
  for (int64_t t = 0; t < frames; ++t) path.emplace_back(r[t][0], r[t][2]);
  std::vector<double> angles;
  Steering(path, clip.rate, floor).run(angles, places);
  if (std::all_of(angles.begin(), angles.end(), [](double a) { return a == 0; })) return clip;

  const Tensor yaw = torch::zeros({frames, 3}), moved = torch::zeros({frames, 1, 3});
  auto rotated = yaw.accessor<float, 2>();
  auto to = moved.accessor<float, 3>();
  for (int64_t t = 0; t < frames; ++t) {
    const auto i = static_cast<size_t>(t);
    rotated[t][1] = static_cast<float>(angles[i]);
    to[t][0][0] = static_cast<float>(places[i].x());
    to[t][0][2] = static_cast<float>(places[i].y());
  }
  const Tensor matrices = axis_angle_to_matrix(yaw);  // (T, 3, 3)
  const Tensor level = clip.root_path().clone().unsqueeze(1);
  level.select(2, 1).zero_();
  Clip out = clip;
  out.joints = torch::matmul(clip.joints - level, matrices.transpose(1, 2)) + moved;
  if (clip.rotations.defined()) {
    out.rotations = clip.rotations.clone();
    out.rotations.select(1, 0).copy_(
        matrix_to_axis_angle(torch::matmul(matrices, axis_angle_to_matrix(clip.rotations.select(1, 0)))));
  }
  if (clip.trans.defined()) out.trans = clip.trans + (out.joints.select(1, 0) - clip.joints.select(1, 0));
  return out;
}

}  // namespace inhabit
