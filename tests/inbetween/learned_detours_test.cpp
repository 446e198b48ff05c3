// Protects the ways of the shipped PathNet: around what blocks the line and there alone, from key to key, the same for
// the same seed, and said where none is walkable.
#include "inhabit/inbetween/learned_detours.h"

#include <gtest/gtest.h>

#include "inbetween/table_detour.h"
#include "inhabit/inbetween/blocked_rooms.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/model_file.h"

namespace inhabit::inbetween {
namespace {

const PathNet& shipped() {
  static const PathNet network = load_networks(INHABIT_SOURCE_DIR "/models/inbetween-compact.safetensors").path;
  return network;
}

Tensor whole_keys(const std::vector<int64_t>& frames) {
  Tensor groups = torch::zeros({121, kKeyGroups});
  for (const int64_t frame : frames) groups[frame].fill_(1);
  return groups;
}

struct Walk {
  Detour detour = table_detour(121, 30);
  Poses keys = poses_of(detour.ends);
  SceneDistances scene = SceneDistances(detour.room);
  Tensor way(const std::vector<int64_t>& frames, uint64_t seed = 1, std::vector<int64_t>* unreached = nullptr) const {
    const torch::NoGradGuard no_gradients;
    return learned_detours(shipped(), keys, whole_keys(frames), scene, seed, unreached);
  }
};

TEST(LearnedDetours, BendWhereTheTableStands) {
  const Walk w;
  const Tensor detours = w.way({0, 120});
  Clip walked = w.detour.ends;
  walked.joints = walked.joints.clone();
  walked.joints.select(2, 0).add_(detours.select(1, 0).unsqueeze(1));
  walked.joints.select(2, 2).add_(detours.select(1, 1).unsqueeze(1));
  EXPECT_TRUE(crosses_table(w.detour.ends));
  EXPECT_FALSE(crosses_table(walked));
  EXPECT_EQ(detours[0].abs().max().item<float>(), 0);
  EXPECT_EQ(detours[120].abs().max().item<float>(), 0);
  EXPECT_LT(detours.diff(1, 0).norm(2, {1}).max().item<double>(), 0.06) << "no jump";
  EXPECT_TRUE(torch::equal(w.way({0, 120}), detours)) << "the same seed, the same way";
}

TEST(LearnedDetours, SeedsGoAroundOnBothSidesOfWhatStandsInTheMiddle) {
  const Walk w;
  bool left = false, right = false;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const double aside = w.way({0, 120}, seed)[60][0].item<double>();
    (aside > 0 ? left : right) = true;
    EXPECT_GT(std::abs(aside), kTableWidth / 2);
  }
  EXPECT_TRUE(left && right);
}

TEST(LearnedDetours, AreStraightWhereNothingStandsOrTheRootIsNotTold) {
  const Walk w;
  const torch::NoGradGuard no_gradients;
  EXPECT_EQ(w.way({0, 20, 30}).abs().max().item<float>(), 0) << "before the table";
  EXPECT_EQ(learned_detours(shipped(), w.keys, whole_keys({0, 120}), SceneDistances(), 1).abs().max().item<float>(), 0);
  Tensor groups = whole_keys({0, 60, 120});
  groups[60].zero_();
  groups[60][kJointGroups + 20] = 1;  // a wrist
  EXPECT_EQ(learned_detours(shipped(), w.keys, groups, w.scene, 1).abs().max().item<float>(), 0);
}

TEST(LearnedDetours, SayWhereNoWayIsWalkable) {
  const Walk w;
  std::vector<int64_t> unreached;
  EXPECT_EQ(w.way({0, 48, 72, 120}, 1, &unreached).slice(0, 49, 72).abs().max().item<float>(), 0)
      << "from one side of the table's middle to the other within 0.8 s";
  Scene room = floor_scene();
  MeshBuilder wall;
  wall.box({0, 1.2, 0}, {6, 1.2, 0.1});
  room.meshes.push_back(wall.mesh("wall", {0.5F, 0.5F, 0.5F}));
  unreached.clear();
  const torch::NoGradGuard no_gradients;
  const Tensor none = learned_detours(shipped(), w.keys, whole_keys({0, 120}), SceneDistances(room), 1, &unreached);
  EXPECT_EQ(none.abs().max().item<float>(), 0);
  EXPECT_EQ(unreached, std::vector<int64_t>{120});
}

TEST(LearnedDetours, LeadAroundWhatBlocksTheLineInRoomsOfAllKinds) {
  const torch::NoGradGuard no_gradients;
  int64_t found = 0, rooms = 0;
  for (const BlockedRoom& room : blocked_rooms(10, 121, 30, 7)) {
    const Poses keys = poses_of(room.ends);
    std::vector<int64_t> unreached;
    learned_detours(shipped(), keys, whole_keys({0, 120}), SceneDistances(room.scene), 3, &unreached);
    found += unreached.empty() ? 1 : 0;
    ++rooms;
  }
  EXPECT_GE(found, rooms - 1) << "free of everything from key to key";
}

}  // namespace
}  // namespace inhabit::inbetween
