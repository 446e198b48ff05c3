#include "inhabit/synth/body_sweep.h"

#include <algorithm>
#include <cmath>

#include "inhabit/motion/placed_body.h"

namespace inhabit {
namespace {

constexpr double kCell = 0.2, kSampleSpacing = 0.04, kMoved = 0.008;

}  // namespace

BodySweep::BodySweep(const Clip& clip, const BodyModel& body) {
  const CapsulePoints capsules = capsule_points(clip, body, kSampleSpacing);
  const torch::Tensor points = capsules.points.to(torch::kDouble).contiguous();
  const auto p = points.accessor<double, 3>();
  const int frames = static_cast<int>(clip.frames());
  for (size_t c = 0; c < capsules.radii.size(); ++c) {
    if (capsules.joints[c] >= kStandardJoints) continue;
    for (int64_t s = capsules.first[c]; s < capsules.first[c + 1]; ++s) {
      Eigen::Vector3d last(1e9, 1e9, 1e9);
      for (int t = 0; t < frames; ++t) {
        const Eigen::Vector3d at(p[t][s][0], p[t][s][1], p[t][s][2]);
        if ((at - last).norm() < kMoved) continue;
        last = at;
        balls_.push_back({at, capsules.radii[c], capsules.joints[c], t});
      }
    }
  }
  low_ = Eigen::Vector2d(1e9, 1e9);
  high_ = -low_;
  for (const Ball& ball : balls_) {
    const Eigen::Vector2d at(ball.center.x(), ball.center.z());
    low_ = low_.cwiseMin((at.array() - ball.radius).matrix());
    high_ = high_.cwiseMax((at.array() + ball.radius).matrix());
    largest_ = std::max(largest_, ball.radius);
  }
  if (balls_.empty()) low_ = high_ = Eigen::Vector2d::Zero();
  nx_ = static_cast<int>((high_.x() - low_.x()) / kCell) + 1;
  nz_ = static_cast<int>((high_.y() - low_.y()) / kCell) + 1;
  cells_.resize(static_cast<size_t>(nx_) * static_cast<size_t>(nz_));
  for (size_t i = 0; i < balls_.size(); ++i)
    cells_[cell(static_cast<int>((balls_[i].center.x() - low_.x()) / kCell),
                static_cast<int>((balls_[i].center.z() - low_.y()) / kCell))]
        .push_back(static_cast<int>(i));
}

bool BodySweep::touches(const Furniture& piece, const Gaps& gaps) const {
  const double reach = largest_ + std::max(0.0, *std::max_element(gaps.begin(), gaps.end()));
  const Eigen::AlignedBox3d bounds = piece.bounds();
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);  // of the piece on the floor
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d corner =
        piece.pose * bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i < 2 ? i : i + 2));
    low = low.cwiseMin(Eigen::Vector2d(corner.x(), corner.z()));
    high = high.cwiseMax(Eigen::Vector2d(corner.x(), corner.z()));
  }
  auto clamped = [](double v, int n) { return std::clamp(static_cast<int>(std::floor(v / kCell)), 0, n - 1); };
  const Eigen::Vector2d from = (low - low_).array() - reach, to = (high - low_).array() + reach;
  if (to.minCoeff() < 0 || (from - (high_ - low_)).maxCoeff() > 0) return false;
  const Eigen::Isometry3d to_own = piece.pose.inverse();
  for (int z = clamped(from.y(), nz_); z <= clamped(to.y(), nz_); ++z)
    for (int x = clamped(from.x(), nx_); x <= clamped(to.x(), nx_); ++x)
      for (const int i : cells_[cell(x, z)]) {
        const Ball& ball = balls_[static_cast<size_t>(i)];
        const Eigen::Vector3d p = to_own * ball.center;
        const double near = ball.radius + gaps[static_cast<size_t>(ball.joint)];
        if (bounds.exteriorDistance(p) > std::max(near, 0.0)) continue;
        for (const Box& box : piece.boxes) {
          const Eigen::Vector3d out = (p - box.center).cwiseAbs() - box.half;
          if (out.cwiseMax(0).norm() + std::min(out.maxCoeff(), 0.0) < near) return true;
        }
      }
  return false;
}

}  // namespace inhabit
