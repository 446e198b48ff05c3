// Protects the whole way on rendered rooms whose errors are known: the depth's scale within 2 %, the root's error
// halved, skating and jerk below the estimate's, the same input the same result; and what the key frames' roots are
// found by.
#include "inhabit/reconstruct/evaluate.h"

#include <gtest/gtest.h>

#include "inhabit/reconstruct/key_root.h"
#include "inhabit/reconstruct/world_motion.h"
#include "scene/shapes.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

const inbetween::SceneInbetweener& noise_aware_model() {
  static const auto model = inbetween::SceneInbetweener::load(INHABIT_SOURCE_DIR "/models/inbetween-noisy.safetensors");
  return model;
}

Evaluation small_room() {
  Evaluation out;
  out.rooms = 1;
  out.seconds = 2;
  out.seed = 3;
  out.render.width = 200, out.render.height = 150;
  return out;
}

TEST(Reconstruct, ARoomComesBackNearerToTheTruth) {
  Evaluation evaluation = small_room();
  evaluation.seconds = 4;
  evaluation.objects = false;
  const Errors e = evaluate(noise_aware_model(), evaluation).at(0);
  EXPECT_LT(std::abs(e.scale), 0.02);
  EXPECT_LT(e.depth, 0.05);
  EXPECT_LT(e.root_after, 0.6 * e.root_before);
  EXPECT_LT(e.joints_after, e.joints_before);
  EXPECT_LT(e.skating_after, e.skating_before);
  EXPECT_LT(e.jerk_after, 0.1 * e.jerk_before);
}

TEST(Reconstruct, TheSameInputGivesTheSameResult) {
  const Rendered rendered = rendered_room(small_room(), 0);
  const Result a = run(rendered.inputs, noise_aware_model()), b = run(rendered.inputs, noise_aware_model());
  EXPECT_TRUE(a.motion.joints.equal(b.motion.joints));
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) EXPECT_EQ(a.objects[i].placement.shift, b.objects[i].placement.shift);
  // Key frames every 5, of which every third is a key of in-betweening.
  EXPECT_EQ(a.moved_keys.at(1), 5);
  EXPECT_EQ(a.keys.at(1), 15);
  EXPECT_EQ(a.scene.meshes.back().name, "floor");
}

TEST(Reconstruct, WithoutErrorsThereIsNothingToMove) {
  Evaluation evaluation = small_room();
  evaluation.objects = false;
  KnownErrors& errors = evaluation.render.errors;
  errors.noise = errors.warp = errors.root_along = errors.root_across = errors.drift = errors.pose = 0;
  errors.maps = 1;
  const Errors e = evaluate(noise_aware_model(), evaluation).at(0);
  EXPECT_LT(e.root_before, 1e-6);
  EXPECT_LT(std::abs(e.scale), 0.01);
  EXPECT_LT(e.root_keys, 0.02);
}

/// Somebody who stands still as the truth says, `wrong` metres away in each key.
TEST(KeyRoots, ContactBringsFeetOntoTheFloorAndRegularisationKeepsTheRest) {
  const Rendered rendered = rendered_room(small_room(), 0);
  Clip still = slice(rendered.truth, 0, 11);
  for (int64_t t = 1; t < 11; ++t) still.rotations[t].copy_(still.rotations[0]), still.trans[t].copy_(still.trans[0]);
  Clip lifted = still;
  lifted.trans = still.trans.clone();
  lifted.trans.select(1, 1) += 0.03;
  const BodyInFrames body(lifted, builtin_body()), true_body(still, builtin_body());
  const double feet = feet_height(true_body, 1);
  Scene floor;
  floor.meshes.push_back(box_mesh({0, feet - 0.5, 0}, {40, 1, 40}));
  const std::vector<refine::DepthCloud> unseen(3);
  const KeyRoots roots = optimise_key_roots(body, lifted.betas, lifted.rate, {0, 5, 10}, unseen, floor);
  ASSERT_EQ(roots.moved.size(), 3U);
  EXPECT_GT(roots.contacts, 0);
  for (const Vector3d& moved : roots.moved) {
    EXPECT_NEAR(moved.y(), -0.03, 0.02);
    EXPECT_LT(std::hypot(moved.x(), moved.z()), 0.005);
  }
}

TEST(WorldMotion, ComesOutOfTheCamerasAxes) {
  const Rendered rendered = rendered_room(small_room(), 0);
  const Clip& truth = rendered.truth;
  Camera camera = rendered.inputs.camera;
  Camera back = camera;
  back.to_world = {camera.to_world[0].inverse()};
  back.motion_in_camera = true;
  const Clip in_camera = in_world(truth, back, "clip");
  camera.motion_in_camera = true;
  EXPECT_LT((in_world(in_camera, camera, "clip").joints - truth.joints).abs().max().item<double>(), 1e-4);
  EXPECT_GT((in_camera.joints - truth.joints).abs().max().item<double>(), 0.1);
}

TEST(WorldMotion, RootsMoveLinearlyBetweenKeys) {
  const Clip truth = slice(rendered_room(small_room(), 0).truth, 0, 9);
  const Clip moved = with_roots_moved(truth, {0, 4, 8}, {{0, 0, 0}, {0.4, 0, 0}, {0.4, 0.8, 0}});
  const Tensor by = moved.root_path() - truth.root_path();
  EXPECT_NEAR(by[2][0].item<double>(), 0.2, 1e-5);
  EXPECT_NEAR(by[6][0].item<double>(), 0.4, 1e-5);
  EXPECT_NEAR(by[7][1].item<double>(), 0.6, 1e-5);
}

}  // namespace
}  // namespace inhabit::reconstruct
