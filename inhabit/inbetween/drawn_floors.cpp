#include "inhabit/inbetween/drawn_floors.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/random.h"

namespace inhabit::inbetween {

using Eigen::Vector2d;
using torch::Tensor;

namespace {

constexpr double kShortest = 1.0, kLongest = 5.0;   // metres, of the line
constexpr double kEndsFree = 0.12;                  // metres around the ends without anything
constexpr double kWithWall = 0.3, kWithRoom = 0.5;  // fractions of the floors
constexpr double kWithSeat = 0.2;                   // fraction of the ends
constexpr int kMostBeside = 6;
constexpr double kMostLonger = 2.5;  // times the line, metres more: longer detours take more time than there is

/// A box as seen from above.
struct FloorBox {
  Vector2d middle, half;
  double yaw = 0;

  double distance(const Vector2d& p) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const Vector2d away = p - middle;
    const Vector2d q = Vector2d(c * away.x() + s * away.y(), -s * away.x() + c * away.y()).cwiseAbs() - half;
    return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
  }
};

struct Floor {
  std::vector<FloorBox> boxes, seats;  // seats: somebody sits there at an end, and nobody goes around them
  double length = 0;

  static double nearest(const std::vector<FloorBox>& boxes, const Vector2d& p) {
    double out = FreeSpace::kFarthest;
    for (const FloorBox& box : boxes) out = std::min(out, box.distance(p));
    return out;
  }
  double distance(const Vector2d& p) const { return nearest(boxes, p); }
  double seen(const Vector2d& p) const { return std::min(nearest(boxes, p), nearest(seats, p)); }
};

FloorBox draw_box(const Vector2d& middle, std::mt19937_64& random) {
  return {middle, {uniform(random, 0.15, 1.0), uniform(random, 0.12, 0.6)}, uniform(random, -M_PI / 2, M_PI / 2)};
}

/// Two pieces across the line and an opening between them, anywhere along it.
void add_opening(Floor& floor, std::mt19937_64& random) {
  const double opening = uniform(random, 0.8, 1.4), side = chance(random, 0.5) ? 1 : -1;
  const double aside = side * uniform(random, 0.2, 1.6), along = uniform(random, -0.3, 0.3) * floor.length;
  const double yaw = chance(random, 0.5) ? 0 : uniform(random, -0.5, 0.5);
  const double thick = chance(random, 0.5) ? uniform(random, 0.05, 0.12) : uniform(random, 0.15, 0.35);
  const Vector2d across(-std::sin(yaw), std::cos(yaw));
  for (const int which : {-1, 1}) {
    const double half = chance(random, 0.5) ? uniform(random, 1.2, 2.5) : uniform(random, 0.4, 0.9);
    floor.boxes.push_back({Vector2d(along, 0) + (aside + which * (opening / 2 + half)) * across, {thick, half}, yaw});
  }
}

void add_room(Floor& floor, std::mt19937_64& random) {
  const double yaw = uniform(random, -M_PI / 4, M_PI / 4);
  const double reach = floor.length / 2 + 4;
  for (int side = 0; side < 4; ++side) {
    if (!chance(random, 0.7)) continue;
    const double towards = yaw + side * M_PI / 2;
    const Vector2d out(std::cos(towards), std::sin(towards));
    // Behind both ends.
    const double far = std::abs(out.x()) * floor.length / 2 + uniform(random, 0.4, 2.5);
    floor.boxes.push_back({(far + 0.1) * out, {0.1, reach}, towards});
  }
}

Floor draw_floor(std::mt19937_64& random) {
  Floor floor;
  floor.length = uniform(random, kShortest, kLongest);
  const double half = floor.length / 2;
  if (chance(random, kWithWall))
    add_opening(floor, random);
  else
    floor.boxes.push_back(draw_box({uniform(random, -0.6, 0.6) * half, uniform(random, -0.5, 0.5)}, random));
  if (chance(random, kWithRoom)) add_room(floor, random);
  for (int more = uniform_int(random, 0, kMostBeside); more > 0; --more)
    floor.boxes.push_back(draw_box({uniform(random, -half - 1, half + 1), uniform(random, -2.5, 2.5)}, random));
  for (const double end : {-half, half})
    if (chance(random, kWithSeat))
      floor.seats.push_back({{end + uniform(random, -0.1, 0.1), uniform(random, -0.1, 0.1)},
                             {uniform(random, 0.2, 0.3), uniform(random, 0.2, 0.3)},
                             uniform(random, -M_PI / 2, M_PI / 2)});
  return floor;
}

/// The detour over a floor, if the line is blocked and there is one.
std::optional<WalkPath> detour_over(const Floor& floor) {
  const Vector2d from(-floor.length / 2, 0), to = -from;
  if (floor.distance(from) < kEndsFree || floor.distance(to) < kEndsFree) return std::nullopt;
  // Seen here, most floors need no grid.
  const auto line_free = [&] {
    for (double u = from.x(); u < to.x(); u += 0.05)
      if (floor.distance({u, 0}) < kWide) return false;
    return true;
  };
  if (line_free()) return std::nullopt;
  const FreeSpace grid = floor_grid([&](const Vector2d& p) { return floor.distance(p); });
  if (!line_blocked(grid, from, to)) return std::nullopt;
  return path_around_obstacles(grid, from, to, floor.length + kMostLonger);
}

}  // namespace

DrawnFloors draw_floors(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  DrawnFloors out;
  const auto rows = static_cast<int64_t>(count);
  out.distance = torch::empty({rows, kMapWide, kMapLong});
  out.length = torch::empty({rows});
  out.offsets = torch::empty({rows, kPathPoints, 2});
  auto distance = out.distance.accessor<float, 3>();
  auto length = out.length.accessor<float, 1>();
  auto offsets = out.offsets.accessor<float, 3>();
  for (int64_t row = 0; row < rows;) {
    const Floor floor = draw_floor(random);
    const auto path = detour_over(floor);
    if (!path) continue;
    const double side = chance(random, 0.5) ? 1 : -1;
    for (int64_t across = 0; across < kMapWide; ++across)
      for (int64_t along = 0; along < kMapLong; ++along) {
        const Vector2d p = path_map_point(across, along);
        distance[row][across][along] = static_cast<float>(floor.seen({p.x(), side * p.y()}));
      }
    length[row] = static_cast<float>(floor.length);
    for (int64_t i = 0; i < kPathPoints; ++i) {
      const double part = (static_cast<double>(i) + 0.5) / kPathPoints;
      const Vector2d place = path->at(part * path->total());
      offsets[row][i][0] = static_cast<float>(place.x() - (part - 0.5) * floor.length);
      offsets[row][i][1] = static_cast<float>(side * place.y());
    }
    ++row;
  }
  return out;
}

}  // namespace inhabit::inbetween
