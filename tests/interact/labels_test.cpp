// Protects the labels: actions, phases, goals and contacts of a motion whose every frame is known.
#include "inhabit/interact/labels.h"

#include <gtest/gtest.h>

#include "inhabit/interact/seated.h"
#include "interact/sitter.h"

namespace inhabit::interact {
namespace {

class LabelsOfASitter : public testing::Test {
 protected:
  Sitter sitter;
  Labels labels = label(sitter.clip, chair_of(sitter.clip, seat_scene()));
  float at(const torch::Tensor& of, int64_t t, int64_t i) const { return of[t][i].item<float>(); }
};

TEST_F(LabelsOfASitter, TheStayIsWhereThePelvisTouches) {
  const std::vector<Stay> stays = stays_of(sitter.clip);
  ASSERT_EQ(stays.size(), 1U);
  EXPECT_EQ(stays[0].down, 60);
  EXPECT_EQ(stays[0].first, 90);
  EXPECT_EQ(stays[0].last, 149);
  EXPECT_EQ(stays[0].rise, 150);
  EXPECT_EQ(stays[0].risen, 179);
  EXPECT_NEAR((stays[0].rest - Eigen::Vector3d(0, 0.55, -0.05)).norm(), 0, 1e-5);
  EXPECT_NEAR(stays[0].heading, 0, 1e-5);
}

TEST_F(LabelsOfASitter, WithoutNamesThePelvisTellsAlmostTheSame) {
  Clip clip = sitter.clip;
  clip.action = torch::Tensor();
  const std::vector<Stay> stays = stays_of(clip);
  ASSERT_EQ(stays.size(), 1U);
  EXPECT_NEAR(static_cast<double>(stays[0].down), 60, 2);
  EXPECT_NEAR(static_cast<double>(stays[0].risen), 180, 2);
  EXPECT_LT(stays[0].rise, 150);
}

TEST_F(LabelsOfASitter, ActionsChangeOverHalfASecondAndSumToOne) {
  EXPECT_TRUE(torch::allclose(labels.action.sum(1), torch::ones({Sitter::kFrames})));
  EXPECT_FLOAT_EQ(at(labels.action, 40, 1), 1);
  EXPECT_NEAR(at(labels.action, 60, 2), 0.5, 0.05);
  EXPECT_FLOAT_EQ(at(labels.action, 100, 2), 1);
  EXPECT_FLOAT_EQ(at(labels.action, 165, 0), 1);
  EXPECT_FLOAT_EQ(at(labels.action, 220, 1), 1);
}

TEST_F(LabelsOfASitter, ThePhaseIsTheGaitsAndThatOfSittingDown) {
  const float* p = labels.global_phase.data_ptr<float>();
  for (int64_t t = 1; t < Sitter::kFrames; ++t) EXPECT_GE(p[t], p[t - 1]) << t;
  // Left down at 10 and 40, right at 25 and 55.
  EXPECT_NEAR(p[40] - p[10], 1, 1e-5);
  EXPECT_NEAR(p[25] - p[10], 0.5, 1e-5);
  EXPECT_NEAR(p[10] - std::floor(p[10]), 0, 1e-5);
  EXPECT_NEAR(p[60] - std::floor(p[60]), 0, 1e-5);
  EXPECT_NEAR(p[75] - p[60], 0.5, 1e-5);
  EXPECT_NEAR(p[90] - p[60], 1, 1e-5);
  EXPECT_FLOAT_EQ(p[150], p[90]);
  EXPECT_NEAR(p[179] - p[150], 1, 1e-5);
}

TEST_F(LabelsOfASitter, TheGoalIsTheSeatUntilOneRisesAndThenWhereOneWalksTo) {
  for (const int64_t t : {0, 80, 149}) {
    EXPECT_TRUE(torch::allclose(labels.goal[t], torch::tensor({0.F, 0.45F, -0.05F}), 1e-4, 1e-4)) << labels.goal[t];
    EXPECT_TRUE(torch::allclose(labels.goal_direction[t], torch::tensor({0.F, 0.F, 1.F}), 1e-4, 1e-4));
    EXPECT_EQ(at(labels.goal_action, t, 2), 1);
  }
  EXPECT_NEAR(at(labels.goal, 150, 0), 2.4 * 59 / 60, 1e-4);
  EXPECT_EQ(at(labels.goal, 150, 1), 0);
  EXPECT_NEAR(at(labels.goal_direction, 150, 0), 1, 1e-2);  // faces +X at the end
  EXPECT_EQ(at(labels.goal_action, 200, 1), 1);
  EXPECT_EQ(at(labels.goal_action, 239, 0), 1);
}

TEST_F(LabelsOfASitter, AHandsPhaseGoesFromLeavingToTouching) {
  EXPECT_EQ(at(labels.hand_phase, 55, 0), 0);
  int64_t start = 0;
  while (labels.hand_target[start][0][3].item<float>() == 0) ++start;
  EXPECT_NEAR(static_cast<double>(start), 60, 4);  // speeds are smoothed over five frames
  for (int64_t t = start; t < 90; ++t) EXPECT_NEAR(at(labels.hand_phase, t, 0), (t - start) / (90.0 - start), 1e-5);
  for (int64_t t = start; t < 120; ++t)
    EXPECT_TRUE(torch::allclose(labels.hand_target[t][0], torch::tensor({0.3F, 0.45F, 0.1F, 1.F}))) << t;
  EXPECT_EQ(at(labels.hand_phase, 119, 0), 1);
  EXPECT_EQ(at(labels.hand_phase, 120, 0), 0);
  EXPECT_EQ(labels.hand_target.select(1, 1).abs().sum().item<float>(), 0);
}

TEST_F(LabelsOfASitter, WhereNobodySitsThereIsNoChair) {
  Clip clip = sitter.clip;
  clip.contact = torch::zeros_like(clip.contact);
  EXPECT_FALSE(chair_of(clip, seat_scene()));
  const Labels walking = label(clip, {});
  EXPECT_EQ(walking.goal_action.select(1, 2).sum().item<float>(), 0);
}

}  // namespace
}  // namespace inhabit::interact
