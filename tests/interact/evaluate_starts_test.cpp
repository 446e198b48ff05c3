// Protects the figures of starts around chairs: where people start, who counts as seated, and who as having gone
// through.
#include "inhabit/interact/evaluate_starts.h"

#include <gtest/gtest.h>

#include "inhabit/math/heading.h"
#include "interact/chair_scene.h"
#include "refusal_of.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;

Scene chair_scene() {
  std::mt19937_64 random(4);
  return scene_of({make_solid_chair(random, 0.45)});
}

/// Somebody who keeps the pose of the start and whose pelvis goes along these places (x, z and height), a frame each.
Clip along(const Clip& start, const std::vector<Vector3d>& places) {
  Clip out = frames_at(start, std::vector<int64_t>(places.size(), 0));
  out.joints = out.joints.clone();
  out.trans = out.trans.clone();
  for (size_t t = 0; t < places.size(); ++t) {
    const auto frame = static_cast<int64_t>(t);
    const torch::Tensor to = torch::tensor({places[t].x(), places[t].y(), places[t].z()}, torch::kFloat);
    const torch::Tensor by = (to - out.joints[frame][0]).clone();
    out.joints[frame] += by;
    out.trans[frame] += by;
  }
  return out;
}

Vector3d pelvis_of(const Clip& clip) {
  const torch::Tensor p = clip.joints[0][0].to(torch::kFloat64).contiguous();
  return Eigen::Map<const Vector3d>(p.data_ptr<double>());
}

TEST(EvaluateStarts, AreAroundTheChairOnFreeFloor) {
  const Scene scene = chair_scene();
  const Chair chair = find_chair(scene, "solid_chair_0");
  const std::vector<Trial> trials = around_chair(scene, chair, 40, 2), again = around_chair(scene, chair, 40, 2);
  ASSERT_EQ(trials.size(), 40);
  int behind = 0;
  for (size_t i = 0; i < trials.size(); ++i) {
    EXPECT_TRUE(torch::equal(trials[i].start.joints, again[i].start.joints)) << "the same seed, the same starts";
    const Eigen::Vector2d off = on_ground(pelvis_of(trials[i].start) - chair.seat());
    EXPECT_GT(off.norm(), 0.85);
    EXPECT_LT(off.norm(), 3.15);
    behind += off.dot(ahead_of(chair.heading())) < 0 ? 1 : 0;
  }
  EXPECT_GT(behind, 10);
  EXPECT_LT(behind, 30);
}

TEST(EvaluateStarts, AreASetForEachChairOfAScene) {
  const std::vector<StartSet> sets = around_chairs(chair_scene(), "room.glb", 3, 2);
  ASSERT_EQ(sets.size(), 1);
  EXPECT_EQ(sets[0].name, "solid_chair_0");
  EXPECT_EQ(sets[0].starts.size(), 3);
  EXPECT_EQ(refusal_of([] { around_chairs({}, "room.glb", 3, 2); }), "room.glb: holds nothing to sit on");
}

TEST(EvaluateStarts, TellsWhoSitsFromWhoWaitsAndWhoGoesThrough) {
  const Scene scene = chair_scene();
  const Chair chair = find_chair(scene, "solid_chair_0");
  const Vector3d rest = chair.seat() + Vector3d(0, 0.15, 0);
  const auto ahead = ahead_of(chair.heading());
  const auto walk_from = [&](const Trial& trial, double far) {
    std::vector<Vector3d> places;
    const double height = pelvis_of(trial.start).y();
    for (int t = 0; t <= 30; ++t) {
      const Eigen::Vector2d at = on_ground(chair.seat()) + far * (1 - t / 30.0) * ahead;
      places.emplace_back(at.x(), height, at.y());
    }
    places.insert(places.end(), 40, rest);
    return along(trial.start, places);
  };
  const std::vector<InteractMethod> methods = {
      {"from the front", [&](const Trial& trial, uint64_t) { return walk_from(trial, 1.5); }},
      {"from behind", [&](const Trial& trial, uint64_t) { return walk_from(trial, -1.5); }},
      {"waits", [&](const Trial& trial, uint64_t) {
         return along(trial.start, std::vector<Vector3d>(60, pelvis_of(trial.start)));
       }}};
  const std::vector<StartScores> scores = evaluate_starts({{"chair", around_chair(scene, chair, 3, 1)}}, methods, 1);
  ASSERT_EQ(scores.size(), 3);
  EXPECT_EQ(scores[1].seated.mean, 1);
  EXPECT_EQ(scores[1].through.mean, 1);
  EXPECT_EQ(scores[1].around.mean, 0);
  EXPECT_EQ(scores[0].seated.mean, 1);
  EXPECT_EQ(scores[2].seated.mean, 0);
  EXPECT_EQ(scores[2].through.mean, 0);
  EXPECT_EQ(score_table(scores).rows.size(), 3);
}

}  // namespace
}  // namespace inhabit::interact
