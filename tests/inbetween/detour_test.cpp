// Protects the measure of who goes around: rooms in which the straight line is blocked and a detour is there, with
// mirror images that are such, and counts of who gets through with the whole body and meets both keys.
#include "inhabit/inbetween/detour.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numeric>
#include <set>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/metrics/collision.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

const std::vector<BlockedRoom>& ten_rooms() {
  static const std::vector<BlockedRoom> rooms = blocked_rooms(5, 121, 30, 4);
  return rooms;
}

/// (T) metres that the body is inside the scene.
Tensor depth(const Clip& clip, const Scene& scene) {
  return CollisionMeter(builtin_body(), scene).measure(clip, {kNoTolerance}).front().depth;
}

/// A method that gives the ends' straight line with its root moved by what `shift` of a window and a seed says.
Method moved(const std::string& name, const std::function<Tensor(const FillTask&, uint64_t)>& shift, bool random) {
  return {name,
          [shift](const FillTask& task, uint64_t seed) {
            Clip out = task.window.conditioning;
            out.trans = out.trans + shift(task, seed);
            out.joints = joint_positions(out.skeleton, out.rotations, out.trans);
            return out;
          },
          random};
}

/// (T, 3) high over everything but at the first `keys` frames and the last ones.
Tensor over_all(int64_t frames, int64_t keys) {
  Tensor up = torch::zeros({frames, 3});
  up.slice(0, keys, frames - keys).select(1, 1).fill_(10);
  return up;
}

TEST(BlockedRooms, BlockTheStraightLineAndLeaveAWay) {
  const std::vector<BlockedRoom>& rooms = ten_rooms();
  ASSERT_EQ(rooms.size(), 10U);
  std::set<std::string> names;
  for (const BlockedRoom& room : rooms) {
    names.insert(room.name);
    const Tensor inside = depth(room.ends, room.scene);
    EXPECT_GT(inside.max().item<double>(), 0.03) << room.name;
    EXPECT_EQ(inside[0].item<double>(), 0) << room.name;
    EXPECT_EQ(inside[-1].item<double>(), 0) << room.name;
    const Tensor line = room.ends.root_path()[-1] - room.ends.root_path()[0];
    EXPECT_GT(room.detour, line.norm().item<double>() - 1e-3) << room.name;
    EXPECT_LT(room.detour, kBriskWalk * room.ends.seconds()) << room.name;
    const Tensor feet = room.ends.joints.select(2, 1).index_select(1, torch::tensor({10, 11}));
    EXPECT_NEAR(feet[0].min().item<double>(), 0.02, 1e-3) << "stands on the floor";
  }
  EXPECT_EQ(names.size(), 10U);
  EXPECT_EQ(names.count("wall 4 mirrored"), 1U);
}

TEST(BlockedRooms, ComeWithTheirMirrorImages) {
  for (size_t pair = 0; pair < 5; ++pair) {
    const BlockedRoom &room = ten_rooms()[2 * pair], &other = ten_rooms()[2 * pair + 1];
    EXPECT_EQ(room.kind, static_cast<int64_t>(pair));
    EXPECT_TRUE(room.ends.joints.equal(other.ends.joints));
    ASSERT_EQ(room.scene.meshes.size(), other.scene.meshes.size());
    // Heights stay, and so do places along the line; places beside it change their sign.
    const Tensor from = room.ends.root_path()[0], to = room.ends.root_path()[-1];
    Tensor ahead = to - from;
    ahead[1] = 0;
    ahead = ahead / ahead.norm();
    const Tensor left = torch::stack({ahead[2], torch::zeros({}), -ahead[0]});
    for (size_t m = 1; m < room.scene.meshes.size(); ++m) {  // the floor comes first
      const auto sorted = [&](const Scene& scene, const Tensor& along, float sign) {
        return std::get<0>(((scene.meshes[m].vertices - from).matmul(along) * sign).sort());
      };
      for (const Tensor& along : {ahead, torch::tensor({0.F, 1.F, 0.F})})
        EXPECT_TRUE(sorted(room.scene, along, 1).allclose(sorted(other.scene, along, 1), 0, 1e-4)) << room.name;
      EXPECT_TRUE(sorted(room.scene, left, 1).allclose(sorted(other.scene, left, -1), 0, 1e-4)) << room.name;
    }
  }
}

TEST(BlockedRooms, FollowFromTheSeed) {
  const std::vector<BlockedRoom> again = blocked_rooms(1, 121, 30, 4), other = blocked_rooms(1, 121, 30, 5);
  EXPECT_TRUE(again[0].ends.joints.equal(ten_rooms()[0].ends.joints));
  EXPECT_TRUE(again[1].scene.meshes[1].vertices.equal(ten_rooms()[1].scene.meshes[1].vertices));
  EXPECT_FALSE(other[0].ends.joints.equal(again[0].ends.joints));
  EXPECT_THAT(refusal_of([] { blocked_rooms(1, 10, 30, 4); }), testing::HasSubstr("too short"));
}

TEST(Detour, CountsWhoGetsThroughAndMeetsTheKeys) {
  const std::vector<BlockedRoom>& rooms = ten_rooms();
  const auto none = [](const FillTask& task, uint64_t) { return torch::zeros({task.window.conditioning.frames(), 3}); };
  const auto over = [](const FillTask& task, uint64_t) { return over_all(task.window.conditioning.frames(), 1); };
  const auto off_keys = [](const FillTask& task, uint64_t) { return over_all(task.window.conditioning.frames(), 0); };
  const auto even_seeds = [&](const FillTask& task, uint64_t seed) {
    return seed % 2 == 0 ? over(task, seed) : none(task, seed);
  };
  DetourEvaluation options;
  options.seeds = 8;
  int64_t last = 0, all = 0;
  options.progress = [&](int64_t done, int64_t of) {
    EXPECT_EQ(done, ++last);
    all = of;
  };
  const std::vector<DetourScores> scores =
      evaluate_detour(rooms,
                      {moved("straight", none, false), moved("over", over, false), moved("off keys", off_keys, false),
                       moved("sometimes", even_seeds, true)},
                      options);
  EXPECT_EQ(last, 3 * 10 + 80);
  EXPECT_EQ(all, last);
  double sum = 0;
  for (size_t r = 0; r < rooms.size(); ++r) {
    EXPECT_EQ(scores[0].succeeded[r], 0) << rooms[r].name;
    EXPECT_EQ(scores[1].succeeded[r], 1) << rooms[r].name;
    EXPECT_EQ(scores[2].succeeded[r], 0) << "the keys are missed";
    sum += scores[3].succeeded[r];
  }
  EXPECT_EQ(scores[3].runs, 8);
  EXPECT_NEAR(sum / 10, 0.5, 0.2);  // 80 coins: a deviation of 0.056

  const ScoreTable table = score_table(scores, rooms, options);
  ASSERT_EQ(table.rows.size(), 4U);
  EXPECT_EQ(table.columns[0].key, "success");
  for (size_t c = 0; c < table.columns.size(); ++c) {
    EXPECT_EQ(table.rows[0].cells[c].mean, 0) << table.columns[c].key;
    EXPECT_NEAR(table.rows[1].cells[c].mean, 1, 1e-12) << table.columns[c].key;
    EXPECT_EQ(table.rows[1].cells[c].interval, 0);
  }
  EXPECT_NEAR(table.rows[3].cells[0].mean, sum / 10, 1e-9);
  EXPECT_GT(table.rows[3].cells[0].interval, 0);
  EXPECT_THAT(refusal_of([&] { evaluate_detour({rooms[0]}, {}, options); }), testing::HasSubstr("pairs"));
}

TEST(Detour, SolvedIsEightOfTen) {
  DetourEvaluation options;
  const std::vector<BlockedRoom> rooms(ten_rooms().begin(), ten_rooms().begin() + 4);
  const ScoreTable table = score_table({{"some", 10, {0.8, 0.8, 1, 0.7}}}, rooms, options);
  EXPECT_NEAR(table.rows[0].cells[0].mean, 0.825, 1e-12);
  EXPECT_NEAR(table.rows[0].cells[1].mean, 0.75, 1e-12);
  EXPECT_NEAR(table.rows[0].cells[2].mean, 0.5, 1e-12);
  EXPECT_NEAR(table.rows[0].cells[3].mean, 0.8, 1e-12) << "tables";
  EXPECT_NEAR(table.rows[0].cells[4].mean, 0.85, 1e-12) << "sofas";
  EXPECT_TRUE(std::isnan(table.rows[0].cells[5].mean)) << "no shelf";
}

TEST(Detour, TheSplineAlongTheDetourIsBetterThanTheStraightOne) {
  DetourEvaluation options;
  const std::vector<DetourScores> scores = evaluate_detour(ten_rooms(), interpolation_methods(), options);
  const auto mean = [&](const std::string& name) {
    for (const DetourScores& row : scores)
      if (row.method == name) return std::accumulate(row.succeeded.begin(), row.succeeded.end(), 0.) / 10;
    throw std::runtime_error(name);
  };
  EXPECT_EQ(mean("linear + slerp"), 0);
  EXPECT_GT(mean("slerp + detour"), 0);
  EXPECT_GT(mean("spline + detour"), 0);
}

}  // namespace
}  // namespace inhabit::inbetween
