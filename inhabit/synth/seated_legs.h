#pragma once
#include <random>

#include "inhabit/body/capsules.h"
#include "inhabit/synth/life_plan.h"

namespace inhabit {

/// Legs of somebody whose root rests at `stay.root` facing `heading`, in world metres. All moves begin at `from` or a
/// little later and have come back at `until`, which is 2.5 s later at least.
struct SeatedLegs {
  const Figure& figure;  ///< who sits
  const SeatStay& stay;  ///< where
  double heading = 0;    ///< radians
  double from = 0;       ///< seconds
  double until = 0;      ///< seconds

  /// One leg (which = 0 left, 1 right) or both (2) stretched ahead on the heel, toes up.
  std::vector<LegMove> stretched(int which, std::mt19937_64& random) const;
  /// Both stretched, the ankle of side `over` on the other one.
  std::vector<LegMove> ankles_crossed(int over, std::mt19937_64& random) const;
  /// The thigh of side `over` on the other one, its shank hanging before the other knee.
  std::vector<LegMove> legs_crossed(int over, std::mt19937_64& random) const;

 private:
  Eigen::Vector3d hip(int side) const;
  /// To the person's left, upwards, ahead.
  Eigen::Vector3d turned(double left, double up, double ahead) const;
  /// Where the knee is of a leg that bends upwards only.
  Eigen::Vector3d knee_of(int side, const Eigen::Vector3d& ankle) const;
  /// The ankle of a leg that is `reach` of its length long, heel on the floor and sole pitched by `pitch`, `aside`
  /// metres to the left of the root.
  Eigen::Vector3d heel_place(int side, double reach, double pitch, double aside) const;
};

/// A foot on its way along `move` with weight w, 0 to 1: where it is without to where it goes.
void move_leg(const Figure& figure, const LegMove& move, double w, FootControl& foot);

/// Metres that the capsules of one leg's shank, foot and toes are in those of the other leg, at most.
double legs_in_each_other(const std::vector<Capsule>& capsules, const Posed& pose);

}  // namespace inhabit
