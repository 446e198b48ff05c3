#include "inhabit/interact/guide.h"

#include <algorithm>
#include <cmath>

namespace inhabit::interact {
namespace {

constexpr size_t kWalkIndex = 1;                  // of the actions
constexpr double kSlowest = 0.6, kFastest = 1.4;  // metres a second along a route
constexpr double kStands = 0.25;                  // metres a second: who is slower has not set off, or stands

/// Seconds from now of a sample.
double seconds_ahead(int sample) { return static_cast<double>(sample - kNow) / (kSamples - 1 - kNow); }

}  // namespace

void Guide::follow(const Eigen::Vector2d& here) {
  constexpr double kAtOnce = 0.5, kStep = 0.02;
  double nearest = HUGE_VAL;
  const double last = std::min(along_ + kAtOnce, route_.total());
  for (double s = along_; s <= last; s += kStep) {
    const double far = (route_.at(s) - here).norm();
    if (far >= nearest) continue;
    nearest = far;
    along_ = s;
  }
}

void Guide::draw(State& state) const {
  const auto predicted = static_cast<double>((state.samples.back().root.position - state.now().root.position).norm());
  const double speed = std::clamp(predicted, kSlowest, kFastest);
  // Who stands sets off by themselves: a trajectory that runs ahead of who is not ready to keeps them standing.
  const double drawn = kDrawn * std::clamp((predicted - kStands) / (kSlowest - kStands), 0.0, 1.0);
  for (int i = kNow + 1; i < kSamples; ++i) {
    Sample& sample = state.samples[static_cast<size_t>(i)];
    Place& root = sample.root;
    const double s = along_ + speed * seconds_ahead(i), weight = drawn * std::sqrt(seconds_ahead(i));
    const Eigen::Vector2d place = root.position.cast<double>();
    root.position = (place + weight * (route_.at(s) - place)).cast<float>();
    const double heading = heading_of(root.facing.cast<double>());
    root.facing = ahead_of(heading + weight * wrapped(route_.heading(s) - heading)).cast<float>();
    for (size_t a = 0; a < kActions; ++a)
      sample.action[a] += static_cast<float>(weight) * ((a == kWalkIndex ? 1.F : 0.F) - sample.action[a]);
  }
}

void hold(const Eigen::Vector2d& place, State& state) {
  for (int i = kNow + 1; i < kSamples; ++i) {
    Eigen::Vector2f& position = state.samples[static_cast<size_t>(i)].root.position;
    position += static_cast<float>(std::sqrt(seconds_ahead(i))) * (place.cast<float>() - position);
  }
}

void draw_before(const Chair& chair, State& state) {
  constexpr float kNear = 1.0F, kBehind = -0.1F;  // metres from the middle of the seat
  const Place seat{on_ground(chair.seat()).cast<float>(), ahead_of(chair.heading()).cast<float>()};
  for (int i = kNow + 1; i < kSamples; ++i) {
    Place& root = state.samples[static_cast<size_t>(i)].root;
    Eigen::Vector2f place = seat.turned_in(Eigen::Vector2f(root.position - seat.position));
    if (place.norm() > kNear || place.y() < kBehind) continue;
    place.x() *= static_cast<float>(1 - std::sqrt(seconds_ahead(i)));
    root.position = seat.position + seat.turned_out(place);
  }
}

}  // namespace inhabit::interact
