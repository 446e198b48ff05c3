#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit::inbetween {

/// What stands in the way: a table, a sofa, a shelf, two cabinets with a gap between them, a wall with an opening.
inline constexpr std::array<const char*, 5> kBlockedKinds = {"table", "sofa", "shelf", "gap", "wall"};

/// Somebody stands or walks on one side of furniture and, when the clip ends, on the other: the straight line is
/// blocked.
struct BlockedRoom {
  std::string name;   ///< "table 3", "table 3 mirrored"
  int64_t kind = 0;   ///< of kBlockedKinds
  Clip ends;          ///< (T) the key poses at both ends; between them the first one goes straight on
  Scene scene;        ///< floor and what blocks the line
  double detour = 0;  ///< metres, how long the detour around it is
};

/// The fastest that anybody has to walk around, m/s in the mean.
inline constexpr double kBriskWalk = 1.5;

/// `pairs` pairs of rooms, one kind after the other, each room followed by its mirror image: the keys are the same and
/// what blocks stands on the other side of the straight line. Poses (standing, or at either step of a walk), headings,
/// distances (2.4 to 3.4 m) and sizes are drawn from the seed. In every room a body that slides straight from key to
/// key is inside by more than 3 cm, neither key pose is nearer to anything than 5 cm, and there is a detour with 0.3 m
/// of clearance that is walked in the clip's time at kBriskWalk.
std::vector<BlockedRoom> blocked_rooms(int64_t pairs, int64_t frames, double rate, uint64_t seed);

}  // namespace inhabit::inbetween
