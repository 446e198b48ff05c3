// Protects that people who sit down are fitted to their chair by the skin and not by what stands for it: nobody is over
// 2 cm deep in the chair, and nobody hovers over it.
#include "inhabit/interact/fit_contacts.h"

#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/interact/seated.h"
#include "inhabit/metrics/collision.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/synth/chairs.h"

namespace inhabit::interact {
namespace {

constexpr double kSeat = 0.44, kHigher = 0.02;  // metres

TEST(FitContacts, FleshRestsOnTheSeatAndIsNotInIt) {
  std::mt19937_64 random(4);
  Room room;
  room.size = {13, 13};
  room.furniture.push_back(make_chair(random, kSeat));
  const ChairSubject subject = draw_subject(builtin_body(), random);
  auto sits =
      sit_on_chair(room, free_space(room), builtin_body(), subject, {Interaction::both_hands, 13, 0.4, 2}, random);
  ASSERT_TRUE(sits);
  Clip clip = *sits;
  clip.hand_targets = torch::zeros({clip.frames(), 2, 4});  // of the chair as it was
  Room higher;
  higher.furniture.push_back(room.furniture.front());
  higher.furniture.front().rescale({1, (kSeat + kHigher) / kSeat, 1});
  const Scene scene = higher.scene();

  const Clip fitted = fit_contacts(clip, scene);
  const CollisionMeter meter(builtin_body(), scene);
  const auto depth = [&](const Clip& motion) { return meter.measure(motion, {kNoTolerance}).front(); };
  EXPECT_GT(depth(clip).penetration(), 0.022) << "or there is nothing to be fitted";
  EXPECT_LE(depth(fitted).penetration(), 0.02);
  const Stay stay = stays_of(clip).front();
  const auto middle = (stay.first + stay.last) / 2;
  EXPECT_GT(depth(fitted).depth[middle].item<double>(), 0.004) << "nobody hovers";
  EXPECT_LT((fitted.joints - clip.joints).select(1, 0).norm(2, {1}).max().item<double>(), 0.05);
  EXPECT_LT(dynamics(fitted).jerk, 1.2 * dynamics(clip).jerk);
}

}  // namespace
}  // namespace inhabit::interact
