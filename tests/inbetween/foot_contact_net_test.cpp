// Protects what is predicted of the contacts of feet: the labels that FootContactNet learns from, and that refinement
// goes by what it predicts.
#include "inhabit/inbetween/foot_contact_net.h"

#include <gtest/gtest.h>

#include "inbetween/small_network.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/io/files.h"
#include "inhabit/scene/shapes.h"
#include "largest.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

Clip walk() {
  Clip clip = read_clip(std::string(INHABIT_SOURCE_DIR) + "/examples/data/walk.npz");
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

TEST(FootContacts, AlternateWhileSomebodyWalks) {
  const Clip clip = walk();
  const Tensor feet = foot_contacts(poses_of(clip), clip.rate);
  ASSERT_EQ(feet.sizes(), torch::IntArrayRef({clip.frames(), 4}));
  const Tensor left = feet.select(1, 2), right = feet.select(1, 3);  // balls
  EXPECT_GT(torch::maximum(left, right).mean().item<double>(), 0.9) << "somebody who walks stands on a foot";
  const auto changes = [](const Tensor& ball) { return ball.diff().abs().sum().item<double>(); };
  EXPECT_GE(changes(left), 3);
  EXPECT_GE(changes(right), 3);
  for (const int64_t side : {0, 1}) {  // a ball in contact is slow, and faster where it is not
    const Tensor speed = clip.joints.select(1, 10 + side).diff(1, 0).norm(2, {1}) * clip.rate;
    const Tensor stands = feet.select(1, 2 + side).slice(0, 1);
    EXPECT_LT((speed * stands).sum().item<double>() / stands.sum().item<double>(), 0.2);
    EXPECT_GT((speed * (1 - stands)).sum().item<double>() / (1 - stands).sum().item<double>(), 0.8);
  }
}

TEST(FootContacts, LastWhileSomebodyStands) {
  const Clip clip = frames_at(walk(), std::vector<int64_t>(40, 0));
  EXPECT_EQ(foot_contacts(poses_of(clip), clip.rate).slice(1, 2).max().item<double>(), 1);
  EXPECT_EQ(foot_contacts(poses_of(clip), clip.rate).diff(1, 0).abs().max().item<double>(), 0);
}

/// A model that tells, whatever it sees, that feet are in contact with a probability of sigmoid(logit).
SceneInbetweener telling(double logit) {
  const torch::NoGradGuard no_gradients;
  Networks networks = residual_networks(0.02);
  networks.feet = foot_contact_net(networks.config);
  for (Tensor& p : networks.feet->parameters()) p.zero_();
  networks.feet->tell->bias.fill_(logit);
  return SceneInbetweener(networks);
}

TEST(FootContacts, AreWhatRefinementGoesBy) {
  const Clip stance = slice(walk(), 8, 19);  // of the left foot
  Options options;
  options.keys = {0, 10};
  const auto ball_moves = [&](double logit) {  // metres a frame between the keys
    const Tensor ball = telling(logit).run(stance, floor_scene(), options).motion.joints.select(1, 10);
    return ball.diff(1, 0).norm(2, {1}).slice(0, 2, 8).mean().item<double>();
  };
  EXPECT_LT(ball_moves(5), 0.5 * ball_moves(-5));
  EXPECT_LT(ball_moves(5), 0.004);
}

}  // namespace
}  // namespace inhabit::inbetween
