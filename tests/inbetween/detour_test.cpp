// Protects the measure of scene work: who goes around the table and who does not, the same seeds with and without it.
#include "inhabit/inbetween/detour.h"

#include <gtest/gtest.h>

#include "inbetween/small_network.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/metrics/penetration.h"
#include "inhabit/scene/query.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

/// The ends with a root that swings out by `aside` metres half way.
Clip by_way_of(const Detour& detour, double aside) {
  Clip clip = detour.ends;
  clip.trans = clip.trans.clone();
  clip.trans.select(1, 0).add_(aside * torch::sin(torch::linspace(0, M_PI, clip.frames())));
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

TEST(Detour, TheStraightWayIsBlockedAndTheWayAroundIsNot) {
  const Detour detour = table_detour(121, 30);
  EXPECT_TRUE(crosses_table(detour.ends));
  EXPECT_TRUE(crosses_table(by_way_of(detour, 0.4)));
  for (const double aside : {-1.0, 1.0}) EXPECT_FALSE(crosses_table(by_way_of(detour, aside))) << aside;
  const SceneQuery query(detour.room);
  const Tensor ends = torch::cat({detour.ends.joints[0], detour.ends.joints[120]});
  EXPECT_GT(query.signed_distance(ends).min().item<double>(), 0) << "nobody stands in the table";
}

TEST(Detour, CountsRunsOfAModel) {
  torch::manual_seed(3);
  Networks networks;
  networks.config = small_inbetween_config();
  networks.config.frames = 32;
  networks.config.padded = 32;
  networks.config.anchors = 64;
  networks.network = untrained(networks.config);
  networks.scale.mean = torch::zeros({kFeatureCount});
  networks.scale.deviation = torch::ones({kFeatureCount});
  Options request;
  request.steps = 2;
  const DetourScores scores = evaluate_detour(SceneInbetweener(networks), request, 3);
  EXPECT_EQ(scores.runs, 3);
  EXPECT_LE(scores.around_unseen, 3);
  // The same model, told to leave its interpolation alone, goes where that leads: around, and through.
  networks.config.from_interpolation = networks.config.around_obstacles = true;
  networks.config.frames = networks.config.padded = 64;
  networks.network = untrained(networks.config);
  networks.network->unet->out_conv->weight.data().zero_();
  networks.network->unet->out_conv->bias.data().zero_();
  const DetourScores walked = evaluate_detour(SceneInbetweener(networks), request, 3);
  EXPECT_EQ(walked.around, 3);
  EXPECT_EQ(walked.around_unseen, 0);
}

}  // namespace
}  // namespace inhabit::inbetween
