// Networks against reference outputs in safetensors files: inputs, weights under their released names, outputs, sizes
// in the metadata. INHABIT_PARITY_DIR names another folder than the bundled one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "inhabit/anticipate/released_networks.h"
#include "inhabit/forecast/fast_contact_network.h"
#include "inhabit/forecast/fast_motion_network.h"
#include "inhabit/forecast/features.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/forecast/network.h"
#include "inhabit/inbetween/fast_denoiser.h"
#include "inhabit/inbetween/model_file.h"
#include "inhabit/inbetween/sampler.h"
#include "inhabit/interact/fast_control_network.h"
#include "inhabit/interact/fast_pose_network.h"
#include "inhabit/interact/model_file.h"
#include "inhabit/io/expmap_text.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/metrics/ndms.h"
#include "inhabit/metrics/npss.h"
#include "inhabit/nn/parameters.h"
#include "temp_folder.h"

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

/// A tensor with `dims` dimensions of a sample and one of the batch before them, which files of one sample may lack.
Tensor batch_of(const SafeTensors& content, const std::string& name, int64_t dims) {
  const Tensor t = tensor(content, name);
  return t.dim() == dims ? t.unsqueeze(0) : t;
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

  const auto expected = [&](const char* name, int64_t dims) { return batch_of(content, name, dims); };
  const Tensor scene = batch_of(content, "in.scene", 2);
  const Tensor past = batch_of(content, "in.motion", 3).slice(1, 0, config.past);
  const Tensor dct_in = forecast::contact_features(scene, past, config);
  expect_close(dct_in, expected("out.contact_dct_in", 2), "contact DCT in");
  const Tensor dct_out = contact->forward(scene, dct_in, past);
  expect_close(dct_out, expected("out.contact_dct", 2), "contact DCT out");
  const Tensor points = forecast::contact_points(scene, dct_out, config);
  expect_close(points, expected("out.contact_points", 3), "contact points");
  const forecast::MotionForecast forecast = motion->forward(past, points);
  expect_close(forecast.root_path, expected("out.root_path", 2), "root path");
  expect_close(forecast.local, expected("out.local_pose", 3), "local poses");

  const Tensor fast_dct = forecast::FastContactNetwork(contact).forward(scene, dct_in, past);
  expect_close(fast_dct, expected("out.contact_dct", 2), "contact DCT out, fast");
  const forecast::MotionForecast fast = forecast::FastMotionNetwork(motion).forward(past, points);
  expect_close(fast.root_path, expected("out.root_path", 2), "root path, fast");
  expect_close(fast.local, expected("out.local_pose", 3), "local poses, fast");
}

void check_kinematics(ExpmapSkeleton skeleton, const SafeTensors& content) {
  const Tensor channels = batch_of(content, "in.expmap", 2), joints = batch_of(content, "out.joints", 3);
  for (int64_t b = 0; b < channels.size(0); ++b)
    expect_close(expmap_joint_positions(skeleton, channels[b]), joints[b], "joints");
}
void check_cmu_kinematics(const std::string&, const SafeTensors& content) {
  check_kinematics(ExpmapSkeleton::cmu, content);
}
void check_h36m_kinematics(const std::string&, const SafeTensors& content) {
  check_kinematics(ExpmapSkeleton::h36m, content);
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
  expect_close(plausibility(query, database, NdmsForm::package), tensor(content, "out.framewise_ndms"),
               "NDMS by frame");
  const double score = npss(tensor(content, "in.npss_truth"), tensor(content, "in.npss_forecast"), NpssForm::real_part);
  expect_close(torch::tensor({score}, torch::kFloat64), tensor(content, "out.npss"), "NPSS");
}

/// What the in-betweening files give of a clip, and the guided denoiser over it.
struct InbetweenCase {
  inbetween::Denoiser network;
  inbetween::KeyConstraints given;
  Tensor mask, local, scene, shape;

  InbetweenCase(const inbetween::Networks& networks, const SafeTensors& content) : network(networks.network) {
    const Tensor keys = tensor(content, "in.keyframe_mask");
    mask = keys.unsqueeze(1);
    given = {tensor(content, "in.keyframes"), mask.expand({keys.size(0), inbetween::kFeatureCount, keys.size(1)}),
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
  const Tensor imputed = inbetween::impute(x, c.given, step), expected = tensor(content, "out.x0_guided_w2.5");
  for (int64_t b = 0; b < x.size(0); ++b) {  // a step of its own each
    const auto own = [&](const Tensor& t) { return t.slice(0, b, b + 1); };
    expect_close(fast.guided(own(imputed), own(c.mask), own(c.local), step[b].item<int64_t>(), own(c.scene),
                             own(c.shape), c.network->config.inference.guidance),
                 own(expected), "guided, fast");
  }
  if ((step == step[0]).all().item<bool>())
    expect_close(fast.guided(imputed, c.mask, c.local, step[0].item<int64_t>(), c.scene, c.shape,
                             c.network->config.inference.guidance),
                 expected, "guided, fast, all at once");
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
  const Tensor noise = tensor(content, "in.noise");  // (T + 1, F, N), or (T + 1, B, F, N)
  const Tensor expected = tensor(content, "out.sample");
  Tensor last;  // the release leaves the ends as the last evaluation has them; ours takes them from the keys
  const Tensor got = sample(
      schedule, inbetween::Sampler::ddpm, schedule.steps(),
      [&](const Tensor& x, int64_t t) { return last = c.guided(x, torch::full({x.size(0)}, t, torch::kInt64)); },
      c.given, [&](int64_t number) { return noise.dim() == 3 ? noise[number].unsqueeze(0) : noise[number]; });
  expect_close(last, expected, "last evaluation of the loop");
  expect_close(got.slice(2, 1, -1), expected.slice(2, 1, -1), "sample, inside");
  EXPECT_TRUE(torch::equal(got.select(2, 0), c.given.values.select(2, 0))) << "the first key holds";
}

void check_chair_posenet(const std::string& path, const SafeTensors& content) {
  torch::NoGradGuard no_gradients;
  interact::PoseNetwork network = interact::load_networks(path).pose;
  const Tensor x = tensor(content, "in.x");
  expect_close(network->gates(x), tensor(content, "out.gating"), "gating");
  expect_close(network->forward(x), tensor(content, "out.y"), "frame");
  expect_close(interact::FastPoseNetwork(network).forward(x), tensor(content, "out.y"), "frame, fast");
}

void check_chair_controlnet(const std::string& path, const SafeTensors& content) {
  torch::NoGradGuard no_gradients;
  const interact::Networks networks = interact::load_networks(path);
  interact::ControlNetwork network = networks.control;
  const Tensor x = tensor(content, "in.x");
  const int64_t pose = networks.config.pose_size();
  interact::ControlState state = network->start(x.size(1));
  expect_close(network->forward(x.slice(2, 0, pose), x.slice(2, pose), state), tensor(content, "out.y"), "control");
  expect_close(state.hidden, tensor(content, "out.h"), "state");
  expect_close(state.cell, tensor(content, "out.c"), "cell");

  const interact::FastControlNetwork fast(network);
  interact::FastControlNetwork::Workspace workspace;
  const int64_t people = x.size(1);
  Tensor carried = torch::empty({people, fast.state_size()}), y = torch::empty({x.size(0), people, x.size(2) - pose});
  for (int64_t i = 0; i < people; ++i) fast.start(carried[i].data_ptr<float>());
  for (int64_t t = 0; t < x.size(0); ++t) {
    const Tensor now = x[t].slice(1, 0, pose).contiguous(), control = x[t].slice(1, pose).contiguous();
    fast.step(now.data_ptr<float>(), control.data_ptr<float>(), people, carried.data_ptr<float>(),
              y[t].data_ptr<float>(), workspace);
  }
  expect_close(y, tensor(content, "out.y"), "control, fast");
}

void check_chair_contactnet(const std::string& path, const SafeTensors& content) {
  torch::NoGradGuard no_gradients;
  interact::ContactNetwork network = interact::load_networks(path).contact;
  const Tensor chair = tensor(content, "in.condition");
  const nn::LatentDistribution q = network->encode(tensor(content, "in.contacts"), chair);
  expect_close(q.mean, tensor(content, "out.mean"), "mean");
  expect_close(q.log_variance, tensor(content, "out.log_variance"), "log variance");
  expect_close(network->decode(tensor(content, "in.z"), chair), tensor(content, "out.contacts"), "contacts");
}

void check_intention_networks(const std::string& path, const SafeTensors& content) {
  torch::NoGradGuard no_gradients;
  const auto size = [&](const char* name) { return std::stoi(content.metadata.at(name)); };
  anticipate::Config c;
  c.hidden = size("hidden");
  c.noise = size("noise");
  c.labels = size("labels");
  c.intention_features = size("embedding");
  c.gamma = size("ahead");
  c.intention_hidden = size("label_hidden");
  anticipate::ReleasedPoseNetwork pose(c, size("dim"));
  nn::load_parameters(*pose, "", content, path);
  const int frames = size("n_out");
  const Tensor labels = tensor(content, "in.labels").slice(1, 0, pose->kPast + frames + c.gamma - 1);
  expect_close(pose->forward(tensor(content, "in.past"), tensor(content, "in.noise"), labels, frames),
               tensor(content, "out.poses"), "poses");
  anticipate::ReleasedIntentionNetwork label(c, size("dim"));
  nn::load_parameters(*label, "label_rnn.", content, path);
  const Tensor logits = label->forward(tensor(content, "in.label_past"));
  expect_close(logits, tensor(content, "out.label_logits"), "label logits");
  expect_close(logits.softmax(2), tensor(content, "out.label_probabilities"), "label probabilities");
  anticipate::LabelAutoencoder cluster(size("cluster_hidden"), size("cluster_code"));
  nn::load_parameters(*cluster, "cluster.", content, path);
  const Tensor code = cluster->encode(tensor(content, "in.cluster_poses"));
  expect_close(code, tensor(content, "out.cluster_code"), "cluster code");
  expect_close(cluster->decode(code), tensor(content, "out.cluster_poses"), "cluster poses");
}

using Check = void (*)(const std::string& path, const SafeTensors& content);

/// What checks a file, told by its name; none for files of other systems.
Check check_for(const std::string& name) {
  if (name.rfind("contact_forecast", 0) == 0) return check_contact_forecast;
  if (name.rfind("cmu_forward_kinematics", 0) == 0) return check_cmu_kinematics;
  if (name.rfind("h36m_forward_kinematics", 0) == 0) return check_h36m_kinematics;
  if (name.rfind("motion_scores", 0) == 0) return check_motion_scores;
  if (name.rfind("intention_networks", 0) == 0) return check_intention_networks;
  if (name.rfind("inbetween_denoiser", 0) == 0) return check_inbetween_denoiser;
  if (name.rfind("inbetween_sampler", 0) == 0) return check_inbetween_sampler;
  if (name.rfind("chair_posenet", 0) == 0) return check_chair_posenet;
  if (name.rfind("chair_controlnet", 0) == 0) return check_chair_controlnet;
  if (name.rfind("chair_contactnet", 0) == 0) return check_chair_contactnet;
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

/// The reference files have one sample; those that others make may have any number.
TEST(Parity, FilesMayHoldAnyBatch) {
  const TempFolder folder;
  for (const char* name : {"contact_forecast", "inbetween_denoiser", "inbetween_sampler", "cmu_forward_kinematics"}) {
    const std::string path = parity_folder() / (std::string(name) + ".safetensors");
    if (!std::filesystem::exists(path)) continue;
    SafeTensors content = read_safetensors(path);
    const bool has_batch = std::string(name).rfind("inbetween", 0) == 0;
    for (auto& [key, value] : content.tensors) {
      if (key.rfind("in.", 0) != 0 && key.rfind("out.", 0) != 0) continue;
      if (key == "in.noise")
        value = torch::stack({value, value}, 1);
      else
        value = has_batch ? torch::cat({value, value}) : torch::stack({value, value});
    }
    const std::string doubled = folder / (std::string(name) + ".safetensors");
    write_safetensors(doubled, content);
    SCOPED_TRACE(doubled);
    check_for(name)(doubled, read_safetensors(doubled));
  }
}

/// The chair networks' batches are of several samples: one of them alone, and all twice.
TEST(Parity, ChairNetworksTakeAnyBatch) {
  const TempFolder folder;
  for (const char* name : {"chair_posenet", "chair_controlnet", "chair_contactnet"}) {
    const std::string path = parity_folder() / (std::string(name) + ".safetensors");
    if (!std::filesystem::exists(path)) continue;
    const SafeTensors content = read_safetensors(path);
    SCOPED_TRACE(name);
    const int64_t axis = std::string(name) == "chair_controlnet" ? 1 : 0;
    for (const bool doubled : {false, true}) {
      SafeTensors other = content;
      for (auto& [key, value] : other.tensors) {
        if (key.rfind("in.", 0) != 0 && key.rfind("out.", 0) != 0) continue;
        value = doubled ? torch::cat({value, value}, axis) : value.narrow(axis, 1, 1).contiguous();
      }
      const std::string changed = folder / (std::string(name) + ".safetensors");
      write_safetensors(changed, other);
      check_for(name)(changed, other);
    }
  }
}
