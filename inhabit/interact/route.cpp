#include "inhabit/interact/route.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace inhabit::interact {
namespace {

using Eigen::Vector2d;

constexpr double kAtEnds = 0.45;        // metres around the ends of a route that are tighter than it is
constexpr double kStandingRoom = 0.24;  // metres to what stands around, at least, of who stands before a seat

/// Whether nobody can stand there. What is not known is free.
bool is_taken(const FreeSpace& floor, const Vector2d& p) {
  return floor.at(p) < kSqueeze && floor.at(p) > -FreeSpace::kFarthest;
}

/// Where somebody who is in something, or right beside it, gets out: the nearest free place.
std::optional<Vector2d> free_place_near(const FreeSpace& floor, const Vector2d& from) {
  constexpr double kFarthest = 1.2;
  if (floor.at(from) == -FreeSpace::kFarthest) return from;  // off the grid
  for (double far = 0; far < kFarthest; far += floor.cell) {
    std::optional<Vector2d> best;
    for (int k = 0; k < 24; ++k) {
      const Vector2d p = from + far * ahead_of(2 * M_PI * k / 24);
      if (floor.at(p) >= kSqueeze && (!best || floor.at(p) > floor.at(*best))) best = p;
    }
    if (best) return best;
  }
  return std::nullopt;
}

}  // namespace

bool straight(const FreeSpace& floor, const Vector2d& from, const Vector2d& to, double clear) {
  const double length = (to - from).norm();
  for (double s = 0; s < length; s += floor.cell) {
    const double needed = length - s < kAtEnds ? std::min(clear, kStandingRoom) : clear;
    const Vector2d p = from + (to - from) * (s / length);
    const double there = floor.at(p);
    if (there > -FreeSpace::kFarthest && there < needed) return false;  // what is not known is free
  }
  return true;
}

std::optional<WalkPath> find_route(const FreeSpace& floor, const Vector2d& from, const Vector2d& to) {
  const std::optional<Vector2d> start = free_place_near(floor, from);
  if (!start || is_taken(floor, to)) return std::nullopt;
  // Elbow room is worth a detour, but not one around the house.
  return find_roomy_path(floor, *start, to, {kElbowRoom, 0.36, 0.3, kSqueeze}, {.times = 1.25, .more = 0.4});
}

std::optional<WalkPath> find_route(const FreeSpace& floor, const Vector2d& from, const Chair& chair) {
  const Vector2d seat = on_ground(chair.seat());
  for (const double aside : {0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2})
    for (double far = 0.5; far < 1.0; far += 0.05) {
      const Vector2d place = seat + far * ahead_of(chair.heading() + aside);
      if (floor.at(place) < kStandingRoom) continue;
      if (auto path = find_route(floor, from, place)) return path;
    }
  return std::nullopt;
}

std::optional<WalkPath> find_route(const FreeSpace& floor, const Chair& chair, const Vector2d& to) {
  std::optional<WalkPath> path = is_taken(floor, to) ? std::nullopt : find_route(floor, to, chair);
  if (!path) return path;
  std::reverse(path->points.begin(), path->points.end());
  const double total = path->total();
  std::reverse(path->length.begin(), path->length.end());
  for (double& s : path->length) s = total - s;
  return path;
}

}  // namespace inhabit::interact
