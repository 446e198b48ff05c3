#include "inhabit/synth/life_writer.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/random.h"

namespace inhabit {

using Eigen::Vector2d;
using Eigen::Vector3d;

GaitStyle draw_gait(std::mt19937_64& random) {
  GaitStyle gait;
  gait.speed = std::clamp(normal(random, 1.32, 0.11), 1.1, 1.55);
  gait.walk_ratio = 0.0061 * std::clamp(normal(random, 1, 0.06), 0.88, 1.12);
  gait.width = std::clamp(normal(random, 0.09, 0.025), 0.04, 0.15);
  gait.toe_out = uniform(random, 0.03, 0.16);
  gait.clearance = uniform(random, 0.038, 0.055);
  gait.double_support = uniform(random, 0.22, 0.27);
  gait.push_off = uniform(random, 0.92, 1.08);
  return gait;
}

Manner draw_manner(std::mt19937_64& random) {
  Manner manner;
  manner.arm_swing = uniform(random, 0.38, 0.8);
  manner.arms_out = uniform(random, 0.12, 0.22);
  manner.elbow = uniform(random, 0.14, 0.32);
  manner.upright = uniform(random, -0.01, 0.05);
  manner.sway = uniform(random, 0.7, 1.3);
  manner.pace = uniform(random, 0.85, 1.2);
  return manner;
}

void LifeWriter::stand_about(double seconds) {
  does(Action::stand);
  const double from = now(), until = from + seconds;
  double t = from + 0.3;
  while (t + 0.9 < until) {
    const double hold = uniform(random_, 0.8, 2.2);
    const double side = chance(random_, 0.5) ? 1 : -1;
    life_->favour.add(t, 0);
    life_->favour.add(t + 0.7, side * uniform(random_, 0.25, 0.6));
    const double back = std::min(t + 0.7 + hold, until - 0.1);
    life_->favour.add(back, side * uniform(random_, 0.25, 0.6));
    life_->favour.add(back + 0.7, 0);
    if (chance(random_, 0.5)) look_about(t, std::min(t + 1.6, until));
    if (chance(random_, 0.3)) gesture(t, std::min(until, t + uniform(random_, 1.2, 2.4)), false);
    t = back + 0.8;
  }
  life_->steps.wait(seconds);
}

void LifeWriter::look_about(double from, double until) {
  if (until - from < 0.8) return;
  const Vector2d ahead = ahead_of(life_->steps.heading() + uniform(random_, -1.0, 1.0)) * 2;
  const Vector2d p = life_->steps.place() + ahead;
  life_->looks.push_back(
      {{from, from + 0.45, until - 0.4, until + 0.1}, Vector3d(p.x(), uniform(random_, 0.7, 1.7), p.y())});
}

void LifeWriter::gesture(double from, double until, bool seated) {
  const int both = uniform_int(random_, 0, 2);
  double t = from;
  bool any = false;
  while (t + 0.9 < until) {
    const double go = uniform(random_, 0.45, 0.7), hold = uniform(random_, 0.1, 0.5),
                 back = uniform(random_, 0.45, 0.75);
    for (int side = 0; side < 2; ++side) {
      if (both != 2 && both != side) continue;
      const double mirror = side == 0 ? 1 : -1;
      HandTrip trip;
      trip.side = side;
      trip.when = {t + uniform(random_, 0, 0.1), t + go + 0.1, t + go + 0.1 + hold, t + go + 0.1 + hold + back};
      trip.pull.anchor = 9;
      // From the upper chest's joint: beside, below and in front.
      trip.pull.place = {mirror * uniform(random_, 0.06, 0.26), uniform(random_, seated ? -0.12 : -0.18, 0.06),
                         uniform(random_, 0.24, 0.36)};
      const Vector3d ahead =
          Vector3d(-mirror * uniform(random_, 0.1, 0.7), uniform(random_, -0.1, 0.6), 1).normalized();
      const Vector3d palm = Vector3d(-mirror, uniform(random_, -0.8, 0.8), 0.1).normalized();
      trip.pull.rotation = hand_rotation(side, ahead, palm);
      trip.pull.swivel = uniform(random_, 0.25, 0.6);
      life_->hands.push_back(trip);
      any = true;
    }
    t += go + hold + uniform(random_, 0.2, 0.45);
  }
  if (!any) return;
  does_at(from, Action::gesture);
  does_at(until, seated ? Action::sit : Action::stand);
}

bool LifeWriter::go(const Vector2d& place, double least, double margin) {
  const Vector2d here = life_->steps.place();
  if ((place - here).norm() < least) return false;
  auto path = find_path(floor_, here, place, margin);
  if (!path) path = find_path(floor_, here, place, margin - 0.05);  // through a gap
  if (!path || path->total() > 9) return false;
  const double first = path->heading(std::min(0.3, path->total()));
  const double off = wrapped(first - life_->steps.heading());
  if (std::abs(off) > 0.9) {
    does(Action::turn);
    life_->steps.turn(life_->steps.heading() + (std::abs(off) - 0.25) * (off > 0 ? 1 : -1), here, random_);
  }
  does_at(now() + 0.28, Action::walk);
  const double speed = life_->gait.speed * uniform(random_, 0.92, 1.08) * std::min(1.0, 0.82 + 0.07 * path->total());
  does_at(life_->steps.walk(*path, speed, random_), Action::stand);
  return true;
}

void LifeWriter::turn_to(double heading, const Vector2d& place) {
  const double off = std::abs(wrapped(heading - life_->steps.heading()));
  if (off < 0.08 && (place - life_->steps.place()).norm() < 0.02) return;
  does(Action::turn);
  life_->steps.turn(heading, place, random_);
  does(Action::stand);
}

void LifeWriter::lean_back(const Seat& seat, const SeatStay& stay, TrunkMove& move) {
  const Vector3d front = seat.pose * Vector3d(0, 0, 1) - seat.pose.translation();
  const double gap = (seat.pose.inverse() * stay.root).z() - seat.back_z - figure_.back_depth;
  const double slide = std::clamp(gap - 0.03, 0.0, 0.06);
  move.shift = -front * slide;
  move.tilt = -std::clamp(std::asin(std::clamp((gap - slide) / 0.4, 0.0, 0.4)), 0.0, 0.3);
  move.bend = uniform(random_, -0.06, 0.0);
  move.leans_on_back = gap - slide < 0.14;
}

}  // namespace inhabit
