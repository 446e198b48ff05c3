// Protects what a scene's surfaces hold: which faces agree, which parts are bodies, what a cavity belongs to.
#include "inhabit/scene/solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "scene/shapes.h"

namespace inhabit {
namespace {

/// Faces, of all, that count as looking outwards as they are.
int64_t kept(const Solid& solid) { return std::count(solid.outward.begin(), solid.outward.end(), 1); }

TEST(Solid, ABoxIsOneBodyWhicheverWayItsFacesLook) {
  const Mesh box = box_mesh({0, 1, 0}, {1, 1, 1});
  const Solid right = make_solid(scene_of({box}));
  EXPECT_EQ(right.bodies, 1);
  EXPECT_EQ(kept(right), 12);
  const Solid inwards = make_solid(scene_of({flipped(box)}));
  EXPECT_EQ(inwards.bodies, 1);
  EXPECT_EQ(kept(inwards), 0) << "too small for a room that is seen from within: turned";
  const Solid some = make_solid(scene_of({flipped(box, {2, 7})}));
  EXPECT_EQ(kept(some), 10);
  EXPECT_EQ(some.outward[2], -1);
  EXPECT_EQ(some.outward[7], -1);
}

TEST(Solid, ARoomStaysHollow) {
  const Solid room = make_solid(scene_of({flipped(box_mesh({0, 1.25, 0}, {4, 2.5, 5}))}));
  EXPECT_EQ(room.bodies, 1);
  EXPECT_EQ(kept(room), 12) << "its faces look at the people in it";
}

TEST(Solid, ACavityIsPartOfWhatItLiesIn) {
  const Solid hollow = make_solid(scene_of({sphere_mesh({0, 0, 0}, 1, 12), flipped(sphere_mesh({0, 0, 0}, 0.5, 12))}));
  EXPECT_EQ(hollow.bodies, 1);
  EXPECT_EQ(kept(hollow), static_cast<int64_t>(hollow.faces.size()));
  // The same inner sphere looking outwards is a body of its own, as is a cavity's double beside the outer one.
  EXPECT_EQ(make_solid(scene_of({sphere_mesh({0, 0, 0}, 1, 12), sphere_mesh({0, 0, 0}, 0.5, 12)})).bodies, 2);
  EXPECT_EQ(make_solid(scene_of({sphere_mesh({0, 0, 0}, 1, 12), flipped(sphere_mesh({3, 0, 0}, 0.5, 12))})).bodies, 2);
}

TEST(Solid, OpenPartsOfOneMeshAreOneBody) {
  std::vector<Mesh> sides;
  for (int side = 0; side < 6; ++side) {
    std::vector<int> others{0, 1, 2, 3, 4, 5};
    others.erase(others.begin() + side);
    sides.push_back(box_mesh({1e-4 * side, 0, 0}, {1, 1, 1}, others));
  }
  EXPECT_EQ(make_solid(scene_of({merged_mesh(scene_of(sides))})).bodies, 1);
  EXPECT_EQ(make_solid(scene_of(sides)).bodies, 6) << "of six meshes they are six";
  EXPECT_EQ(make_solid(scene_of({box_mesh({0, 0, 0}, {1, 1, 1}, {3}), box_mesh({3, 0, 0}, {1, 1, 1})})).bodies, 2);
}

TEST(Solid, CountsFacesOfEveryMeshAndKeepsPoints) {
  Scene scene = scene_of({box_mesh({0, 0, 0}, {1, 1, 1}), box_mesh({2, 0, 0}, {1, 1, 1}, {3})});
  scene.points = torch::rand({5, 3});
  const Solid solid = make_solid(scene);
  EXPECT_EQ(solid.first_face, (std::vector<int64_t>{0, 12, 22}));
  EXPECT_EQ(solid.points.size(), 5U);
  EXPECT_EQ(solid.body[0], solid.body[11]);
  EXPECT_NE(solid.body[0], solid.body[12]);
  EXPECT_EQ(make_solid(Scene()).bodies, 0);
}

TEST(Solid, HoldsWhatMoreThanHalfOfAllLooksCount) {
  EXPECT_TRUE(Solid::holds(6, 6));
  EXPECT_TRUE(Solid::holds(4, 6));
  EXPECT_FALSE(Solid::holds(3, 6));
  EXPECT_FALSE(Solid::holds(-6, 6));
}

}  // namespace
}  // namespace inhabit
