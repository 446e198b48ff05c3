#include "inhabit/forecast/network.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/fast_motion_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/io/safetensors.h"
#include "largest.h"
#include "refusal_of.h"
#include "small_config.h"
#include "temp_folder.h"

using namespace inhabit;
using namespace inhabit::forecast;
using torch::Tensor;

namespace {

/// Batch norms with statistics as if trained.
void stir(torch::nn::Module& module) {
  torch::NoGradGuard no_gradients;
  for (auto& buffer : module.named_buffers()) {
    if (buffer.value().is_floating_point()) buffer.value().uniform_(0.5, 1.5);
  }
  for (auto& parameter : module.named_parameters()) {
    if (parameter.value().dim() == 1) parameter.value().uniform_(-1, 1);
  }
  module.eval();
}

Tensor some_past(const Config& config, int64_t batch) {
  return torch::randn({batch, 1, config.joints, 3}) * 0.4 +
         torch::cumsum(torch::randn({batch, config.past, config.joints, 3}) * 0.05, 1);
}

void expect_fast_equals_dense(const Tensor& scene, const std::string& what) {
  torch::NoGradGuard no_gradients;
  const Config config = small_forecast_config();
  ContactNetwork network(config);
  stir(*network);
  for (const auto& module : network->modules(false)) {
    if (auto* layer = module->as<nn::PointVoxelConvImpl>()) layer->dense = true;
  }
  FastContactNetwork fast(network);
  const Tensor past = some_past(config, scene.size(0));
  const Tensor contact = contact_features(scene, past, config);
  const Tensor expected = network->forward(scene, contact, past);
  const Tensor got = fast.forward(scene, contact, past);
  EXPECT_LT(largest_difference(got, expected) / (expected - contact).abs().max().item<double>(), 1e-4) << what;
  const Tensor other = torch::randn_like(contact);  // features everywhere; and workspaces used again
  EXPECT_LT(largest_difference(fast.forward(scene, other, past), network->forward(scene, other, past)), 1e-4) << what;
}

}  // namespace

TEST(LocalPose, GoesThereAndBack) {
  const Tensor joints = torch::randn({2, 4, 5, 3});
  const Tensor local = local_pose(joints, 2);
  EXPECT_TRUE(torch::equal(local.select(2, 2), joints.select(2, 2)));
  EXPECT_LT(largest_difference(local.select(2, 0), joints.select(2, 0) - joints.select(2, 2)), 1e-6);
  Tensor back = local + local.slice(2, 2, 3);
  back.select(2, 2).copy_(local.select(2, 2));
  EXPECT_LT(largest_difference(back, joints), 1e-6);
}

TEST(FastContactNetwork, EqualsTheDenseOneOnCloudsOfManyShapes) {
  torch::manual_seed(0);
  for (const int64_t points : {41, 64, 300, 1000})
    expect_fast_equals_dense(torch::randn({2, points, 3}), std::to_string(points) + " points");
  expect_fast_equals_dense(torch::randn({1, 200, 3}) * torch::tensor({1.0F, 0.0F, 1.0F}), "a plane");
  expect_fast_equals_dense(torch::randn({1, 100, 3}) + 50, "far from everybody");
  expect_fast_equals_dense(torch::randn({1, 3, 3}), "fewer points than centres");
}

TEST(FastContactNetwork, EqualsTheDenseOneWhereAllPointsAreOne) {
  expect_fast_equals_dense(torch::full({1, 50, 3}, 0.3F), "one place");
  expect_fast_equals_dense(torch::full({1, 1, 3}, 0.3F), "one point");
}

TEST(FastContactNetwork, EqualsTheDenseOneOnTheGridsBorder) {
  torch::manual_seed(1);
  Tensor corners = torch::randint(2, {1, 80, 3}).to(torch::kFloat32) * 2 - 1;  // of a cube, half of them on grid faces
  expect_fast_equals_dense(corners, "corners of a cube");
  Tensor axes = torch::zeros({1, 60, 3});
  for (int64_t i = 0; i < 60; ++i) axes[0][i][i % 3] = i % 2 == 0 ? 1.0F : -1.0F;  // at the faces' middles
  expect_fast_equals_dense(axes, "middles of the grid's faces");
}

TEST(FastContactNetwork, RefusesWrongShapes) {
  const Config config = small_forecast_config();
  ContactNetwork network(config);
  FastContactNetwork fast(network);
  const Tensor past = some_past(config, 1);
  EXPECT_THROW(fast.forward(torch::rand({1, 50, 2}), torch::rand({1, 20, 50}), past), Error);
  EXPECT_THROW(fast.forward(torch::rand({1, 50, 3}), torch::rand({1, 20, 49}), past), Error);
  EXPECT_THROW(network->forward(torch::rand({1, 50, 3}), torch::rand({1, 19, 50}), past), Error);
  EXPECT_THROW(network->forward(torch::rand({1, 50, 3}), torch::rand({1, 20, 50}), past.slice(1, 1)), Error);
}

TEST(FastMotionNetwork, EqualsThePlainOneInEveryForm) {
  torch::manual_seed(2);
  torch::NoGradGuard no_gradients;
  for (const bool from_past : {false, true}) {
    for (const bool with_contact : {false, true}) {
      Config config = small_forecast_config();
      config.decode_from_past = from_past;
      MotionNetwork network(config, with_contact);
      stir(*network);
      const Tensor past = some_past(config, 3);
      const Tensor points = with_contact ? torch::rand({3, config.future, config.joints, 4}) : Tensor();
      const MotionForecast expected = network->forward(past, points);
      const MotionForecast got = FastMotionNetwork(network).forward(past, points);
      EXPECT_LT(largest_difference(got.root_path, expected.root_path), 1e-5);
      EXPECT_LT(largest_difference(got.local, expected.local), 1e-5);
      EXPECT_EQ(forecast_joints(got, config.root).sizes(), torch::IntArrayRef({3, config.future, config.joints, 3}));
    }
  }
}

TEST(MotionNetwork, TheTwoDecodersDifferFromTheSecondFrameOn) {
  torch::manual_seed(3);
  torch::NoGradGuard no_gradients;
  Config config = small_forecast_config();
  MotionNetwork paper(config);
  stir(*paper);
  const Tensor past = some_past(config, 1), points = torch::rand({1, config.future, config.joints, 4});
  const Tensor recurrent = paper->forward(past, points).local;
  paper->config.decode_from_past = true;
  const Tensor released = paper->forward(past, points).local;
  EXPECT_EQ(largest_difference(recurrent.select(1, 0), released.select(1, 0)), 0);
  EXPECT_GT(largest_difference(recurrent.select(1, 1), released.select(1, 1)), 1e-6);
}

TEST(MotionNetwork, LearnsToGoWhereContactsAre) {
  torch::manual_seed(4);
  const Config config = small_forecast_config();
  MotionNetwork network(config);
  network->train();
  const Tensor past = some_past(config, 16), points = torch::rand({16, config.future, config.joints, 4});
  const Tensor target = points.select(2, 0).slice(2, 0, 3);
  torch::optim::Adam optimiser(network->parameters(), torch::optim::AdamOptions(5e-3));
  double first = 0, last = 0;
  for (int step = 0; step < 60; ++step) {
    optimiser.zero_grad();
    const Tensor loss = (network->forward(past, points).root_path.slice(1, config.past) - target).square().mean();
    loss.backward();
    optimiser.step();
    (step == 0 ? first : last) = loss.item<double>();
  }
  EXPECT_LT(last, 0.5 * first);
}

TEST(ModelFile, RoundTripsNetworksAndConfig) {
  torch::manual_seed(5);
  const TempFolder folder;
  const std::string path = folder / "model.safetensors";
  Networks networks;
  networks.config = small_forecast_config();
  networks.contact = ContactNetwork(networks.config);
  networks.no_contact = MotionNetwork(networks.config, false);
  stir(*networks.contact);
  save_networks(path, networks);
  const Networks back = load_networks(path);
  EXPECT_TRUE(back.config == networks.config);
  EXPECT_TRUE(back.motion.is_empty());
  ASSERT_FALSE(back.contact.is_empty());
  ASSERT_FALSE(back.no_contact.is_empty());
  EXPECT_FALSE(back.contact->is_training());
  const auto expected = networks.contact->named_parameters();
  for (const auto& item : back.contact->named_parameters())
    EXPECT_TRUE(torch::equal(item.value(), expected[item.key()])) << item.key();
  const auto buffers = networks.contact->named_buffers();
  for (const auto& item : back.contact->named_buffers()) {
    if (item.value().is_floating_point()) {
      EXPECT_TRUE(torch::equal(item.value(), buffers[item.key()])) << item.key();
    }
  }
  save_networks(path, networks, true);
  EXPECT_LT(largest_difference(load_networks(path).contact->x_enc->weight, networks.contact->x_enc->weight), 1e-3);
}

TEST(ModelFile, RefusesOtherSystemsAndDamagedFiles) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  const TempFolder folder;
  const std::string path = folder / "other.safetensors";
  const auto message = [&](const SafeTensors& content) {
    write_safetensors(path, content);
    return refusal_of([&] { return load_networks(path); });
  };
  EXPECT_THAT(message({{{"net.w", torch::ones(2)}}, {{"system", "scene-inbetween"}}}),
              AllOf(HasSubstr(path), HasSubstr("scene-inbetween")));
  EXPECT_THAT(message({{{"net.w", torch::ones(2)}}, {}}), HasSubstr("not a model"));
  EXPECT_THAT(message({{}, {{"system", "contact-forecast"}, {"config", to_json(small_forecast_config())}}}),
              HasSubstr("no network"));
  EXPECT_THAT(message({{}, {{"system", "contact-forecast"}, {"config", "{}"}}}), HasSubstr("malformed"));
  EXPECT_THAT(message({{{"motion_net.x", torch::ones(1)}},
                       {{"system", "contact-forecast"}, {"config", to_json(small_forecast_config())}}}),
              HasSubstr("lacks the parameter"));
  EXPECT_THAT(message({{{"contact_net.x", torch::ones(1)}}, {}}), HasSubstr("metadata lacks"));

  Networks networks;
  networks.config = small_forecast_config();
  networks.motion = MotionNetwork(networks.config);
  save_networks(path, networks);
  SafeTensors content = read_safetensors(path);
  content.tensors["motion_net.x_enc.bias"] = torch::zeros({3});
  EXPECT_THAT(message(content), AllOf(HasSubstr("motion_net.x_enc.bias"), HasSubstr("[3]")));
  content.tensors["motion_net.x_enc.bias"] = torch::full({16}, NAN);
  EXPECT_THAT(message(content), HasSubstr("not finite"));
}
