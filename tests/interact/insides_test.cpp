// Protects who is told to be inside a chair: what exact queries of every point say, and what collisions say of a body.
#include "inhabit/interact/insides.h"

#include <gtest/gtest.h>

#include "inhabit/metrics/collision.h"
#include "inhabit/motion/placed_body.h"
#include "metrics/standing.h"

namespace inhabit::interact {
namespace {

/// A seat across the thighs and a ball in the chest.
Scene seat_and_ball() {
  MeshBuilder ball;
  ball.box({0.1, 1.25, 0.1}, {0.12, 0.12, 0.12}, 0.12, 6);
  Scene scene;
  scene.meshes = {block("chair_0", {0, 0.7, 0.3}, {0.4, 0.1, 0.3}), ball.mesh("ball_0", {1, 1, 1})};
  return scene;
}

TEST(Insides, AreThoseOfExactQueries) {
  const Scene scene = seat_and_ball();
  torch::manual_seed(1);
  const torch::Tensor points =
      (torch::rand({4000, 3}) * torch::tensor({1.2F, 1.F, 1.F}) + torch::tensor({-0.6F, 0.5F, -0.3F})).contiguous();
  const SceneQuery query(scene);
  const torch::Tensor distance = query.signed_distance(points), surface = query.closest(points).points;
  const Insides::Deep deep = Insides(scene).deep(points);
  ASSERT_EQ(deep.rows.size(), static_cast<size_t>((distance < 0).sum().item<int64_t>()));
  EXPECT_GT(deep.rows.size(), 300U);
  for (size_t i = 0; i < deep.rows.size(); ++i) {
    EXPECT_NEAR(deep.depths[i], -distance[deep.rows[i]].item<double>(), 1e-6);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(deep.places[i][axis], surface[deep.rows[i]][axis].item<double>(), 1e-6);
  }
  EXPECT_NEAR(Insides(scene).deepest(points), -distance.min().item<double>(), 1e-6);
  EXPECT_NEAR(Insides(scene).least_distance(points), distance.min().item<double>(), 1e-6);
}

TEST(Insides, AgreeWithTheCollisionsOfABody) {
  const Scene scene = seat_and_ball();
  const Clip clip = standing(1);
  const double deepest = Insides(scene).deepest(skin_points(clip, builtin_body()).reshape({-1, 3}).contiguous());
  EXPECT_GT(deepest, 0.02);
  const Collision collision = CollisionMeter(builtin_body(), scene).measure(clip, {kNoTolerance}).front();
  EXPECT_NEAR(deepest, collision.penetration(), 1e-6);
}

TEST(Insides, OfNothingAreNone) {
  const Insides nothing{Scene()};
  EXPECT_EQ(nothing.deepest(torch::zeros({3, 3})), 0);
  EXPECT_TRUE(nothing.deep(torch::zeros({3, 3})).rows.empty());
}

}  // namespace
}  // namespace inhabit::interact
