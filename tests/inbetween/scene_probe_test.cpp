// Protects what the denoiser sees of a scene at every frame: distances agree with the scene's own, gradients with their
// differences, and the mirror image is one. And that the penetration loss's points cover hands and toes.
#include "inhabit/inbetween/scene_probe.h"

#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/inbetween/baseline.h"
#include "inhabit/math/random.h"
#include "inhabit/math/rotation.h"
#include "inhabit/scene/query.h"
#include "inhabit/scene/shapes.h"

namespace inhabit::inbetween {
namespace {

using Eigen::Vector3f;
using torch::Tensor;

Scene room_with_block() {
  Scene room = floor_scene();
  MeshBuilder block;
  block.box({0.5, 0.6, -0.3}, {0.6, 0.6, 0.4});
  room.meshes.push_back(block.mesh("block", {0.5F, 0.5F, 0.5F}));
  return room;
}

TEST(SceneDistances, AgreeWithTheSceneItself) {
  const Scene room = room_with_block();
  Scene block;
  block.meshes.push_back(room.meshes.back());
  const SceneQuery query(block);
  const SceneDistances distances(room);
  std::mt19937_64 random(1);
  double sum = 0;
  for (int i = 0; i < 400; ++i) {
    const Vector3f p(static_cast<float>(uniform(random, -0.6, 1.6)), static_cast<float>(uniform(random, 0, 1.7)),
                     static_cast<float>(uniform(random, -1.2, 0.6)));
    const auto truth = query.signed_distance(torch::tensor({{p.x(), p.y(), p.z()}})).item<float>();
    if (truth > 0.75) continue;  // beyond what is seen
    const float off = std::abs(distances.distance(p) - truth);
    EXPECT_LT(off, 0.05F) << p.transpose() << ": half a cell at edges";
    sum += off;
  }
  EXPECT_LT(sum / 400, 0.008) << "metres in the mean";
  EXPECT_EQ(distances.distance({6, 1, 6}), SceneDistances::kFar);
}

TEST(SceneDistances, GradientsAreThoseOfTheDistances) {
  const SceneDistances distances(room_with_block());
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    // Inside one cell of 0.1 m, where the interpolation is smooth.
    const auto inner = [&](double low, double high) {
      return static_cast<float>(0.1 * std::floor(10 * uniform(random, low, high)) + uniform(random, 0.03, 0.07));
    };
    const Vector3f p(inner(-0.4, 1.4), inner(0.1, 1.5), inner(-1, 0.4));
    Vector3f gradient;
    distances.distance(p, &gradient);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3f step = 0.005F * Vector3f::Unit(axis);
      const float change = (distances.distance(p + step) - distances.distance(p - step)) / 0.01F;
      EXPECT_NEAR(gradient[axis], change, 0.02F) << p.transpose();
    }
  }
}

TEST(SceneDistances, AMirrorShowsTheOtherSideAndHeightsAreFromTheFloor) {
  const SceneDistances distances(room_with_block()), mirrored = distances.mirrored();
  const SceneDistances lower(room_with_block(), 0.3);
  for (const Vector3f& p : {Vector3f(0.2F, 0.5F, 0.2F), {1.3F, 1.0F, -0.1F}, {0.5F, 0.4F, -0.3F}}) {
    EXPECT_EQ(mirrored.distance({-p.x(), p.y(), p.z()}), distances.distance(p));
    EXPECT_NEAR(lower.distance({p.x(), p.y() - 0.3F, p.z()}), distances.distance(p), 0.03);
  }
}

TEST(SceneDistances, AnEmptySceneIsFar) {
  EXPECT_EQ(SceneDistances().distance({0, 0, 0}), SceneDistances::kFar);
  EXPECT_EQ(SceneDistances(floor_scene()).distance({0, 0, 0}), SceneDistances::kFar) << "floors are no obstacles";
}

TEST(SceneDistances, SeePointsOfACloudAndNotItsGround) {
  Scene cloud;
  cloud.points = torch::tensor({{1.F, 0.8F, 0.F}, {0.F, 0.01F, 0.F}});
  const SceneDistances distances(cloud);
  EXPECT_NEAR(distances.distance({1, 0.5F, 0}), 0.3, 0.02);
  EXPECT_GT(distances.distance({0.3F, 0.1F, 0}), 0.7);
}

TEST(SceneDistances, LookNoFartherThanAsked) {
  const Scene room = room_with_block();
  const SceneDistances all(room), some(room, 0, Eigen::AlignedBox3f(Vector3f(-0.3F, 0, -1), Vector3f(0.4F, 2, 1)));
  EXPECT_NEAR(some.distance({0, 1, 0}), all.distance({0, 1, 0}), 0.03);
  EXPECT_EQ(some.distance({0.9F, 1, 0}), SceneDistances::kFar);
  EXPECT_LT(all.distance({0.9F, 1, 0}), 0);
}

TEST(PointFeatures, AreClosenessInTheHeadingFrame) {
  Tensor distance = torch::full({1, 1, kBodyPoints}, 5.F), gradient = torch::zeros({1, 1, kBodyPoints, 3});
  distance[0][0][0] = 0;
  gradient[0][0][0][0] = 1;  // along +X of the world, which is ahead of somebody who faces it
  const Tensor rotation = yaw_matrix(torch::full({1, 1}, static_cast<float>(M_PI / 2)));
  const Tensor features = point_features({distance, gradient}, rotation);
  ASSERT_EQ(features.size(2), kPointFeatures);
  const Tensor seen = features.view({-1});
  EXPECT_EQ(seen.gt(1e-6).sum().item<int64_t>(), 2) << "one closeness, one component of its gradient: the rest is far";
  EXPECT_NEAR(seen.max().item<float>(), 1, 1e-5);
}

TEST(BodyPoints, AreJointsAndTheMiddlesOfLimbs) {
  torch::manual_seed(1);
  const Tensor joints = torch::randn({2, 3, kStandardJoints, 3});
  const Tensor points = body_points(joints);
  ASSERT_EQ(points.sizes(), torch::IntArrayRef({2, 3, kBodyPoints, 3}));
  EXPECT_TRUE(torch::equal(points.slice(2, 0, kStandardJoints), joints));
  EXPECT_TRUE(
      torch::allclose(points.select(2, kStandardJoints), (joints.select(2, 1) + joints.select(2, 4)) / 2, 1e-5, 1e-6))
      << "the left thigh";
  EXPECT_TRUE((body_point_radii() > 0).all().item<bool>());
}

TEST(LimbEnds, KeepTheHandsOfTheBodyFree) {
  const BodyModel& body = builtin_body();
  const Tensor joints = body.skeleton.rest_joints(), most = body.skin_weights.argmax(1);
  for (const int64_t wrist : {20, 21}) {
    const Tensor hand = body.template_vertices.index_select(0, (most == wrist).nonzero().squeeze(1)) - joints[wrist];
    int64_t fingers = 0;
    for (int64_t i = 0; i < hand.size(0); ++i) {
      const Eigen::Vector3f at(hand[i][0].item<float>(), hand[i][1].item<float>(), hand[i][2].item<float>());
      if (std::abs(at.x()) < 0.05F) continue;  // by the wrist
      ++fingers;
      float free = -1;
      for (const LimbEnd& end : limb_ends())
        if (end.joint == wrist) free = std::max(free, end.radius - (at - end.offset).norm());
      EXPECT_GT(free, 0.01F) << at.transpose();
    }
    EXPECT_GT(fingers, 50);
  }
  for (const LimbEnd& end : limb_ends()) {
    if (end.joint != 10 && end.joint != 11) continue;
    const Tensor toes =
        body.template_vertices.index_select(0, (most == end.joint).nonzero().squeeze(1)) - joints[end.joint];
    EXPECT_NEAR(toes.select(1, 2).max().item<float>(), end.offset.z() + end.radius, 0.01F) << "the tips of toes";
  }
  EXPECT_EQ(guarded_radii().size(0), kBodyPoints + static_cast<int64_t>(kLimbEnds));
}

}  // namespace
}  // namespace inhabit::inbetween
