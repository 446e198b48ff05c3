// Networks against reference outputs in safetensors files: inputs, weights under their released names, outputs, sizes
// in the metadata. INHABIT_PARITY_DIR names another folder than the bundled one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/fast_motion_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/network.h"
#include "inhabit/inbetween/fast_denoiser.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/io/expmap_text.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/metrics/ndms.h"
#include "inhabit/metrics/npss.h"

using namespace inhabit;
using torch::Tensor;

namespace {

constexpr double kTolerance = 1e-4;  // relative to the largest output

std::filesystem::path parity_folder() {
  const char* named = std::getenv("INHABIT_PARITY_DIR");
  return named != nullptr ? named : INHABIT_SOURCE_DIR "/tests/data/parity";
}

const Tensor& tensor(const SafeTensors& content, const std::string& name) {
  const auto found = content.tensors.find(name);
  if (found == content.tensors.end()) throw std::runtime_error("lacks " + name);
  return found->second;
}

void expect_close(const Tensor& got, const Tensor& expected, const std::string& what) {
  ASSERT_EQ(got.sizes(), expected.sizes()) << what;
  const double largest = std::max(expected.abs().max().item<double>(), 1e-12);
  const double error = (got - expected).abs().max().item<double>() / largest;
  std::cout << "  " << what << ": largest difference " << error << " of the largest output\n";
  EXPECT_LT(error, kTolerance) << what;
}

void check_contact_forecast(const std::string& path, const SafeTensors& content) {
  const forecast::Networks networks = forecast::load_networks(path);
  forecast::ContactNetwork contact = networks.contact;
  forecast::MotionNetwork motion = networks.motion;
  ASSERT_FALSE(contact.is_empty());
  ASSERT_FALSE(motion.is_empty());
  const forecast::Config& config = networks.config;
  torch::NoGradGuard no_gradients;

  const Tensor scene = tensor(content, "in.scene").unsqueeze(0);
  const Tensor past = tensor(content, "in.motion").slice(0, 0, config.past).unsqueeze(0);
  const Tensor dct_in = forecast::contact_features(scene, past, config);
  expect_close(dct_in[0], tensor(content, "out.contact_dct_in"), "contact DCT in");
  const Tensor dct_out = contact->forward(scene, dct_in, past);
  expect_close(dct_out[0], tensor(content, "out.contact_dct"), "contact DCT out");
  const Tensor points = forecast::contact_points(scene, dct_out, config);
  expect_close(points[0], tensor(content, "out.contact_points"), "contact points");
  const forecast::MotionForecast forecast = motion->forward(past, points);
  expect_close(forecast.root_path[0], tensor(content, "out.root_path"), "root path");
  expect_close(forecast.local[0], tensor(content, "out.local_pose"), "local poses");

  const Tensor fast_dct = forecast::FastContactNetwork(contact).forward(scene, dct_in, past);
  expect_close(fast_dct[0], tensor(content, "out.contact_dct"), "contact DCT out, fast");
  const forecast::MotionForecast fast = forecast::FastMotionNetwork(motion).forward(past, points);
  expect_close(fast.root_path[0], tensor(content, "out.root_path"), "root path, fast");
  expect_close(fast.local[0], tensor(content, "out.local_pose"), "local poses, fast");
}

void check_cmu_kinematics(const std::string&, const SafeTensors& content) {
  expect_close(expmap_joint_positions(ExpmapSkeleton::cmu, tensor(content, "in.expmap")), tensor(content, "out.joints"),
               "joints");
}

void check_h36m_kinematics(const std::string&, const SafeTensors& content) {
  expect_close(expmap_joint_positions(ExpmapSkeleton::h36m, tensor(content, "in.expmap")),
               tensor(content, "out.joints"), "joints");
}

void check_motion_scores(const std::string& path, const SafeTensors& content) {
  const int64_t joints = std::stoll(content.metadata.at("joints")), kappa = std::stoll(content.metadata.at("kappa"));
  const auto words = [&](const Tensor& positions) { return motion_words(positions.view({-1, joints, 3}), kappa); };
  std::vector<Tensor> references;
  for (int64_t i = 0; i < std::stoll(content.metadata.at("sequences")); ++i)
    references.push_back(words(tensor(content, "in.reference." + std::to_string(i))));
  const WordIndex database(torch::cat(references));
  const Tensor query = words(tensor(content, "in.query"));
  EXPECT_TRUE(torch::equal(database.nearest(query), tensor(content, "out.nearest_word"))) << path << ": nearest word";
  expect_close(plausibility(query, database), tensor(content, "out.framewise_ndms"), "NDMS by frame");
  const double score = npss(tensor(content, "in.npss_truth"), tensor(content, "in.npss_forecast"));
  expect_close(torch::tensor({score}, torch::kFloat64), tensor(content, "out.npss"), "NPSS");
}

/// What the in-betweening files give of a clip, and the guided denoiser over it.
struct InbetweenCase {
  inbetween::Denoiser network;
  inbetween::GivenFeatures given;
  Tensor mask, local, scene, shape;

  InbetweenCase(const inbetween::Networks& networks, const SafeTensors& content) : network(networks.network) {
    const Tensor keys = tensor(content, "in.keyframe_mask");
    mask = keys.unsqueeze(1);
    given = {tensor(content, "in.keyframes"), mask.expand({1, inbetween::kFeatureCount, keys.size(1)}),
             networks.config.t_star};
    local = network->embed_offsets(tensor(content, "in.bps"), keys);
    scene = network->embed_scene(tensor(content, "in.occupancy"));
    shape = network->embed_shape(tensor(content, "in.body_shape"));
  }
  Tensor denoised(const Tensor& x, const Tensor& step, bool with_scene) {
    return network->forward(inbetween::impute(x, given, step), mask, local, step, with_scene ? scene + shape : shape);
  }
  Tensor guided(const Tensor& x, const Tensor& step) {
    const Tensor without = denoised(x, step, false);
    return without + network->config.inference.guidance * (denoised(x, step, true) - without);
  }
};

void check_inbetween_denoiser(const std::string& path, const SafeTensors& content) {
  torch::NoGradGuard no_gradients;
  InbetweenCase c(inbetween::load_networks(path), content);
  const Tensor x = tensor(content, "in.x_t"), step = tensor(content, "in.timestep");
  expect_close(c.denoised(x, step, true), tensor(content, "out.x0_cond"), "with the scene");
  expect_close(c.denoised(x, step, false), tensor(content, "out.x0_uncond"), "without");
  expect_close(c.guided(x, step), tensor(content, "out.x0_guided_w2.5"), "guided");
  inbetween::FastDenoiser fast(c.network);
  expect_close(fast.guided(inbetween::impute(x, c.given, step), c.mask, c.local, step.item<int64_t>(), c.scene, c.shape,
                           c.network->config.inference.guidance),
               tensor(content, "out.x0_guided_w2.5"), "guided, fast");
}

void check_inbetween_sampler(const std::string& path, const SafeTensors& content) {
  torch::NoGradGuard no_gradients;
  InbetweenCase c(inbetween::load_networks(path), content);
  const inbetween::DiffusionSchedule schedule = inbetween::cosine_schedule(c.network->config.diffusion_steps);
  for (const auto& [name, values] : {std::pair("betas", schedule.betas),
                                     {"alphas_cumprod", schedule.alphas_cumprod},
                                     {"posterior_variance", schedule.posterior_variance},
                                     {"posterior_mean_coef_x0", schedule.posterior_mean_x0},
                                     {"posterior_mean_coef_xt", schedule.posterior_mean_xt}})
    expect_close(torch::tensor(values, torch::kFloat64), tensor(content, name), name);
  const Tensor noise = tensor(content, "in.noise"), expected = tensor(content, "out.sample");
  Tensor last;  // the release leaves the ends as the last evaluation has them; ours takes them from the keys
  const Tensor got = sample(
      schedule, inbetween::Sampler::ddpm, schedule.steps(),
      [&](const Tensor& x, int64_t t) { return last = c.guided(x, torch::full({1}, t, torch::kInt64)); }, c.given,
      [&](int64_t number) { return noise[number].unsqueeze(0); });
  expect_close(last, expected, "last evaluation of the loop");
  expect_close(got.slice(2, 1, -1), expected.slice(2, 1, -1), "sample, inside");
  EXPECT_TRUE(torch::equal(got.select(2, 0), c.given.values.select(2, 0))) << "the first key holds";
}

using Check = void (*)(const std::string& path, const SafeTensors& content);

/// What checks a file, told by its name; none for files of other systems.
Check check_for(const std::string& name) {
  if (name.rfind("contact_forecast", 0) == 0) return check_contact_forecast;
  if (name.rfind("cmu_forward_kinematics", 0) == 0) return check_cmu_kinematics;
  if (name.rfind("h36m_forward_kinematics", 0) == 0) return check_h36m_kinematics;
  if (name.rfind("motion_scores", 0) == 0) return check_motion_scores;
  if (name.rfind("inbetween_denoiser", 0) == 0) return check_inbetween_denoiser;
  if (name.rfind("inbetween_sampler", 0) == 0) return check_inbetween_sampler;
  return nullptr;
}

}  // namespace

TEST(Parity, EveryKnownFileAgreesWithItsReference) {
  const std::filesystem::path folder = parity_folder();
  ASSERT_TRUE(std::filesystem::is_directory(folder)) << folder;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".safetensors") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  int checked = 0;
  for (const auto& file : files) {
    const std::string name = file.filename().string();
    const Check check = check_for(name);
    if (check == nullptr) {
      std::cout << name << ": skipped, nothing here knows it\n";
      continue;
    }
    SCOPED_TRACE(name);
    std::cout << name << "\n";
    ++checked;
    try {
      check(file.string(), read_safetensors(file.string()));
    } catch (const std::exception& e) {
      ADD_FAILURE() << name << ": " << e.what();
    }
  }
  EXPECT_GT(checked, 0) << folder << " has no file that is known here";
}
