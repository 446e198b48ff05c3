#pragma once
#include <random>

#include "inhabit/synth/life_plan.h"
#include "inhabit/synth/seat.h"

namespace inhabit {

/// How somebody walks and moves, drawn at random.
GaitStyle draw_gait(std::mt19937_64& random);
Manner draw_manner(std::mt19937_64& random);

/// Writes what people do anywhere into a plan, one thing after another from its present end. Planners of rooms and of
/// single chairs build on it.
class LifeWriter {
 public:
  LifeWriter(const FreeSpace& floor, const Figure& figure, std::mt19937_64& random)
      : floor_(floor), figure_(figure), random_(random) {}

 protected:
  double now() const { return life_->steps.now(); }
  void does(Action action) { life_->doing.push_back({now(), action}); }
  void does_at(double t, Action action) { life_->doing.push_back({t, action}); }

  /// Stands for `seconds`, shifting weight and looking about.
  void stand_about(double seconds);
  void look_about(double from, double until);
  /// Hands speak: one or both move in front of the chest.
  void gesture(double from, double until, bool seated);
  /// To `place`; false when there is no path or it is nearer than `least` metres. @param margin metres that the path
  /// keeps from everything, 5 cm less where it must go through a gap.
  bool go(const Eigen::Vector2d& place, double least, double margin = 0.32);
  void turn_to(double heading, const Eigen::Vector2d& place);
  /// Slides the pelvis to the back rest and leans on it.
  void lean_back(const Seat& seat, const SeatStay& stay, TrunkMove& move);

  const FreeSpace& floor_;
  const Figure& figure_;
  std::mt19937_64& random_;
  LifePlan* life_ = nullptr;
};

}  // namespace inhabit
