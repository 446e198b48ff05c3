// Protects what hands are said to touch: never the floor, whatever its mesh is called; of a scan not the ground; else
// what they rest on.
#include "inhabit/metrics/touch_labels.h"

#include <gtest/gtest.h>

#include "largest.h"
#include "metrics/standing.h"

namespace inhabit {
namespace {

/// Both wrists this high, metres.
Clip with_hands_at(double height) {
  Clip clip = standing(3);
  const auto up = static_cast<float>(height - clip.joints[0][20][1].item<double>());
  clip.trans.select(1, 1).add_(up);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

/// A slab under all of the body, its top at `height` metres.
Scene slab(const std::string& name, double height) {
  Scene scene;
  scene.meshes = {block(name, {0, height - 0.5, 0}, {3, 0.5, 3})};
  return scene;
}

Clip labelled(Clip clip, const Scene& scene) {
  TouchLabels(scene, builtin_body()).label(clip);
  return clip;
}

TEST(TouchLabels, HandsTouchNoFloorHoweverItIsCalled) {
  // Upstairs, so that nothing of it is the ground of a scan; beside it a table that the left hand lies on.
  const auto upstairs = [](const std::string& name) {
    Scene scene = slab(name, 1);
    scene.meshes.push_back(block("table_0", {1.3, 0.9, 0}, {1, 0.105, 1}));
    return labelled(with_hands_at(1.01), scene);
  };
  const Clip floor = upstairs("floor"), other = upstairs("platform");
  EXPECT_EQ(largest(floor.contact.select(1, 21)), 0);
  EXPECT_EQ(largest(floor.hand_targets.select(1, 1)), 0);
  EXPECT_EQ(floor.contact.select(1, 20).min().item<float>(), 1) << "the table";
  EXPECT_NEAR(floor.hand_targets[1][0][1].item<double>(), 1.005, 1e-4);
  EXPECT_EQ(other.contact.select(1, 21).min().item<float>(), 1) << "what is no floor is touched";
  for (const char* name : {"Floor", "ground", "carpet", "FLOOR.001"}) {
    const Clip same = upstairs(name);
    EXPECT_TRUE(same.contact.equal(floor.contact)) << name;
    EXPECT_TRUE(same.hand_targets.equal(floor.hand_targets)) << name;
  }
}

TEST(TouchLabels, HandsTouchNotTheGroundOfAScanButWhatStandsOnIt) {
  const Clip low = with_hands_at(0.02), ground = labelled(low, slab("scan", 0));
  EXPECT_EQ(largest(ground.contact.slice(1, 20, 22)), 0);
  EXPECT_EQ(largest(ground.hand_targets), 0);
  const Clip raised = with_hands_at(0.52), bench = labelled(raised, slab("scan", 0.5));
  EXPECT_EQ(bench.contact.slice(1, 20, 22).min().item<float>(), 1);
  EXPECT_NEAR(bench.hand_targets[0][0][1].item<double>(), 0.5, 1e-4);
}

TEST(TouchLabels, HandsInTheAirTouchNothingWhereFeetStand) {
  const Clip clip = labelled(standing(3), slab("floor", 0));
  EXPECT_EQ(largest(clip.contact.slice(1, 18, 22)), 0);
  EXPECT_EQ(clip.contact.slice(1, 10, 12).min().item<float>(), 1);
}

}  // namespace
}  // namespace inhabit
