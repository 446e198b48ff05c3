// Protects how rooms are furnished: pieces inside and apart, openings and paths to seats free, refusals that change
// nothing. Rectangles are intersected by clipping polygons here, not by separating axes.
#include "inhabit/synth/layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "inhabit/math/random.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<Vector2d> corners_of(const Patch& p) {
  const Vector2d left(std::cos(p.yaw), -std::sin(p.yaw)), ahead(std::sin(p.yaw), std::cos(p.yaw));
  std::vector<Vector2d> out;
  for (const auto& [x, z] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
    out.emplace_back(p.center + x * p.half.x() * left + z * p.half.y() * ahead);
  return out;
}

double area_of(const std::vector<Vector2d>& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

/// What two rectangles share, square metres: one is clipped by the sides of the other (Sutherland and Hodgman).
double shared_area(const Patch& a, const Patch& b) {
  std::vector<Vector2d> polygon = corners_of(a);
  const std::vector<Vector2d> window = corners_of(b);
  for (size_t side = 0; side < 4 && !polygon.empty(); ++side) {
    const Vector2d from = window[side], along = window[(side + 1) % 4] - from;
    const Vector2d inwards = b.center - (from + along / 2);
    std::vector<Vector2d> kept;
    for (size_t i = 0; i < polygon.size(); ++i) {
      const Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double in_p = (p - from).dot(inwards), in_q = (q - from).dot(inwards);
      if (in_p >= 0) kept.push_back(p);
      if ((in_p >= 0) != (in_q >= 0)) kept.emplace_back(p + (q - p) * (in_p / (in_p - in_q)));
    }
    polygon = kept;
  }
  return area_of(polygon);
}

Furniture table_at(double x, double z, double width, double depth, double height = 0.7) {
  std::mt19937_64 random(1);
  Furniture table = make_table(random, width, depth, height);
  table.place(x, z, 0);
  return table;
}

Furniture chair_at(double x, double z, double yaw) {
  std::mt19937_64 random(2);
  Furniture chair = make_chair(random);
  chair.place(x, z, yaw);
  return chair;
}

int seats_of(const Room& room) {
  int seats = 0;
  for (const Furniture& piece : room.furniture)
    for (const Surface& s : piece.surfaces) seats += s.kind == Surface::Kind::seat ? 1 : 0;
  return seats;
}

/// The region of the floor (see walkable_regions) that a point lies in.
int32_t region_at(const FreeSpace& space, const std::vector<int32_t>& region, const Vector2d& p) {
  const Vector2d cell = (p - space.origin) / space.cell;
  return region.at(static_cast<size_t>(std::lround(cell.y())) * space.nx + std::lround(cell.x()));
}

/// A room of 4 m by 4 m with a door in the middle of the wall at -z and a window opposite.
struct SmallRoom {
  Room room;
  std::vector<Opening> openings{{0, 0, 0.45, 0, 2, true}, {2, 0, 0.6, 0.9, 2, false}};
  Layout layout{room, openings};
};

TEST(Layout, PatchesOverlapWhereTheirPolygonsDo) {
  std::mt19937_64 random(4);
  int overlapping = 0, apart = 0;
  for (int n = 0; n < 4000; ++n) {
    const auto draw = [&] {
      Patch p;
      p.center = {uniform(random, -1, 1), uniform(random, -1, 1)};
      p.half = {uniform(random, 0.1, 0.8), uniform(random, 0.1, 0.8)};
      p.yaw = uniform(random, -4, 4);
      return p;
    };
    const Patch a = draw(), b = draw();
    const double area = shared_area(a, b);
    if (area > 0 && area < 1e-6) continue;  // rounding decides
    EXPECT_EQ(overlap(a, b), area > 0) << n;
    EXPECT_EQ(overlap(b, a), area > 0) << n;
    (area > 0 ? overlapping : apart)++;
  }
  EXPECT_GT(overlapping, 500);
  EXPECT_GT(apart, 500);
}

TEST(Layout, FootprintsCoverThePiece) {
  std::mt19937_64 random(6);
  for (int n = 0; n < 50; ++n) {
    Furniture piece = make_armchair(random);
    piece.place(uniform(random, -2, 2), uniform(random, -2, 2), uniform(random, -3, 3));
    const Eigen::AlignedBox3d box = piece.bounds();
    for (const double margin : {0.0, 0.1}) {
      const Patch p = footprint(piece, margin);
      EXPECT_NEAR(4 * p.half.prod(), (box.sizes().x() + 2 * margin) * (box.sizes().z() + 2 * margin), 1e-12);
      const Vector3d front = piece.pose * Vector3d(box.center().x(), 0, box.max().z() + margin);
      const std::vector<Vector2d> corners = corners_of(p);
      EXPECT_LT((Vector2d(front.x(), front.z()) - (corners[2] + corners[3]) / 2).norm(), 1e-12);
    }
  }
}

TEST(Layout, APieceAtAWallHasItsBackToIt) {
  std::mt19937_64 random(5);
  Room room;
  room.size = {5, 3.6};
  std::array<int, 4> walls{};
  for (int n = 0; n < 200; ++n) {
    Furniture piece = make_shelf(random);
    const double gap = uniform(random, 0.0, 0.15);
    put_at_wall(piece, room, random, gap);
    const Vector3d back = piece.pose * Vector3d(0, 0, piece.bounds().min().z());
    const Vector3d inwards = piece.pose.linear().col(2);
    const double wall = std::abs(inwards.x()) > 0.5 ? room.size.x() / 2 : room.size.y() / 2;
    EXPECT_NEAR(back.dot(inwards) + wall, gap, 1e-12);
    for (const Vector2d& p : corners_of(footprint(piece)))
      EXPECT_TRUE((p.cwiseAbs().array() <= room.size.array() / 2 + 1e-12).all()) << p.transpose();
    ++walls[inwards.x() > 0.5 ? 3 : inwards.x() < -0.5 ? 1 : inwards.z() > 0.5 ? 0 : 2];
  }
  for (const int count : walls) EXPECT_GT(count, 20);
}

TEST(Layout, RefusesWhatIsOutsideOrInTheWayAndThenChangesNothing) {
  SmallRoom small;
  ASSERT_TRUE(small.layout.add({table_at(0, 0.3, 1, 0.6)}, {}));
  const auto refuses = [&](const std::vector<Furniture>& pieces, const std::vector<Patch>& need = {}) {
    const bool refused = !small.layout.add(pieces, need);
    EXPECT_EQ(small.room.furniture.size(), 1U);
    return refused;
  };
  EXPECT_TRUE(refuses({table_at(1.6, 0, 1, 0.6)})) << "through the wall";
  EXPECT_TRUE(refuses({table_at(0.9, 0.3, 1, 0.6)})) << "in another piece";
  EXPECT_TRUE(refuses({table_at(1.01, 0.3, 1, 0.6)})) << "1 cm from another piece";
  EXPECT_TRUE(refuses({table_at(1.4, 1.4, 0.4, 0.4), table_at(1.5, 1.5, 0.4, 0.4)})) << "two in one another";
  EXPECT_TRUE(refuses({table_at(1.4, 1.4, 0.4, 0.4), table_at(0, 0, 0.4, 0.4)})) << "all or none";
  EXPECT_TRUE(refuses({table_at(1.4, 1.4, 0.4, 0.4)}, {{{0, 0}, {0.2, 0.2}, 0}})) << "needs what is taken";
  EXPECT_TRUE(refuses({table_at(1.4, 1.4, 0.4, 0.4)}, {{{1.9, 0}, {0.2, 0.2}, 0}})) << "needs what is outside";
  EXPECT_TRUE(small.layout.add({table_at(1.03, 0.3, 1, 0.6)}, {})) << "3 cm from another piece";
}

TEST(Layout, WhatAPieceNeedsAndOpeningsStayFree) {
  SmallRoom small;
  const Patch need{{-1.4, 0}, {0.3, 0.3}, 0};
  ASSERT_TRUE(small.layout.add({table_at(-1.4, 0.6, 0.5, 0.5)}, {need}));
  EXPECT_FALSE(small.layout.add({table_at(-1.4, 0, 0.3, 0.3)}, {})) << "on what another piece needs";
  EXPECT_FALSE(small.layout.add({table_at(0, -1.3, 0.5, 0.5)}, {})) << "before the door";
  EXPECT_FALSE(small.layout.add({table_at(0, 1.7, 0.5, 0.5, 1.2)}, {})) << "high, before the window";
  EXPECT_TRUE(small.layout.add({table_at(0, 1.7, 0.5, 0.5, 0.7)}, {})) << "low, before the window";
  small.layout.remove_last();
  ASSERT_EQ(small.room.furniture.size(), 1U);
  EXPECT_TRUE(small.layout.add({table_at(-1.4, 0, 0.3, 0.3)}, {})) << "needs end when a piece is taken away";
  EXPECT_FALSE(small.layout.add({table_at(0, -1.3, 0.5, 0.5)}, {})) << "but those of doors do not";
}

TEST(Layout, ASeatStaysInReachOfTheDoor) {
  SmallRoom small;
  ASSERT_TRUE(small.layout.add({chair_at(0, 1.3, M_PI)}, {}));
  EXPECT_FALSE(small.layout.add({table_at(0, 0, 3.9, 0.4)}, {})) << "no path around";
  EXPECT_TRUE(small.layout.add({table_at(0, 0, 1.5, 0.4)}, {})) << "a path on both sides";
  SmallRoom other;
  ASSERT_TRUE(other.layout.add({table_at(0, 0, 3.9, 0.4)}, {}));
  EXPECT_FALSE(other.layout.add({chair_at(0, 1.3, M_PI)}, {})) << "behind what is there";
}

TEST(Layout, ARequiredTestDecidesInsteadOfReach) {
  SmallRoom small;
  int asked = 0;
  small.layout.require([&](const Furniture& piece) {
    ++asked;
    return piece.kind == "table";
  });
  EXPECT_TRUE(small.layout.add({table_at(0, 0, 3.9, 0.4)}, {})) << "reach is not asked for";
  EXPECT_FALSE(small.layout.add({chair_at(0, 1.3, M_PI)}, {}));
  EXPECT_EQ(asked, 2);
  EXPECT_FALSE(small.layout.add({table_at(0, 0, 1, 0.4)}, {})) << "pieces are kept apart as before";
}

TEST(Layout, FurnishedRoomsKeepPiecesApartAndWalkwaysFree) {
  size_t pieces = 0;
  for (uint64_t seed = 100; seed < 140; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    Room room;
    room.size = {uniform(random, 3.5, 8), uniform(random, 3.5, 8)};
    const std::vector<Opening> openings = add_walls(room, random);
    Layout layout(room, openings);
    furnish(layout, random);
    pieces += room.furniture.size();
    for (size_t i = 0; i < room.furniture.size(); ++i) {
      for (const Vector2d& p : corners_of(footprint(room.furniture[i])))
        EXPECT_TRUE((p.cwiseAbs().array() <= room.size.array() / 2 - 0.01 + 1e-9).all()) << room.object_name(i);
      for (size_t k = 0; k < i; ++k)
        EXPECT_LT(shared_area(footprint(room.furniture[i], 0.02), footprint(room.furniture[k])), 1e-9)
            << room.object_name(i) << " and " << room.object_name(k);
    }
    // One region of the floor holds all doors and the places before all seats.
    const FreeSpace space = free_space(room);
    const std::vector<int32_t> region = walkable_regions(space, 0.22);
    for (const Opening& o : openings) {
      if (!o.door) continue;
      const AtWall door = at_wall(room.size, o.side, o.along, 0.5);
      EXPECT_EQ(region_at(space, region, door.point), 1);
      const Patch before{door.point, o.side % 2 == 0 ? Vector2d(o.half, 0.49) : Vector2d(0.49, o.half), 0};
      for (size_t i = 0; i < room.furniture.size(); ++i)
        EXPECT_LT(shared_area(footprint(room.furniture[i]), before), 1e-9) << room.object_name(i) << " before a door";
    }
    for (const Furniture& piece : room.furniture)
      for (const Surface& s : piece.surfaces) {
        if (s.kind != Surface::Kind::seat) continue;
        EXPECT_EQ(region_at(space, region, place_before(piece, s)), 1) << piece.kind;
      }
  }
  EXPECT_GT(pieces, 40U * 3);
}

TEST(Layout, TheSameSeedFurnishesARoomTheSameWay) {
  const auto furnished = [](uint64_t seed) {
    SmallRoom small;
    std::mt19937_64 random(seed);
    furnish(small.layout, random);
    return small.room.furniture;
  };
  const auto same = [](const std::vector<Furniture>& a, const std::vector<Furniture>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Furniture& x, const Furniture& y) {
      return x.kind == y.kind && x.pose.matrix() == y.pose.matrix() && x.bounds().isApprox(y.bounds(), 0);
    });
  };
  EXPECT_TRUE(same(furnished(3), furnished(3)));
  EXPECT_FALSE(same(furnished(3), furnished(4)));
}

TEST(Layout, ASeatIsAddedEvenWhereOtherPiecesMustGo) {
  SmallRoom small;
  // One table fills the room but for the strip before the door, two more fill that on both sides of it.
  ASSERT_TRUE(small.layout.add({table_at(0, 0.5, 3.9, 2.9)}, {}));
  for (const double x : {-1.25, 1.25}) ASSERT_TRUE(small.layout.add({table_at(x, -1.48, 1.4, 0.9)}, {}));
  std::mt19937_64 random(9);
  add_any_seat(small.layout, random);
  EXPECT_EQ(seats_of(small.room), 1);
  EXPECT_LE(small.room.furniture.size(), 3U) << "no seat fits beside all three";
  EXPECT_GE(small.room.furniture.size(), 2U) << "one fits where the second and third stood";
}

}  // namespace
}  // namespace inhabit
