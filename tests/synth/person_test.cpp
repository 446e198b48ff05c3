#include "inhabit/synth/person.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "inhabit/body/kinematics.h"
#include "inhabit/synth/room.h"

namespace inhabit {
namespace {

using torch::indexing::Slice;

struct Life {
  Room room;
  Clip clip;
};

/// Clips of a few seeded rooms, made once.
const std::vector<Life>& lives() {
  static const std::vector<Life> made = [] {
    std::vector<Life> out;
    for (uint64_t seed = 100; seed < 110; ++seed) {
      std::mt19937_64 random(seed);
      Life life;
      life.room = make_room(random);
      life.clip = live(life.room, builtin_body(), random, {12});
      out.push_back(std::move(life));
    }
    return out;
  }();
  return made;
}

int64_t label(const Clip& clip, const std::string& name) {
  for (size_t i = 0; i < clip.action_names.size(); ++i)
    if (clip.action_names[i] == name) return static_cast<int64_t>(i);
  return -1;
}

TEST(Person, ClipsAreWholeAndConsistent) {
  for (const Life& life : lives()) {
    validate(life.clip, "clip");
    EXPECT_EQ(life.clip.frames(), 360);
    const torch::Tensor again = joint_positions(life.clip.skeleton, life.clip.rotations, life.clip.trans);
    EXPECT_LT((again - life.clip.joints).abs().max().item<double>(), 1e-4);
  }
}

TEST(Person, SameSeedSameClip) {
  for (int round = 0; round < 2; ++round) {
    std::mt19937_64 random(100);
    const Room room = make_room(random);
    const Clip clip = live(room, builtin_body(), random, {12});
    EXPECT_TRUE(torch::equal(clip.joints, lives().front().clip.joints));
  }
}

TEST(Person, FeetDoNotSkate) {
  double skating = 0, frames = 0;
  for (const Life& life : lives()) {
    const torch::Tensor feet = life.clip.joints.index({Slice(), Slice(10, 12)});
    const torch::Tensor moved = (feet.slice(0, 1) - feet.slice(0, 0, -1)).norm(2, -1);
    const torch::Tensor low = feet.slice(0, 0, -1).select(-1, 1) < 0.05;
    skating += ((moved > 0.025) & low).any(1).sum().item<double>();
    frames += static_cast<double>(moved.size(0));
  }
  EXPECT_LT(skating / frames, 0.03);
}

TEST(Person, PlantedFeetStandStillOnTheFloor) {
  for (const Life& life : lives()) {
    const torch::Tensor& joints = life.clip.joints;
    for (int64_t foot : {10, 11}) {
      const torch::Tensor at = joints.select(1, foot);
      const torch::Tensor down = life.clip.contact.select(1, foot) > 0;
      const torch::Tensor both = down.slice(0, 1) & down.slice(0, 0, -1);
      const torch::Tensor moved = (at.slice(0, 1) - at.slice(0, 0, -1)).norm(2, -1);
      EXPECT_LT(moved.masked_select(both).mean().item<double>(), 0.004);
      EXPECT_GT(at.select(1, 1).min().item<double>(), 0.0);
    }
  }
}

TEST(Person, WalksLikeAPerson) {
  double frames = 0, speed = 0, acceleration = 0, jerk = 0;
  for (const Life& life : lives()) {
    const Clip& clip = life.clip;
    const torch::Tensor walking = clip.action == label(clip, "walk");
    const torch::Tensor v = (clip.joints.slice(0, 1) - clip.joints.slice(0, 0, -1)) * clip.rate;
    const torch::Tensor a = (v.slice(0, 1) - v.slice(0, 0, -1)) * clip.rate;
    const torch::Tensor j = (a.slice(0, 1) - a.slice(0, 0, -1)) * clip.rate;
    const torch::Tensor w = walking.slice(0, 1, -2).to(torch::kFloat);
    frames += w.sum().item<double>();
    const torch::Tensor root = v.select(1, 0).index_select(1, torch::tensor({0, 2})).norm(2, -1);
    speed += (root.slice(0, 1, -1) * w).sum().item<double>();
    acceleration += (a.norm(2, -1).mean(1).slice(0, 0, -1) * w).sum().item<double>();
    jerk += (j.norm(2, -1).mean(1) * w).sum().item<double>();
  }
  ASSERT_GT(frames, 300);
  EXPECT_GT(speed / frames, 0.6);
  EXPECT_LT(speed / frames, 1.5);
  EXPECT_GT(acceleration / frames, 6);
  EXPECT_LT(acceleration / frames, 14);
  EXPECT_GT(jerk / frames, 220);
  EXPECT_LT(jerk / frames, 560);
}

TEST(Person, KeepsTheJointLimits) {
  const torch::Tensor limits = builtin_body().joint_limits.slice(0, 1);
  for (const Life& life : lives()) {
    const torch::Tensor rotations = life.clip.rotations.slice(1, 1);
    EXPECT_LE((rotations - limits.select(2, 1)).max().item<double>(), 1e-4);
    EXPECT_LE((limits.select(2, 0) - rotations).max().item<double>(), 1e-4);
  }
}

TEST(Person, HandContactsLieOnSurfaces) {
  int64_t touches = 0;
  for (const Life& life : lives()) {
    const auto target = life.clip.hand_targets.accessor<float, 3>();
    for (int64_t t = 0; t < life.clip.frames(); ++t)
      for (int side = 0; side < 2; ++side) {
        if (target[t][side][3] == 0) continue;
        ++touches;
        const Eigen::Vector3d p(target[t][side][0], target[t][side][1], target[t][side][2]);
        double nearest = 1e9;
        for (const Furniture& piece : life.room.furniture) {
          const Eigen::Vector3d own = piece.pose.inverse() * p;
          for (const Box& box : piece.boxes) {
            const Eigen::Vector3d out = (own - box.center).cwiseAbs() - box.half;
            nearest = std::min(nearest, std::abs(out.cwiseMax(0).norm() + std::min(out.maxCoeff(), 0.0)));
          }
        }
        EXPECT_LT(nearest, 0.01) << "frame " << t;
        const double reach =
            (life.clip.joints[t][20 + side] - life.clip.hand_targets[t][side].slice(0, 0, 3)).norm().item<double>();
        EXPECT_LT(reach, 0.13) << "the wrist is not at the touched point, frame " << t;
      }
  }
  EXPECT_GT(touches, 30);
}

TEST(Person, DoesWhatPeopleDo) {
  std::set<std::string> seen;
  for (const Life& life : lives())
    for (int64_t t = 0; t < life.clip.frames(); t += 3)
      seen.insert(life.clip.action_names[life.clip.action[t].item<int64_t>()]);
  for (const char* name : {"stand", "walk", "turn", "sit_down", "sit", "stand_up"})
    EXPECT_TRUE(seen.count(name)) << name;
}

}  // namespace
}  // namespace inhabit
