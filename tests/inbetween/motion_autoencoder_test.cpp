// Protects the features that the Frechet distance of in-betweening is taken over: they do not know where and which way
// a motion goes, they are learned, they tell motions apart, and their file is checked.
#include "inhabit/inbetween/motion_autoencoder.h"

#include <gmock/gmock.h>

#include "inbetween/windows_of.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/math/rotation.h"
#include "inhabit/metrics/frechet.h"
#include "inhabit/nn/parameters.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::inbetween {
namespace {

using testing::HasSubstr;
using torch::Tensor;

/// As run_stages() writes it.
void save_autoencoder(const std::string& path, const MotionAutoencoder& network) {
  SafeTensors content = motion_autoencoder_header();
  nn::collect_parameters(*network, "", content);
  write_safetensors(path, content);
}

TEST(MotionChannels, AreThoseOfTheWindowInItsOwnFrame) {
  const Tensor joints = walker(121, 1.2, 0.7, 0.5, 3, -2).joints.unsqueeze(0);
  const Tensor channels = motion_channels(joints);
  ASSERT_EQ(channels.sizes(), (torch::IntArrayRef{1, 154, 121}));
  // The root: 1.2 m/s straight ahead, at its own height.
  EXPECT_TRUE(channels[0][0].allclose(torch::zeros({121}), 0, 1e-4));
  EXPECT_TRUE(channels[0][1].allclose(joints[0].select(1, 0).select(1, 1), 0, 1e-5));
  EXPECT_TRUE(channels[0][2].allclose(torch::arange(121) * 0.04, 0, 1e-4));
  EXPECT_EQ(channels[0].slice(0, 66).select(1, 0).abs().max().item<float>(), 0);         // no step into the first
  EXPECT_TRUE(channels[0][68].slice(0, 1).allclose(torch::full({120}, 0.04), 0, 1e-4));  // the root's step ahead
  const Tensor knee = (joints[0].select(1, 4) - joints[0].select(1, 0)).norm(2, {1});    // joint 4: rows 12 to 15
  EXPECT_TRUE(channels[0].slice(0, 12, 15).norm(2, {0}).allclose(knee, 0, 1e-4));
  // Who hops once by 3 cm changes every joint's step by that, by twice that, and by that.
  Tensor hop = walker(121, 0).joints.unsqueeze(0).clone();
  hop.select(1, 50).select(2, 1).add_(0.03);
  const Tensor changes = motion_channels(hop)[0].slice(0, 132);
  EXPECT_NEAR(changes[7][50].item<float>(), 0.03, 1e-5);
  EXPECT_NEAR(changes[7][51].item<float>(), 0.06, 1e-5);
  EXPECT_NEAR(changes[7][52].item<float>(), 0.03, 1e-5);
  EXPECT_NEAR(changes.sum().item<float>(), 22 * 0.12, 1e-3);
  // Elsewhere, facing another way: the same.
  const Tensor moved = torch::matmul(joints, yaw_matrix(2.0).t()) + torch::tensor({4.F, 0.F, 1.F});
  EXPECT_TRUE(motion_channels(moved).allclose(channels, 0, 1e-4));
  EXPECT_FALSE(motion_channels(joints + torch::tensor({0.F, 0.2F, 0.F})).allclose(channels, 0, 1e-2));
}

TEST(MotionAutoencoder, LearnsToReconstructAndItsFileGivesTheSameFeatures) {
  const TempFolder folder;
  torch::manual_seed(2);
  MotionAutoencoder network;
  const Tensor train_joints = joints_of(walking_windows(32, 1)), validation = joints_of(walking_windows(12, 2));
  TrainTask task = motion_autoencoder_task(network, train_joints, validation);
  EXPECT_EQ(task.samples, 32);
  {
    const torch::NoGradGuard no_gradients;
    const Tensor seen = network->standardised(train_joints);
    ASSERT_EQ(seen.sizes(), (torch::IntArrayRef{32, 154, 121}));
    EXPECT_TRUE(seen.mean(torch::IntArrayRef{0, 2}).allclose(torch::zeros({154}), 0, 1e-3));
    EXPECT_NEAR(seen.select(1, 2).std(/*unbiased=*/false).item<double>(), 1, 1e-3) << "the root ahead";
    const Tensor again = seen * network->deviation.unsqueeze(1) + network->mean.unsqueeze(1);
    EXPECT_TRUE(again.allclose(motion_channels(train_joints), 0, 1e-5));
  }
  network->eval();
  double before = 0;
  {
    const torch::NoGradGuard no_gradients;
    before = task.validate();
  }
  task.on_best = [&] { save_autoencoder(folder / "features.safetensors", network); };
  TrainOptions options;
  options.steps = 40;
  options.batch = 16;
  options.learning_rate = 2e-3;
  options.validate_every = 40;
  options.checkpoint = folder / "checkpoint.safetensors";
  options.log = folder / "log.jsonl";
  const TrainResult result = train(task, options);
  EXPECT_GT(before, 0.5);
  EXPECT_LT(result.best, 0.5 * before);

  MotionAutoencoder loaded = load_motion_autoencoder(folder / "features.safetensors");
  network->eval();
  const Tensor features = motion_features(loaded, validation);
  ASSERT_EQ(features.sizes(), (torch::IntArrayRef{12, kMotionFeatures}));
  EXPECT_TRUE(features.allclose(motion_features(network, validation)));
  // Motion of the kind it was trained on is nearer to it than the same motion shaken by 2 cm.
  const FeatureGaussian real = feature_gaussian(motion_features(loaded, train_joints));
  const auto distance = [&](const Tensor& joints) {
    return frechet_distance(real, feature_gaussian(motion_features(loaded, joints)));
  };
  torch::manual_seed(3);
  const Tensor shaken = train_joints + 0.02 * torch::randn_like(train_joints);
  EXPECT_LT(10 * distance(train_joints), distance(shaken));
}

TEST(MotionAutoencoder, RefusesWhatIsNoWindowAndFilesThatAreNoAutoencoder) {
  const TempFolder folder;
  MotionAutoencoder network;
  EXPECT_THAT(refusal_of([&] { motion_features(network, torch::zeros({2, 120, 22, 3})); }), HasSubstr("121 frames"));
  EXPECT_THAT(refusal_of([&] {
                motion_features(network, torch::full({1, 121, 22, 3}, NAN));
              }),
              HasSubstr("not finite"));
  const Tensor some = joints_of(walking_windows(2));
  EXPECT_THAT(refusal_of([&] { motion_autoencoder_task(network, some, torch::Tensor()); }), HasSubstr("validation"));
  EXPECT_THAT(refusal_of([&] { motion_autoencoder_task(network, some.slice(0, 0, 0), some); }), HasSubstr("training"));
  const std::string path = folder / "other.safetensors";
  SafeTensors other;
  other.tensors["weight"] = torch::zeros({2});
  write_safetensors(path, other);
  EXPECT_THAT(refusal_of([&] { load_motion_autoencoder(path); }), HasSubstr("is not a model of motion-autoencoder"));
  save_autoencoder(path, network);
  SafeTensors damaged = read_safetensors(path);
  damaged.tensors["deviation"][3] = 0;
  write_safetensors(path, damaged);
  EXPECT_THAT(refusal_of([&] { load_motion_autoencoder(path); }), HasSubstr("not positive"));
  damaged.tensors.erase("deviation");
  write_safetensors(path, damaged);
  EXPECT_THAT(refusal_of([&] { load_motion_autoencoder(path); }), HasSubstr("lacks"));
}

}  // namespace
}  // namespace inhabit::inbetween
