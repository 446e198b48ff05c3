// Protects the detours of the shipped PathNet: around what blocks the line and there alone, from key to key, the same
// for the same seed, and said where none is walkable.
#include "inhabit/inbetween/learned_detours.h"

#include <gtest/gtest.h>

#include "inbetween/table_detour.h"
#include "inbetween/whole_keys.h"
#include "inhabit/inbetween/blocked_rooms.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/obstacle_detours.h"
#include "inhabit/math/random.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"

namespace inhabit::inbetween {
namespace {

const PathNet& shipped() {
  static const PathNet network = load_networks(INHABIT_SOURCE_DIR "/models/inbetween-compact.safetensors").path;
  return network;
}

struct Walk {
  Detour detour = table_detour(121, 30);
  Poses keys = poses_of(detour.ends);
  SceneDistances scene = SceneDistances(detour.room);
  Tensor detours_of(const std::vector<int64_t>& frames, uint64_t seed = 1, std::vector<int64_t>* unreached = nullptr,
                    double temperature = 1) const {
    const torch::NoGradGuard no_gradients;
    return learned_detours(shipped(), keys, whole_keys(121, frames), scene, temperature, seed, unreached);
  }
};

TEST(LearnedDetours, BendWhereTheTableStands) {
  const Walk w;
  const Tensor detours = w.detours_of({0, 120});
  EXPECT_TRUE(crosses_table(w.detour.ends));
  EXPECT_FALSE(crosses_table(walked_along(w.detour.ends, detours)));
  EXPECT_EQ(detours[0].abs().max().item<float>(), 0);
  EXPECT_EQ(detours[120].abs().max().item<float>(), 0);
  EXPECT_LT(detours.diff(1, 0).norm(2, {1}).max().item<double>(), 0.06) << "no jump";
  EXPECT_TRUE(torch::equal(w.detours_of({0, 120}), detours)) << "the same seed, the same detours";
}

TEST(LearnedDetours, SeedsGoAroundOnBothSidesOfWhatStandsInTheMiddle) {
  const Walk w;
  bool left = false, right = false;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const double aside = w.detours_of({0, 120}, seed)[60][0].item<double>();
    (aside > 0 ? left : right) = true;
    EXPECT_GT(std::abs(aside), kTableWidth / 2);
  }
  EXPECT_TRUE(left && right);
  const Tensor likeliest = w.detours_of({0, 120}, 1, nullptr, 0);
  EXPECT_GT(std::abs(likeliest[60][0].item<double>()), kTableWidth / 2);
  for (uint64_t seed = 2; seed <= 12; ++seed)
    EXPECT_TRUE(torch::equal(w.detours_of({0, 120}, seed, nullptr, 0), likeliest))
        << "the course is no matter of seeds";
}

TEST(LearnedDetours, AreStraightWhereNothingStandsOrTheRootIsNotTold) {
  const Walk w;
  const torch::NoGradGuard no_gradients;
  EXPECT_EQ(w.detours_of({0, 20, 30}).abs().max().item<float>(), 0) << "before the table";
  EXPECT_EQ(
      learned_detours(shipped(), w.keys, whole_keys(121, {0, 120}), SceneDistances(), 1, 1).abs().max().item<float>(),
      0);
  Tensor groups = whole_keys(121, {0, 60, 120});
  groups[60].zero_();
  groups[60][kJointGroups + 20] = 1;  // a wrist
  EXPECT_EQ(learned_detours(shipped(), w.keys, groups, w.scene, 1, 1).abs().max().item<float>(), 0);
}

TEST(LearnedDetours, SayWhereNoPathIsWalkable) {
  const torch::NoGradGuard no_gradients;
  const Walk w;
  std::vector<int64_t> unreached;
  EXPECT_EQ(w.detours_of({0, 36, 84, 120}, 1, &unreached).abs().max().item<float>(), 0)
      << "a key on the table's edge, the next on the other edge";
  EXPECT_EQ(unreached, std::vector<int64_t>{84});
  unreached.clear();
  Clip hurried =
      frames_at(w.detour.ends, {0, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0,
                                0, 0, 0, 0, 0, 0, 0, 0, 120});  // from one side to the other in two thirds of a second
  const Tensor ends = whole_keys(20, {0, 19});
  EXPECT_EQ(learned_detours(shipped(), poses_of(hurried), ends, w.scene, 1, 1, &unreached).abs().max().item<float>(),
            0);
  EXPECT_EQ(unreached, std::vector<int64_t>{19});
  Scene room = floor_scene();
  MeshBuilder wall;
  wall.box({0, 1.2, 0}, {6, 1.2, 0.1});
  room.meshes.push_back(wall.mesh("wall", {0.5F, 0.5F, 0.5F}));
  unreached.clear();
  const Tensor none =
      learned_detours(shipped(), w.keys, whole_keys(121, {0, 120}), SceneDistances(room), 1, 1, &unreached);
  EXPECT_EQ(none.abs().max().item<float>(), 0);
  EXPECT_EQ(unreached, std::vector<int64_t>{120});
}

TEST(LearnedDetours, LeaveChairsThatAStarFindsNoPathOutOf) {
  const torch::NoGradGuard no_gradients;
  std::mt19937_64 random(3);
  const Walk w;
  for (int i = 0; i < 12; ++i) {
    Scene room = floor_scene();
    MeshBuilder chair, table;
    const double half = uniform(random, 0.2, 0.26), aside = uniform(random, -0.3, 0.3);
    chair.box({0, 0.225, -kAway}, {half, 0.225, half});
    chair.box({0, 0.7, -kAway - half}, {half, 0.25, 0.04});
    table.box({aside, 0.37, 0.1}, {uniform(random, 0.3, 0.6), 0.37, uniform(random, 0.2, 0.4)});
    room.meshes.push_back(chair.mesh("chair", {0.5F, 0.5F, 0.5F}));
    room.meshes.push_back(table.mesh("table", {0.5F, 0.5F, 0.5F}));
    const SceneDistances scene(room);
    std::vector<int64_t> unreached;
    const Tensor detours = learned_detours(shipped(), w.keys, whole_keys(121, {0, 120}), scene, 1, 1, &unreached);
    EXPECT_TRUE(unreached.empty()) << i;
    EXPECT_GT(detours.abs().max().item<double>(), 0.2) << i;
    detours_of_poses(w.keys, whole_keys(121, {0, 120}), scene, &unreached);
    EXPECT_FALSE(unreached.empty()) << i << ": else this test says nothing";
  }
}

TEST(LearnedDetours, TakeLinesOfEveryLength) {
  const torch::NoGradGuard no_gradients;
  Scene room = floor_scene();
  MeshBuilder post;
  post.box({0, 1, 0}, {0.1, 1, 0.1});
  room.meshes.push_back(post.mesh("post", {0.5F, 0.5F, 0.5F}));
  const SceneDistances scene(room);
  for (const double length : {0.89, 0.901, 0.95, 1.5, 6.9, 7.1, 12.0}) {
    Clip clip = table_detour(121, 30).ends;
    const Tensor along = torch::linspace(-length / 2, length / 2, 121);
    const Tensor moved = torch::zeros({121, 3});
    moved.select(1, 2).copy_(along - clip.joints.select(1, 0).select(1, 2));
    clip.trans = clip.trans + moved;
    clip.joints = clip.joints + moved.unsqueeze(1);
    std::vector<int64_t> unreached;
    const Tensor detours =
        learned_detours(shipped(), poses_of(clip), whole_keys(121, {0, 120}), scene, 1, 1, &unreached);
    EXPECT_TRUE(detours.isfinite().all().item<bool>()) << length;
    EXPECT_EQ(unreached.empty(), length < 7) << length;
    EXPECT_EQ(detours.abs().max().item<double>() > 0.15, length > 0.9 && length < 7) << length;
  }
}

TEST(LearnedDetours, LeadAroundWhatBlocksTheLineInRoomsOfAllKinds) {
  const torch::NoGradGuard no_gradients;
  int64_t found = 0, rooms = 0;
  for (const BlockedRoom& room : blocked_rooms(10, 121, 30, 7)) {
    const Poses keys = poses_of(room.ends);
    const Tensor detours =
        learned_detours(shipped(), keys, whole_keys(121, {0, 120}), SceneDistances(room.scene), 1, 3);
    // Measured on the scene itself, at heights of its own.
    const SceneQuery query(room.scene.meshes.empty() ? room.scene : obstacles_of(room.scene));
    const Eigen::Vector3f a = keys.root(0), b = keys.root(120);
    double nearest = 10;
    for (int64_t t = 0; t <= 120; ++t) {
      const auto part = static_cast<float>(t) / 120;
      Eigen::Vector3f at =
          a + part * (b - a) + Eigen::Vector3f(detours[t][0].item<float>(), 0, detours[t][1].item<float>());
      at.y() = 0;
      Eigen::Vector3f from_a = at - a, from_b = at - b;
      from_a.y() = from_b.y() = 0;
      if (std::min(from_a.norm(), from_b.norm()) < 0.5F) continue;
      Tensor places = torch::zeros({30, 3});
      for (int64_t i = 0; i < 30; ++i)
        places[i].copy_(torch::tensor({at.x(), 0.22F + 0.05F * static_cast<float>(i), at.z()}));
      nearest = std::min(nearest, query.closest(places).distances.min().item<double>());
    }
    found += nearest > 0.2 ? 1 : 0;
    ++rooms;
  }
  EXPECT_EQ(found, rooms) << "0.2 m from everything, all the way from key to key";
}

}  // namespace
}  // namespace inhabit::inbetween
