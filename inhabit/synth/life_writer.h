#pragma once
#include <random>

#include "inhabit/synth/life_plan.h"
#include "inhabit/synth/seat.h"

namespace inhabit {

/// How somebody walks and moves, drawn at random.
GaitStyle draw_gait(std::mt19937_64& random);
/// How somebody moves apart from walking, drawn at random, each number uniformly.
Manner draw_manner(std::mt19937_64& random);

/// Writes what people do anywhere into a plan, one thing after another from its present end. Planners of rooms and of
/// single chairs build on it.
class LifeWriter {
 public:
  /// All must outlive this.
  LifeWriter(const FreeSpace& floor, const Figure& figure, std::mt19937_64& random)
      : floor_(floor), figure_(figure), random_(random) {}

 protected:
  /// Seconds that are written.
  double now() const { return life_->steps.now(); }
  /// From now on the action is this.
  void does(Action action) { life_->doing.push_back({now(), action}); }
  /// From `t` seconds on it is this.
  void does_at(double t, Action action) { life_->doing.push_back({t, action}); }

  /// Stands for `seconds`, shifting weight and looking about.
  void stand_about(double seconds);
  /// The eyes go to places around between two seconds.
  void look_about(double from, double until);
  /// Hands speak: one or both move in front of the chest.
  void gesture(double from, double until, bool seated);
  /// To `place`; false when there is no path or it is nearer than `least` metres. @param margin metres that the path
  /// keeps from everything, 5 cm less where it must go through a gap.
  bool go(const Eigen::Vector2d& place, double least, double margin = 0.32);
  /// Turns on the spot to `heading`, and stands at `place` (x, z), which is near.
  void turn_to(double heading, const Eigen::Vector2d& place);
  /// Slides the pelvis to the back rest and leans on it.
  void lean_back(const Seat& seat, const SeatStay& stay, TrunkMove& move);

  const FreeSpace& floor_;    ///< where one can walk
  const Figure& figure_;      ///< who does
  std::mt19937_64& random_;   ///< what everything is drawn from
  LifePlan* life_ = nullptr;  ///< what is written to
};

}  // namespace inhabit
