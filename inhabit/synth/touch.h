#pragma once
#include <optional>
#include <random>
#include <vector>

#include "inhabit/synth/life_plan.h"

namespace inhabit {

/// A side of a level surface that can be reached from the floor before it.
struct TouchPlace {
  int furniture = -1;                                ///< index into Room::furniture
  Eigen::Vector3d edge = Eigen::Vector3d::Zero();    ///< middle of the side, world, on the surface
  Eigen::Vector3d inward = Eigen::Vector3d::Zero();  ///< unit, from the side over the surface
  double half_length = 0;                            ///< of the side
  double depth = 0;                                  ///< of the surface
};

/// Places to touch in a room: all four sides of tables over 0.55 m, the fronts of shelves between 0.65 and 1.55 m.
std::vector<TouchPlace> touch_places(const Room& room);

/// Where to stand, facing which way, what the hands and the trunk do. Times are left to the caller.
struct TouchPlan {
  Eigen::Vector2d stand = Eigen::Vector2d::Zero();        ///< world (x, z), metres
  double heading = 0;                                     ///< radians
  std::vector<HandTrip> hands;                            ///< one or both
  Eigen::Vector3d before_edge = Eigen::Vector3d::Zero();  ///< from where a wrist rests to where it comes from
  TrunkMove trunk;                                        ///< so that they reach
};

/// Nothing when there is no room to stand or the place is out of reach.
std::optional<TouchPlan> plan_touch(const TouchPlace& place, const FreeSpace& floor, const Figure& figure,
                                    std::mt19937_64& random);

}  // namespace inhabit
