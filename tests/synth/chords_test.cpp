#include "inhabit/synth/chords.h"

#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/body/kinematics.h"
#include "inhabit/data/native.h"
#include "inhabit/error.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/scene/shapes.h"
#include "inhabit/synth/blocked.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

// Somebody with hanging arms who glides along a path on the floor: (x, z) metres at u in [0, 1], without turning.
Clip gliding(int64_t frames, const std::function<Eigen::Vector2d(double)>& path) {
  const BodyModel& body = builtin_body();
  Clip clip;
  clip.skeleton = body.skeleton;
  clip.skeleton.names.resize(kStandardJoints);
  clip.skeleton.parents.resize(kStandardJoints);
  clip.skeleton.offsets = body.skeleton.offsets.narrow(0, 0, kStandardJoints).clone();
  clip.rotations = torch::zeros({frames, kStandardJoints, 3});
  clip.rotations.select(1, 16).select(1, 2).fill_(-1.3);
  clip.rotations.select(1, 17).select(1, 2).fill_(1.3);
  clip.trans = torch::zeros({frames, 3});
  for (int64_t t = 0; t < frames; ++t) {
    const Eigen::Vector2d at = path(static_cast<double>(t) / static_cast<double>(frames - 1));
    clip.trans[t][0] = at.x();
    clip.trans[t][2] = at.y();
  }
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const double low = clip.joints.select(2, 1).min().item<double>() - 0.03;
  clip.trans.select(1, 1).sub_(low);
  clip.joints.select(2, 1).sub_(low);
  return clip;
}

Eigen::Vector2d half_circle(double u) { return {1.2 * std::cos(M_PI * u), 1.2 * std::sin(M_PI * u)}; }
Eigen::Vector2d straight_line(double u) { return {2.4 * u - 1.2, 0}; }

Room empty_room() {
  Room room;
  room.size = {7, 7};
  return room;
}

TEST(Chords, FurnitureStandsOnTheStraightPathAndNotOnTheTrueOne) {
  const Clip clip = gliding(61, half_circle), straight = gliding(61, straight_line);
  const BodySweep sweep(clip, builtin_body());
  int rooms = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Room room = empty_room();
    Layout layout(room, {});
    layout.require([](const Furniture&) { return true; });
    std::mt19937_64 random(seed);
    const int pieces = add_on_chords(layout, clip, builtin_body(), sweep, {1, 60, 60}, random);
    ASSERT_EQ(static_cast<size_t>(pieces), room.furniture.size());
    if (pieces == 0) continue;
    ++rooms;
    const CollisionMeter meter(builtin_body(), room.scene());
    EXPECT_EQ(meter.measure(clip).frame_ratio(), 0) << seed;
    EXPECT_GT(meter.measure(straight).frame_ratio(), 0) << seed;
  }
  EXPECT_GE(rooms, 9) << "a half circle leaves room for a piece";
}

TEST(Chords, AStraightPathLeavesNoPlace) {
  const Clip clip = gliding(121, straight_line);
  const BodySweep sweep(clip, builtin_body());
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    Room room = empty_room();
    Layout layout(room, {});
    layout.require([](const Furniture&) { return true; });
    std::mt19937_64 random(seed);
    EXPECT_EQ(add_on_chords(layout, clip, builtin_body(), sweep, {1, 30, 120}, random), 0);
  }
}

TEST(Chords, NoneAreTriedWithAFractionOf0) {
  const Clip clip = gliding(61, half_circle);
  Room room = empty_room();
  Layout layout(room, {});
  std::mt19937_64 random(1);
  EXPECT_EQ(add_on_chords(layout, clip, builtin_body(), BodySweep(clip, builtin_body()), {0, 60, 60}, random), 0);
}

TEST(Chords, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(check_chords({1.5, 30, 120}), Error);
  EXPECT_THROW(check_chords({0.5, 60, 30}), Error);
  EXPECT_THROW(check_chords({0.5, 1, 30}), Error);
}

// A half circle of 61 frames with a box in its middle: keys at both ends are joined straight through it.
TEST(BlockedWindows, AreThoseInWhichOnlyTheStraightPathCollides) {
  const TempFolder folder;
  Dataset data = create_dataset(folder / "d", {"walk"});
  Scene blocked, open, everywhere;
  MeshBuilder middle, aside;
  middle.box({0, 0.5, 0}, {0.2, 0.5, 0.2}, 0.01);
  aside.box({0, 0.5, 1.2}, {0.2, 0.5, 0.2}, 0.01);
  blocked.meshes.push_back(middle.mesh("box_0", {1, 1, 1}));
  open.meshes.push_back(middle.mesh("floor", {1, 1, 1}));  // feet stand on floors: it does not count
  everywhere.meshes.push_back(middle.mesh("box_0", {1, 1, 1}));
  everywhere.meshes.push_back(aside.mesh("box_1", {1, 1, 1}));
  int number = 0;
  for (const Scene* scene : {&blocked, &open, &everywhere}) {
    DatasetClip entry{"clips/" + std::to_string(number) + ".npz", "scenes/" + std::to_string(number) + ".glb", "train",
                      0, ""};
    ++number;
    write_scene(data, entry.scene, *scene);
    write_clip(data, entry, gliding(61, half_circle));
    data.clips.push_back(entry);
  }
  write_index(data);
  const BlockedWindows found = blocked_windows(data, "train", {61, 60, 60, 0});
  EXPECT_EQ(found.windows, 3);
  EXPECT_EQ(found.blocked, 1) << "not where the true path collides too";
  EXPECT_EQ(found.colliding, 1);
  EXPECT_GT(found.straight, found.real);
  EXPECT_EQ(blocked_windows(data, "train", {61, 60, 60, 2}).clips, 2);
  EXPECT_EQ(blocked_windows(data, "train", {61, 1, 60, 0}).blocked, 0) << "every frame a key: the path is the true one";
  EXPECT_EQ(blocked_windows(data, "test").windows, 0);
  EXPECT_THROW(blocked_windows(data, "train", {61, 0, 60, 0}), Error);
}

}  // namespace
}  // namespace inhabit
