// Protects the points of a body that a scene is asked about: skin, anchors and capsules stand where the clip's joints
// are.
#include "inhabit/motion/placed_body.h"

#include <gtest/gtest.h>

#include "inhabit/body/kinematics.h"
#include "largest.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

Clip bending() {
  torch::manual_seed(3);
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.rotations = torch::randn({3, 22, 3}) * 0.2;
  clip.trans = torch::randn({3, 3});
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

TEST(PlacedBody, AnchorsAreVerticesOfTheSkinAndMoveWithTheRoot) {
  Clip clip = bending();
  const BodyModel& body = builtin_body();
  const torch::Tensor skin = skin_points(clip, body), anchors = anchor_points(clip, body);
  EXPECT_EQ(anchors.sizes(), (torch::IntArrayRef{3, 64, 3}));
  EXPECT_LT(largest(anchors - skin.index_select(1, body.anchors)), 1e-6);
  const torch::Tensor shift = torch::tensor({1.F, 2.F, 3.F});
  clip.joints = clip.joints + shift;
  EXPECT_LT(largest(skin_points(clip, body) - skin - shift), 1e-5) << "joints say where the root is";
}

TEST(PlacedBody, CapsulePointsLieOnTheAxesThatRotateWithTheirJoints) {
  const Clip clip = bending();
  const BodyModel& body = builtin_body();
  const CapsulePoints found = capsule_points(clip, body, 0.03);
  ASSERT_EQ(found.radii.size(), body.capsules.size());
  for (size_t i = 0; i < found.radii.size(); ++i) {
    const Capsule& c = body.capsules[i];
    EXPECT_EQ(found.joints[i], c.joint);
    const torch::Tensor a = torch::tensor({c.a[0], c.a[1], c.a[2]});
    const torch::Tensor points = found.points.slice(1, found.first[i], found.first[i + 1]);
    const torch::Tensor joint = clip.joints.select(1, c.joint);
    EXPECT_LT(largest((points.select(1, 0) - joint).norm(2, {1}) - a.norm()), 1e-5) << "the first is the end a";
    if (points.size(1) > 1) {
      EXPECT_LT(largest(points.diff(1, 1).norm(2, {2})), 0.0301);
    }
  }
}

TEST(PlacedBody, NeedsRotations) {
  Clip clip = bending();
  clip.rotations = torch::Tensor();
  EXPECT_NE(refusal_of([&] { skin_points(clip, builtin_body()); }), "");
  EXPECT_NE(refusal_of([&] { capsule_points(clip, builtin_body(), 0.1); }), "");
}

}  // namespace
}  // namespace inhabit
