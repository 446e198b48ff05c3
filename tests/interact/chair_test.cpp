// Protects finding seats: where they are, which way one sits on them, and what is refused.
#include "inhabit/interact/chair.h"

#include <gmock/gmock.h>

#include "inhabit/math/heading.h"
#include "interact/chair_scene.h"
#include "refusal_of.h"

namespace inhabit::interact {
namespace {

using testing::HasSubstr;

TEST(Chair, SeatAndFacingOfEveryKindAreFoundWhereverItStands) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 24; ++i) {
    Furniture piece = i % 3 == 0 ? make_chair(random) : i % 3 == 1 ? make_armchair(random) : make_sofa(random, 2);
    const double yaw = 0.7 * i;
    piece.place(1.5, -0.8, yaw);
    const Chair chair = find_chair(scene_of({piece}), piece.kind + "_0");
    EXPECT_LT(std::abs(wrapped(chair.heading() - yaw)), 0.02) << piece.kind << " " << i;
    const Surface seat = seat_surface(piece);
    EXPECT_NEAR(chair.seat_height, seat.center.y(), 0.02) << piece.kind << " " << i;
    const Eigen::Vector3d own = piece.pose.inverse() * chair.seat();
    EXPECT_NEAR(own.x(), 0, 0.03) << piece.kind << " " << i;
    EXPECT_LT(std::abs(own.z() - seat.center.z()), seat.half_depth - 0.08) << piece.kind << " " << i;
    EXPECT_NEAR(chair.frame.translation().y(), 0, 1e-3);
  }
}

TEST(Chair, AStoolIsFacedWhereTheFloorIsFree) {
  std::mt19937_64 random(5);
  Furniture stool = make_stool(random), wall = make_table(random, 3, 0.6, 0.75);
  for (const double free : {0.0, M_PI / 2, M_PI, -M_PI / 2}) {
    std::vector<Furniture> pieces{stool};
    for (int k = 1; k < 4; ++k) {
      const Eigen::Vector2d at = 0.8 * ahead_of(free + k * M_PI / 2);
      wall.place(at.x(), at.y(), free + k * M_PI / 2);
      pieces.push_back(wall);
    }
    const Chair chair = find_chair(scene_of(pieces), "stool_0");
    EXPECT_LT(std::abs(wrapped(chair.heading() - free)), 0.1) << free;
  }
}

TEST(Chair, WhatIsNoChairIsRefusedWithTheReason) {
  std::mt19937_64 random(7);
  Furniture chair = make_chair(random, 0.45), table = make_table(random, 1.2, 0.8, 0.9);
  table.place(2, 0, 0);
  const Scene scene = scene_of({chair, table});
  EXPECT_THAT(refusal_of([&] { find_chair(scene, "throne_0"); }), HasSubstr("there are chair_0, table_0"));
  EXPECT_THAT(refusal_of([&] { find_chair(scene, "table_0"); }), HasSubstr("too high"));
  EXPECT_NEAR(find_chair(scene, "table_0", true).seat_height, 0.9, 0.02);
  EXPECT_THAT(refusal_of([&] { find_chair(scene_of({make_stool(random, 0.2)}), "stool_0"); }), HasSubstr("too low"));
  EXPECT_THAT(refusal_of([&] { chair_at(scene, {-2, 0.5, 0}, 0); }), HasSubstr("nothing to sit on"));
}

TEST(Chair, OneThatStandsOnItsHeadIsRefused) {
  std::mt19937_64 random(9);
  Furniture stool = make_stool(random, 0.45);
  Scene scene = scene_of({stool});
  for (Mesh& mesh : scene.meshes) {
    if (mesh.name == "floor") continue;
    mesh.vertices = mesh.vertices.clone();
    mesh.vertices.select(1, 1).mul_(-1).add_(0.45);
    mesh.faces = mesh.faces.flip(1);
  }
  EXPECT_FALSE(refusal_of([&] { find_chair(scene, "stool_0"); }).empty());
}

TEST(Chair, AllOfARoomAreFoundAndNothingElse) {
  std::mt19937_64 random(11);
  Furniture chair = make_armchair(random, 0.45), table = make_table(random, 1.2, 0.8, 0.74), shelf = make_shelf(random);
  table.place(2, 0, 0);
  shelf.place(-2, 0, 0);
  const std::vector<Chair> found = find_chairs(scene_of({chair, table, shelf}));
  ASSERT_EQ(found.size(), 1);
  EXPECT_EQ(found[0].name, "armchair_0");
}

TEST(Chair, APlaceOnASofaIsTakenAsGiven) {
  std::mt19937_64 random(13);
  Furniture sofa = make_sofa(random, 3);
  sofa.place(1, 2, 0.4);
  const Surface seat = seat_surface(sofa);
  const Eigen::Vector3d at = sofa.pose * seat.center;
  const Chair chair = chair_at(scene_of({sofa}), at, 0.5);
  EXPECT_NEAR((chair.seat() - at).norm(), 0, 0.02);
  EXPECT_NEAR(chair.heading(), 0.5, 1e-9);
}

}  // namespace
}  // namespace inhabit::interact
