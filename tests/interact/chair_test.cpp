// Protects finding seats: where they are, which way one sits on them, and what is refused.
#include "inhabit/interact/chair.h"

#include <gmock/gmock.h>

#include "inhabit/math/heading.h"
#include "inhabit/scene/shapes.h"
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

/// Three cushions, arms and a back: from the cushion at an end the arm rest is nearer than the back rest is.
TEST(Chair, ASofaOfSeveralCushionsIsFacedAwayFromItsBackAlone) {
  for (const double gap : {0.0, 0.04, 0.1}) {
    MeshBuilder builder;
    for (int k = -1; k <= 1; ++k)
      builder.box({k * 0.64, 0.35, 0.05}, {0.32 - gap / 2, 0.1, k == 1 ? 0.35 : 0.34});  // the last is the largest
    builder.box({0, 0.4, -0.36}, {1.1, 0.4, 0.08});
    for (const double side : {-1.0, 1.0}) builder.box({side * 1.03, 0.3, 0}, {0.07, 0.3, 0.4});
    Scene scene;
    scene.meshes.push_back(builder.mesh("sofa_0", {1, 1, 1}));
    EXPECT_NEAR(find_chair(scene, "sofa_0").heading(), 0, 0.05) << gap;
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

TEST(Chair, ALowTableIsASeatOnlyWhereThereIsNoOther) {
  std::mt19937_64 random(12);
  Furniture chair = make_armchair(random, 0.45), table = make_table(random, 1.1, 0.7, 0.42);
  table.place(2, 0, 0);
  std::vector<Chair> found = find_chairs(scene_of({table, chair}));
  ASSERT_EQ(found.size(), 1);
  EXPECT_EQ(found[0].name, "armchair_0");
  found = find_chairs(scene_of({table}));
  ASSERT_EQ(found.size(), 1);
  EXPECT_EQ(found[0].name, "table_0");
}

TEST(Chair, ASofaIsSatOnWhereOneComesToItAStoolInItsMiddle) {
  std::mt19937_64 random(15);
  Furniture sofa = make_sofa(random, 3), stool = make_stool(random);
  sofa.place(0.4, -0.3, 0.8);
  const Chair middle = find_chair(scene_of({sofa}), "sofa_0");
  const double half = sofa.bounds().sizes().x() / 2;
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Vector3d far = middle.frame * Eigen::Vector3d(side * 4, 0, 2),
                          aside = middle.frame * Eigen::Vector3d(side * 0.2, 0, 3);
    Eigen::Vector3d own = middle.frame.inverse() * nearest_place(middle, on_ground(far)).seat();
    EXPECT_GT(side * own.x(), 0.3);
    EXPECT_LT(side * own.x(), half - 0.35) << "not on its end";
    EXPECT_NEAR(own.z(), 0, 1e-6);
    own = middle.frame.inverse() * nearest_place(middle, on_ground(aside)).seat();
    EXPECT_NEAR(own.x(), side * 0.2, 1e-6);
  }
  // Who sits anywhere along it is on it; before it, above it and beyond its end they are off it.
  const auto off = [](const Chair& chair, double x, double y, double z) {
    return chair.off(chair.frame * Eigen::Vector3d(x, chair.seat_height + y, z));
  };
  EXPECT_LT(off(middle, 0.2, 0, 0).norm(), 1e-9);
  EXPECT_LT((off(middle, -0.2, 0.1, 0.05) - Eigen::Vector3d(0, 0.1, 0.05)).norm(), 1e-9);
  EXPECT_GT(off(middle, half + 0.1, 0, 0).x(), 0.3);
  const Chair aside = nearest_place(middle, on_ground(middle.frame * Eigen::Vector3d(0.2, 0, 3)));
  EXPECT_LT(off(aside, -0.2, 0, 0).norm(), 1e-9) << "the middle is on it, too";
  EXPECT_NEAR(off(aside, half, 0, 0).x(), off(middle, half + 0.2, 0, 0).x(), 1e-9) << "its ends stay where they are";
  const Chair narrow = find_chair(scene_of({stool}), "stool_0");
  EXPECT_NEAR(off(narrow, 0.2, 0, 0).x(), 0.2, 1e-9);
  EXPECT_LT((nearest_place(narrow, {3, 3}).seat() - narrow.seat()).norm(), 1e-9);
}

TEST(Chair, CopiesOfAModellerAreChairsOfTheirOwn) {
  std::mt19937_64 random(17);
  Furniture chair = make_chair(random, 0.45);
  Scene scene = scene_of({chair});
  const size_t parts = scene.meshes.size();
  for (Mesh& mesh : scene.meshes)
    if (mesh.name != "floor") mesh.name = "seat.012" + mesh.name.substr(7);  // of "chair_0", "chair_0.1"
  EXPECT_EQ(find_chair(scene, "seat").name, "seat.012") << "the only one";
  for (size_t m = 0; m < parts; ++m) {
    Mesh copy = scene.meshes[m];
    if (copy.name == "floor") continue;
    copy.name = "seat.014" + copy.name.substr(8);
    copy.vertices = copy.vertices + torch::tensor({2.F, 0.F, 0.F});
    scene.meshes.push_back(copy);
  }
  EXPECT_NEAR((find_chair(scene, "seat.014").seat() - find_chair(scene, "seat.012").seat()).x(), 2, 1e-3);
  EXPECT_THAT(refusal_of([&] { find_chair(scene, "seat"); }), HasSubstr("seat.012, seat.014"));
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
