// Protects the articulated motion network: forward kinematics on the bones that were seen last, angular velocities
// against rotations that are known, a forecast that leaves from the last pose at its velocity, and its losses.
#include "inhabit/forecast/articulated_network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "forecast/bones.h"
#include "forecast/walker_data.h"
#include "inhabit/error.h"
#include "inhabit/forecast/losses.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/motion_batch.h"
#include "inhabit/forecast/motion_of.h"
#include "inhabit/forecast/sample.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/mirror.h"
#include "largest.h"
#include "temp_folder.h"

namespace inhabit::forecast {
namespace {

using torch::Tensor;

constexpr int64_t kTurning = 17;  // of the standard joints, those with children

Config small_articulated() {
  Config c = preset("compact");
  c.articulated.width = 24;
  c.articulated.blocks = 2;
  return c;
}

/// A network whose own part is not 0.
ArticulatedNetwork stirred(const Config& config) {
  torch::manual_seed(8);
  ArticulatedNetwork network(config);
  torch::NoGradGuard no_grad;
  network->out->weight.normal_(0, 0.3);
  network->out->bias.normal_(0, 0.3);
  network->eval();
  return network;
}

/// Two people who walk, one of them with other bones, origin at the last root.
Tensor some_past() {
  Tensor past = torch::stack({walker(30, 1.2, 0, 1).joints, walker(30, 0.7, 0, 0.6).joints * 0.8});
  return past - past.slice(1, 29).slice(2, 0, 1);
}

TEST(PosedFrom, IsForwardKinematicsOfRotationsSinceTheLastPose) {
  torch::manual_seed(3);
  const Skeleton skeleton = builtin_body().skeleton;
  const Tensor local = axis_angle_to_matrix(torch::randn({2, 22, 3}) * 0.4), trans = torch::randn({2, 3});
  const Pose pose = forward_kinematics(skeleton.parents, skeleton.offsets, local, trans);
  // From the first pose to the second: each joint that has children rotates by R2 R1^T.
  std::vector<Tensor> rotations;
  for (int j = 0; j < kStandardJoints; ++j)
    if (std::count(skeleton.parents.begin(), skeleton.parents.end(), j) > 0)
      rotations.push_back(pose.rotations[1][j].matmul(pose.rotations[0][j].t()));
  ASSERT_EQ(rotations.size(), static_cast<size_t>(kTurning));
  const Tensor got = posed_from(pose.positions.slice(0, 0, 1), pose.positions[1][0].view({1, 1, 3}),
                                torch::stack(rotations).view({1, 1, kTurning, 3, 3}));
  EXPECT_LT(largest_difference(got[0][0], pose.positions[1]), 1e-5);
}

TEST(AngularVelocities, AreThoseOfABodyThatTurnsAsAWholeAndZeroAboutASingleBone) {
  const Tensor before = walker(1, 0, 0.3, 1).joints;
  const Tensor velocity = torch::tensor({0.01F, -0.02F, 0.015F});
  const Tensor now = torch::matmul(before, axis_angle_to_matrix(velocity).t());
  const Tensor got = angular_velocities(before, now)[0];
  EXPECT_LT(largest_difference(got[0], velocity), 1e-3);  // the pelvis holds three bones
  // The left hip holds one: what rotates it is the part of the velocity across that bone.
  const Tensor bone = (now[0][4] - now[0][1]) / (now[0][4] - now[0][1]).norm();
  EXPECT_LT(largest_difference(got[1], velocity - bone * velocity.dot(bone)), 1e-3);
}

TEST(ArticulatedNetwork, KeepsThePersonsBonesWhateverItsWeights) {
  torch::NoGradGuard no_grad;
  const Config c = small_articulated();
  const Tensor past = some_past();
  const MotionForecast f = stirred(c)->forward(past, torch::rand({2, 60, 22, 4}), contact_conditioning(2, true, false));
  const Tensor joints = forecast_joints(f, 0);
  ASSERT_EQ(joints.sizes(), (torch::IntArrayRef{2, 60, 22, 3}));
  EXPECT_GT(largest_difference(joints, past.slice(1, 29).expand_as(joints)), 0.3);  // it moves
  EXPECT_LT(largest_difference(bone_lengths(joints), bone_lengths(past.slice(1, 29)).expand({2, 60, 21})), 1e-5);
}

TEST(ArticulatedNetwork, LeavesFromTheLastPoseAtItsVelocity) {
  torch::NoGradGuard no_grad;
  const Config c = small_articulated();
  const Tensor past = some_past(), none = torch::zeros({2, 60, 22, 4}),
               conditioning = contact_conditioning(2, false, false);
  const Tensor last = past.select(1, 29), step = last - past.select(1, 28);
  const Tensor untrained = forecast_joints(ArticulatedNetwork(c)->forward(past, none, conditioning), 0);
  const Tensor error = (untrained.select(1, 0) - last - step).norm(2, {-1});
  EXPECT_LT(error.mean().item<double>(), 0.2 * step.norm(2, {-1}).mean().item<double>());
  // Half a second later half of the root's velocity is gone, exponentially.
  const double frames = c.articulated.root_continuation * c.rate;
  const double left = frames * (1 - std::exp(-15 / frames));
  EXPECT_LT(largest_difference(untrained.select(1, 14).select(1, 0), step.select(1, 0) * left), 1e-4);
  // The network's own part comes in through a gate that has slope 0.
  const Tensor own = (forecast_joints(stirred(c)->forward(past, none, conditioning), 0) - untrained)
                         .norm(2, {-1})
                         .mean(at::IntArrayRef{0, 2});
  EXPECT_LT(own[0].item<double>(), 0.25 * own[5].item<double>());
}

// Recordings are few enough for the network to remember them: without dropout its path errors on those of training are
// a fifth of those on others (models/forecast-compact.md).
TEST(ArticulatedNetwork, DropsOutInTrainingAlone) {
  torch::NoGradGuard no_grad;
  Config c = small_articulated();
  const Tensor past = some_past(), none = torch::zeros({2, 60, 22, 4}),
               conditioning = contact_conditioning(2, false, false);
  const auto joints = [&](ArticulatedNetwork& network, uint64_t seed) {
    torch::manual_seed(seed);
    return forecast_joints(network->forward(past, none, conditioning), 0);
  };
  c.training.dropout = 0.5;
  ArticulatedNetwork dropping = stirred(c);
  const Tensor whole = joints(dropping, 1);
  EXPECT_TRUE(torch::equal(whole, joints(dropping, 2)));
  dropping->train();
  EXPECT_GT(largest_difference(whole, joints(dropping, 1)), 1e-3);
  EXPECT_GT(largest_difference(joints(dropping, 1), joints(dropping, 2)), 1e-3);
  EXPECT_TRUE(torch::equal(joints(dropping, 1), joints(dropping, 1))) << "of the same seed";
  c.training.dropout = 0;
  ArticulatedNetwork keeping = stirred(c);
  keeping->train();
  EXPECT_TRUE(torch::equal(whole, joints(keeping, 1)));
}

TEST(ArticulatedNetwork, IsToldWhatItsContactPointsAre) {
  torch::NoGradGuard no_grad;
  const Config c = small_articulated();
  const ArticulatedNetwork network = stirred(c);
  Networks model;
  model.config = c;
  model.articulated = network;
  torch::manual_seed(1);
  const Tensor past = some_past(), points = torch::rand({2, 60, 22, 4});
  const Tensor real = motion_of(model, Contacts::real)(past, points);
  EXPECT_GT(largest_difference(real, motion_of(model, Contacts::predicted)(past, points)), 1e-4);
  EXPECT_TRUE(torch::equal(motion_of(model, Contacts::none)(past, points), motion_of(model, Contacts::none)(past, {})));
  EXPECT_THROW(model.articulated->forward(past.slice(1, 1), points, contact_conditioning(2, true, true)), Error);
}

TEST(ArticulatedNetwork, IsWrittenAndReadAgain) {
  torch::NoGradGuard no_grad;
  const TempFolder folder;
  Networks model;
  model.config = small_articulated();
  model.articulated = stirred(model.config);
  save_networks(folder / "model.safetensors", model);
  const Networks read = load_networks(folder / "model.safetensors");
  EXPECT_EQ(read.config, model.config);
  const Tensor past = some_past(), points = torch::rand({2, 60, 22, 4});
  EXPECT_LT(largest_difference(motion_of(read, Contacts::predicted)(past, points),
                               motion_of(model, Contacts::predicted)(past, points)),
            1e-6);
}

TEST(ArticulatedLosses, AreDistancesWithClosedForms) {
  Config c = small_articulated();
  c.training.root_weight = 2;
  c.training.pose_weight = 3;
  c.training.contact_weight = 5;
  c.training.velocity_weight = 7;
  torch::manual_seed(2);
  const Tensor last = torch::randn({2, 22, 3}), future = torch::randn({2, 60, 22, 3});
  Tensor touched = torch::zeros({2, 60, 22, 4});
  touched.select(2, 7) = torch::cat({future.select(2, 7), torch::ones({2, 60, 1})}, 2);
  // Root 3 cm beside where it was, all other joints 4 cm above theirs relative to it.
  const Tensor aside = torch::tensor({0.03F, 0.F, 0.F}), up = torch::tensor({0.F, 0.04F, 0.F});
  const Tensor path = future.select(2, 0) + aside;
  Tensor local = future - future.slice(2, 0, 1) + up;
  const MotionForecast f{torch::cat({torch::zeros({2, 30, 3}), path}, 1), local};
  const ArticulatedLosses l = articulated_losses(f, last, future, touched, c);
  EXPECT_NEAR(l.path.item<double>(), 0.03, 1e-5);
  EXPECT_NEAR(l.pose.item<double>(), 0.04, 1e-5);
  EXPECT_NEAR(l.contact.item<double>(), 0.0025 / 22, 1e-7);  // 5 cm from the point that one of 22 joints touches
  EXPECT_NEAR(l.velocity.item<double>(), (0.03 + 21 * 0.05) / 22 / 60 + 1e-5, 2e-5);  // the first step alone
  EXPECT_NEAR(l.total.item<double>(),
              2 * 0.03 + 3 * 0.04 + 5 * l.contact.item<double>() + 7 * l.velocity.item<double>(), 1e-5);
}

TEST(ArticulatedLosses, HaveGradientsThatDifferencesConfirm) {
  const Config c = small_articulated();
  ArticulatedNetwork network = stirred(c);
  const Tensor past = some_past(), points = torch::rand({2, 60, 22, 4}), future = torch::randn({2, 60, 22, 3});
  const auto loss = [&] {
    return articulated_losses(network->forward(past, points, contact_conditioning(2, true, false)), past.select(1, 29),
                              future, points, c)
        .total;
  };
  loss().backward();
  torch::NoGradGuard no_grad;
  for (const Tensor& weights : {network->out->bias, network->motion_in->weight, network->blocks[0].tokens->weight}) {
    const Tensor direction = weights.grad() / weights.grad().norm();
    const double step = 2e-3;
    weights.add_(direction, step);
    const double above = loss().item<double>();
    weights.sub_(direction, 2 * step);
    const double below = loss().item<double>();
    weights.add_(direction, step);
    EXPECT_NEAR((above - below) / (2 * step), weights.grad().norm().item<double>(),
                0.05 * weights.grad().norm().item<double>() + 1e-3);
  }
}

TEST(Augmentation, MirrorsJointsAndContactPointsAlike) {
  const Tensor joints = some_past()[0].slice(0, 0, 5);
  const Tensor contacts = torch::cat({joints, torch::ones({5, 22, 1})}, 2);
  std::mt19937_64 random(1);
  Augmentation moved = draw_augmentation(preset("compact"), random);
  for (const bool mirror : {false, true}) {
    moved.mirror = mirror;
    const Tensor image = moved.joints(joints);
    const Tensor expected = torch::matmul(mirror ? mirrored_joints(joints) : joints, moved.rotation.t());
    EXPECT_LT(largest_difference(image, expected), 1e-5);
    EXPECT_LT(largest_difference(moved.contacts(contacts).slice(2, 0, 3), image), 1e-6);
    EXPECT_EQ(moved.contacts(torch::zeros({5, 22, 4})).abs().sum().item<double>(), 0);
  }
}

TEST(Augmentation, MakesPersonAndContactPointsLargerAlike) {
  const Tensor joints = some_past()[0].slice(0, 0, 5);
  const Augmentation moved{torch::eye(3), torch::zeros({3}), false, 1.25};
  EXPECT_LT(largest_difference(moved.joints(joints), joints * 1.25), 1e-6);
  const Tensor contacts = torch::cat({joints, torch::ones({5, 22, 1})}, 2), larger = moved.contacts(contacts);
  EXPECT_LT(largest_difference(larger.slice(2, 0, 3), joints * 1.25), 1e-6);
  EXPECT_EQ(larger.select(2, 3).min().item<double>(), 1);  // a flag stays one
}

TEST(MotionBatch, SeesPeopleOfOtherSizesWithinTheSetting) {
  const TempFolder folder;
  Config c = preset("compact");
  c.training.mirror = false;
  const Data data({write_walkers(folder / "walkers", 30, 1)}, "train", c, 5);
  std::vector<int64_t> windows(static_cast<size_t>(data.size()));
  std::iota(windows.begin(), windows.end(), 0);
  const auto hip_widths = [&](double stature) {
    c.training.stature = stature;
    const Tensor past = motion_batch(data, c, windows, no_contacts(c), 0, 3).past;
    return (past.select(2, 1) - past.select(2, 2)).norm(2, {-1}).select(1, 0);
  };
  const Tensor plain = hip_widths(0), ratio = hip_widths(0.2) / plain;
  EXPECT_GT(ratio.max().item<double>(), 1.05);
  EXPECT_LT(ratio.max().item<double>(), 1.2001);
  EXPECT_LT(ratio.min().item<double>(), 0.95);
  EXPECT_GT(ratio.min().item<double>(), 0.7999);
}

// What is predicted of a window is kept by its number, which must tell its paces apart.
TEST(MotionBatch, SeesRecordingsAtFivePaces) {
  const TempFolder folder;
  Config c = preset("compact");
  c.training.mirror = false;
  c.training.time_warp = 0.21;
  const auto distances = [&](const std::string& source) {
    const Data data({write_walkers(folder / ("walkers" + source), 30, 0, source)}, "train", c, 5);
    std::map<int64_t, double> out;  // travelled a second, by the number of the window and its pace
    for (uint64_t seed = 0; seed < 30; ++seed) {
      const ContactSource none = no_contacts(c);
      const ContactSource noted = [&](int64_t place, int64_t window, const Sample& s, uint64_t draw) {
        const double travelled = (s.joints[89][0] - s.joints[59][0]).norm().item<double>();
        EXPECT_NEAR(out.try_emplace(window, travelled).first->second, travelled, 1e-6);
        return none(place, window, s, draw);
      };
      motion_batch(data, c, {1}, noted, 0, seed);
    }
    return out;
  };
  std::vector<double> paces;
  for (const auto& [window, travelled] : distances("recording")) paces.push_back(travelled / 1.2);
  EXPECT_THAT(paces, testing::ElementsAre(testing::DoubleNear(1 / 1.21, 0.01), testing::DoubleNear(1 / 1.1, 0.01),
                                          testing::DoubleNear(1, 0.01), testing::DoubleNear(1.1, 0.01),
                                          testing::DoubleNear(1.21, 0.01)));
  EXPECT_EQ(distances("").size(), 1) << "generated people go as they were made to";
}

TEST(MotionBatch, SeesHalfOfItsWindowsInAMirrorWithTheirContacts) {
  const TempFolder folder;
  Config c = preset("compact");
  const Data data({write_walkers(folder / "walkers", 30, 1)}, "train", c, 5);
  std::vector<int64_t> windows(static_cast<size_t>(data.size()));
  std::iota(windows.begin(), windows.end(), 0);
  const auto left_is_left = [](const MotionBatch& b) {  // the left hip is at +x of who faces +Z, mirrored or not
    return b.past.select(1, 29).select(1, 1).select(1, 0).min().item<double>() > 0.05;
  };
  const auto batch = [&](bool mirror) {
    c.training.mirror = mirror;
    return motion_batch(data, c, windows, true_contacts(c), 0, 3, /*truth=*/true);
  };
  const MotionBatch plain = batch(false), mirrored = batch(true);
  EXPECT_TRUE(left_is_left(plain) && left_is_left(mirrored));
  int64_t changed = 0;
  for (int64_t i = 0; i < data.size(); ++i)
    changed += largest_difference(plain.past[i], mirrored.past[i]) > 1e-3 ? 1 : 0;
  EXPECT_GT(changed, 0);
  EXPECT_LT(changed, data.size());
  EXPECT_TRUE(torch::equal(mirrored.contacts, mirrored.truth));
  const Tensor apart = (mirrored.truth.slice(3, 0, 3) - mirrored.future).norm(2, {-1}) * mirrored.truth.select(3, 3);
  EXPECT_LT(apart.max().item<double>(), 0.31);  // contacts stay within 0.3 m of their joints
  EXPECT_GT(mirrored.truth.select(3, 3).sum().item<double>(), 0);
}

}  // namespace
}  // namespace inhabit::forecast
