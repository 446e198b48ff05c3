#include "inhabit/motion/floor.h"

#include <algorithm>

#include "inhabit/math/quantile.h"

namespace inhabit {
namespace {

constexpr double kBallAboveSole = 0.02;  // metres of the joint above the sole
constexpr double kStandingSpeed = 0.25;  // metres a second

}  // namespace

double floor_under(const Clip& poses) {
  const int left = poses.skeleton.find("left_foot"), right = poses.skeleton.find("right_foot");
  const bool known = left >= 0 && right >= 0;
  const torch::Tensor balls = known ? poses.joints.index_select(1, torch::tensor({left, right})) : poses.joints;
  const torch::Tensor y = balls.select(2, 1).reshape({-1});
  if (!known || poses.seconds() < 1) return y.min().item<double>() - kBallAboveSole;
  const torch::Tensor moves = torch::diff(balls, 1, 0).norm(2, 2) * poses.rate;
  const torch::Tensor speed = torch::cat({moves, moves.slice(0, -1)}).reshape({-1});
  // Slow is relative where somebody never stands still.
  const double slow = std::max(kStandingSpeed, torch::quantile(speed, 0.15).item<double>());
  return torch::quantile(y.index({speed <= slow}), 0.1).item<double>() - kBallAboveSole;
}

double floor_under_lowest(std::vector<double> lower_balls) {
  const size_t low = lower_balls.size() / 20;
  return nth_smallest(std::move(lower_balls), low) - kBallAboveSole;
}

}  // namespace inhabit
