// Protects Eq. 6: distances are between contacts of one hand on one chair, wherever and however that stands.
#include "inhabit/interact/evaluate_contacts.h"

#include <gtest/gtest.h>

#include "interact/chair_scene.h"
#include "interact/small_networks.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;

Trial trial_on(const std::string& name, double x, double heading, const std::vector<std::optional<Vector3d>>& in_seat) {
  std::mt19937_64 random(5);
  Furniture piece = make_armchair(random, 0.45);
  piece.place(x, 0.3, heading);
  Trial out;
  out.name = out.scene_file = name;
  out.scene = scene_of({piece});
  out.chair = find_chair(out.scene, "armchair_0");
  for (size_t side = 0; side < 2; ++side)
    if (in_seat[side]) out.contacts[side] = out.chair.frame * *in_seat[side];
  return out;
}

TEST(EvaluateContacts, DistancesAreThoseOfOneHandOnOneChair) {
  const Vector3d left(0.25, 0.6, 0.1), right(-0.25, 0.6, 0.1), ahead(0, 0, 0.03), up(0, 0.04, 0);
  const std::vector<Trial> trials = {
      trial_on("a", 0, 0.2, {left, right}),
      trial_on("a", 0.5, 1.7, {left + ahead + up, std::nullopt}),  // the same chair elsewhere: 5 cm apart
      trial_on("b", 0, 0, {std::nullopt, right}), trial_on("b", 0, -2, {std::nullopt, right + ahead}),  // 3 cm
      trial_on("c", 0, 0, {std::nullopt, std::nullopt})};
  const ChairInteractor interactor(untrained_networks(small_interact_config()));
  const std::vector<ContactScores> scores = evaluate_contacts(trials, interactor, 4, 1);
  ASSERT_EQ(scores.size(), 2);
  EXPECT_EQ(scores[0].contacts, "data");
  EXPECT_EQ(scores[0].chairs, 2);
  EXPECT_NEAR(scores[0].apd.mean, 0.04, 1e-6);
  EXPECT_NEAR(scores[0].touching.mean, (0.75 + 0.5 + 0) / 3, 1e-9);
  EXPECT_LE(scores[1].chairs, 3);
  EXPECT_EQ(score_table(scores).rows.size(), 2);
}

}  // namespace
}  // namespace inhabit::interact
