// Protects what a collision is said to be with: the object that the body is deepest in, and how deep.
#include "inhabit/metrics/immersion.h"

#include <gtest/gtest.h>

#include "inhabit/metrics/collision.h"
#include "inhabit/scene/shapes.h"
#include "metrics/standing.h"

namespace inhabit {
namespace {

TEST(Immersion, NamesTheObjectThatTheBodyIsDeepestIn) {
  const Clip clip = standing(6);
  Scene scene;
  // Two parts of one cupboard hold the head, a shelf the feet; both are beyond the tolerance.
  scene.meshes = {block("cupboard_0", {0, 1.6, 0}, {1, 0.4, 1}), block("cupboard_0.1", {0, 1.9, 0}, {1, 0.2, 1}),
                  block("shelf_0", {0, 0.05, 0}, {1, 0.1, 1}), block("floor", {0, 0, 0}, {6, 3, 6}),
                  block("lamp_0", {3, 1, 3}, {1, 2, 1})};
  const std::vector<Immersion> found = immersions_of(CollisionMeter(builtin_body(), scene), clip, {0, 4});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[1].frame, 4);
  EXPECT_EQ(found[0].object, "cupboard_0");
  Scene cupboard;
  cupboard.meshes = {scene.meshes[0], scene.meshes[1]};
  EXPECT_NEAR(found[0].depth, CollisionMeter(builtin_body(), cupboard).measure(clip).depth[0].item<double>(), 1e-5);
  EXPECT_EQ(found[0].text().substr(found[0].text().size() - 13), "in cupboard_0");
  scene.meshes = {scene.meshes[4]};
  EXPECT_EQ(immersions_of(CollisionMeter(builtin_body(), scene), clip, {0})[0].text(), "");
}

TEST(Immersion, IsThatOfEachStretch) {
  const Clip clip = standing(12);
  Scene scene;
  scene.meshes = {block("cupboard_0", {0, 1.6, 0}, {1, 0.4, 1})};
  torch::Tensor collides = torch::zeros({12}, torch::kBool);
  collides.slice(0, 1, 4).fill_(true);
  collides.slice(0, 6, 12).fill_(true);
  const CollisionMeter meter(builtin_body(), scene);
  const std::vector<Immersion> found = immersions_of_stretches(meter, clip, collides);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].object, "cupboard_0");
  EXPECT_GE(found[1].frame, 6);
  EXPECT_TRUE(immersions_of_stretches(meter, clip, torch::zeros({12}, torch::kBool)).empty());
}

}  // namespace
}  // namespace inhabit
