#include "inhabit/synth/footsteps.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/random.h"
#include "inhabit/synth/curves.h"

namespace inhabit {

using Eigen::Vector2d;

StepPlan::StepPlan(const Figure& figure, const GaitStyle& style, const Vector2d& place, double heading)
    : figure_(&figure), style_(style), heading_(heading) {
  for (int side = 0; side < 2; ++side) start_[side] = foothold_[side] = rest_foothold(side, place, heading);
}

Foothold StepPlan::rest_foothold(int side, const Vector2d& place, double heading) const {
  const double out = (side == 0 ? 1 : -1) * std::max(0.5 * style_.width + 0.035, 0.075);
  return {place + left_of(heading) * out + ahead_of(heading) * figure_->ankle_ahead,
          heading + (side == 0 ? 1 : -1) * style_.toe_out};
}

Vector2d StepPlan::place() const {
  return 0.5 * (foothold_[0].place + foothold_[1].place) - ahead_of(heading_) * figure_->ankle_ahead;
}

void StepPlan::add(int side, const Foothold& foothold, double lift, double land) {
  steps_.push_back({side, foothold, lift, land});
  foothold_[side] = foothold;
  now_ = land;
}

double StepPlan::walk(const WalkPath& path, double speed, std::mt19937_64& random) {
  const double total = path.total();
  // Step length L and cadence c from v = L c and the walk ratio L / c.
  const double stature = figure_->leg() / 0.83;
  const double wanted = std::sqrt(speed * 60 * style_.walk_ratio) * stature;
  // The first step is short, the last but one too; the closing one goes beside.
  auto weight = [](int k, int n) { return k == 0 ? 0.8 : k == n - 1 ? 0.8 : 1.0; };
  auto weights = [&](int n) {
    double sum = 0;
    for (int k = 0; k < n; ++k) sum += weight(k, n);
    return sum;
  };
  int n = 1;
  while (total / weights(n) > wanted * 1.06) ++n;
  const double length = total / weights(n);
  const double period = std::clamp(length / speed, 0.44, 0.78);
  const double first_turn = wrapped(path.heading(std::min(0.4, total)) - heading_);
  int side = std::abs(first_turn) > 0.2 ? (first_turn > 0 ? 0 : 1) : uniform_int(random, 0, 1);

  double lift = now_ + 0.3, s = 0, last_landing = now_;
  for (int k = 0; k <= n; ++k, side = 1 - side) {
    const bool closing = k == n;
    if (!closing) s += length * weight(k, n);
    const double heading = path.heading(s);
    const Vector2d middle = path.at(s);
    const double out = (side == 0 ? 1 : -1) * (0.5 * style_.width + 0.01 * normal(random) * (closing ? 0 : 1));
    Foothold foothold{middle + left_of(heading) * out + ahead_of(heading) * figure_->ankle_ahead,
                      heading + (side == 0 ? 1 : -1) * style_.toe_out * (closing ? 1 : 0.8)};
    if (closing) foothold = rest_foothold(side, middle, heading);
    const double paced = period * (1 + 0.015 * normal(random)) * (k == 0 ? 1.08 : closing ? 0.98 : 1.0);
    const double swing = paced * (1 - style_.double_support);
    if (closing) last_landing = lift + 0.3 * swing;
    add(side, foothold, lift, lift + swing);
    lift += paced;
    heading_ = heading;
  }
  return last_landing;
}

void StepPlan::turn(double heading, const Vector2d& to, std::mt19937_64& random) {
  const double whole = wrapped(heading - heading_);
  const Vector2d here = place();
  const int count = 1 + std::max(1, static_cast<int>(std::ceil(std::abs(whole) / uniform(random, 0.95, 1.25))));
  int side = whole > 0 ? 0 : 1;
  const double from = heading_, period = uniform(random, 0.38, 0.48);
  double lift = now_ + 0.26;
  for (int k = 0; k < count; ++k, side = 1 - side) {
    // Each step opens a little further; the last closes.
    const double done = std::min(1.0, (k + 1.0) / (count - 1.0));
    const Vector2d middle = here + (to - here) * minimum_jerk(done);
    add(side, rest_foothold(side, middle, from + whole * done), lift, lift + period * 0.78);
    lift += period * (1 + 0.03 * normal(random));
  }
  heading_ = from + whole;
}

}  // namespace inhabit
