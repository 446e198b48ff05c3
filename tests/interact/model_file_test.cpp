// Protects model files of chair interaction: what was saved comes back, released files are read, and files of other
// systems or with damage are refused in one line that names them.
#include "inhabit/interact/model_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/nn/parameters.h"
#include "interact/small_networks.h"
#include "largest.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::interact {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using torch::Tensor;

void expect_same_parameters(const torch::nn::Module& a, const torch::nn::Module& b) {
  const auto left = a.named_parameters(), right = b.named_parameters();
  ASSERT_EQ(left.size(), right.size());
  for (const auto& item : left) EXPECT_TRUE(torch::equal(item.value(), right[item.key()])) << item.key();
}

TEST(InteractModelFile, ComesBackAsItWasSaved) {
  const TempFolder folder;
  Networks saved = untrained_networks(small_interact_config());
  saved.pose->train();
  save_networks(folder / "m.safetensors", saved);
  const Networks loaded = load_networks(folder / "m.safetensors");
  EXPECT_TRUE(loaded.config == saved.config);
  EXPECT_TRUE(torch::equal(loaded.input_scale.mean, saved.input_scale.mean));
  EXPECT_TRUE(torch::equal(loaded.output_scale.deviation, saved.output_scale.deviation));
  EXPECT_FALSE(loaded.pose->is_training());
  EXPECT_TRUE(torch::equal(loaded.habits.chairs, saved.habits.chairs));
  EXPECT_TRUE(torch::equal(loaded.habits.heights, saved.habits.heights));
  EXPECT_TRUE(torch::equal(loaded.habits.seated.ends, saved.habits.seated.ends));
  EXPECT_TRUE(torch::equal(loaded.habits.seated.points, saved.habits.seated.points));
  EXPECT_TRUE(torch::equal(loaded.habits.standing.ends, saved.habits.standing.ends));
  EXPECT_TRUE(torch::equal(loaded.habits.standing.points, saved.habits.standing.points));
  expect_same_parameters(*loaded.pose, *saved.pose);
  expect_same_parameters(*loaded.control, *saved.control);
  expect_same_parameters(*loaded.contact, *saved.contact);
  expect_same_parameters(*loaded.nsm, *saved.nsm);
  expect_same_parameters(*loaded.nsm_control, *saved.nsm_control);
  expect_same_parameters(*loaded.samp, *saved.samp);
  expect_same_parameters(*loaded.samp_control, *saved.samp_control);
}

TEST(InteractModelFile, HoldsWhicheverNetworksThereAre) {
  const TempFolder folder;
  Networks n = untrained_networks(small_interact_config());
  n.pose = PoseNetwork(nullptr);
  n.nsm = n.nsm_control = PoseNetwork(nullptr);
  n.samp = n.samp_control = SampNetwork(nullptr);
  n.contact = ContactNetwork(nullptr);
  save_networks(folder / "m.safetensors", n);
  const Networks loaded = load_networks(folder / "m.safetensors");
  EXPECT_FALSE(loaded.control.is_empty());
  EXPECT_TRUE(loaded.pose.is_empty() && loaded.nsm.is_empty() && loaded.samp.is_empty() && loaded.contact.is_empty());
  n.control = ControlNetwork(nullptr);
  save_networks(folder / "none.safetensors", n);
  EXPECT_THAT(refusal_of([&] { load_networks(folder / "none.safetensors"); }),
              HasSubstr("none.safetensors: holds no network"));
}

TEST(InteractModelFile, CompactWeightsStayUnderSixteenMebibytes) {
  const TempFolder folder;
  Networks n = untrained_networks(preset("compact"));
  n.nsm = n.nsm_control = PoseNetwork(nullptr);
  n.samp = n.samp_control = SampNetwork(nullptr);
  save_networks(folder / "half.safetensors", n, /*half=*/true);
  EXPECT_LT(std::filesystem::file_size(folder / "half.safetensors"), 16U << 20);
  const Networks half = load_networks(folder / "half.safetensors");
  const torch::NoGradGuard no_gradients;
  PoseNetwork exact = n.pose, rounded = half.pose;
  const Tensor x = torch::randn({2, exact->sizes.row}), expected = exact->forward(x);
  EXPECT_LT(largest_difference(rounded->forward(x), expected), 0.01 * largest(expected));
}

TEST(InteractModelFile, RefusesFilesOfOtherSystemsAndDamage) {
  const TempFolder folder;
  const std::string path = folder / "m.safetensors";
  save_networks(path, untrained_networks(small_interact_config()));
  const SafeTensors good = read_safetensors(path);
  const auto refusal = [&](const std::string& file) { return refusal_of([&] { load_networks(file); }); };
  const auto changed = [&](const std::function<void(SafeTensors&)>& change) {
    SafeTensors bad = good;
    for (auto& [name, tensor] : bad.tensors) tensor = tensor.clone();
    change(bad);
    write_safetensors(path, bad);
    const std::string why = refusal(path);
    EXPECT_THAT(why, HasSubstr("m.safetensors: "));
    return why;
  };
  EXPECT_EQ(refusal(path), "");
  EXPECT_THAT(refusal(folder / "none.safetensors"), HasSubstr("no such file"));
  EXPECT_THAT(refusal(INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors"),
              HasSubstr("is not a model of chair-interaction"));
  EXPECT_THAT(changed([](auto& f) { f.metadata.erase("config"); }), HasSubstr("lacks the configuration"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = "{"; }), HasSubstr("no JSON"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = R"({"hidden": -4})"; }), HasSubstr("out of range"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = to_json(preset("compact")); }), HasSubstr("wrong shape"))
      << "networks of other sizes";
  for (const char* name :
       {"scale.input_mean", "scale.output_deviation", "pose_net.encoder2.1.weight", "pose_net.gatingNN.fc1.bias",
        "pose_net.predNN.expert_weights_fc2", "control_net.rnn.weight_hh_l1", "control_net.h0",
        "contact_net.encoder.fc2.weight", "contact_net.decoder.main.6.bias", "nsm_net.encoder0.4.weight",
        "nsm_control_net.encoder1.1.weight", "samp_net.mean.weight", "samp_control_net.experts.expert_bias_fc0"}) {
    SCOPED_TRACE(name);
    EXPECT_THAT(changed([&](auto& f) { f.tensors.erase(name); }), HasSubstr(name));
    EXPECT_THAT(changed([&](auto& f) { f.tensors[name] = torch::ones({2, 2, 2, 2}); }), HasSubstr(name));
    EXPECT_THAT(changed([&](auto& f) { f.tensors[name].view({-1})[0] = std::nan(""); }),
                AllOf(HasSubstr(name), HasSubstr("not finite")));
  }
  EXPECT_THAT(changed([](auto& f) { f.tensors["scale.input_deviation"][3] = 0; }), HasSubstr("not positive"));
  for (const auto& ends : {std::vector<int64_t>{7, 3}, {3, 8}, {1, 7}, {-5, 7}})
    EXPECT_THAT(changed([&](auto& f) { f.tensors["habits.ends"] = torch::tensor(ends); }), HasSubstr("out of order"));
  EXPECT_THAT(changed([](auto& f) { f.tensors["habits.ends"] = torch::rand({2}); }), HasSubstr("habits.ends"));
  EXPECT_THAT(changed([](auto& f) { f.tensors["habits.points"] = torch::rand({7, 14}); }), HasSubstr("habits.points"));
  EXPECT_THAT(changed([](auto& f) { f.tensors["habits.chairs"] = torch::rand({3, 32}); }), HasSubstr("habits.chairs"));
  EXPECT_THAT(changed([](auto& f) { f.tensors.erase("habits.heights"); }), HasSubstr("habits.heights"));
  EXPECT_THAT(changed([](auto& f) {
                f.tensors["habits.standing_ends"] = torch::tensor({4, 4, 9});
              }),
              HasSubstr("'habits.standing_ends' are out of order"));
  EXPECT_THAT(changed([](auto& f) { f.tensors.erase("habits.standing_points"); }), HasSubstr("habits.standing_points"));
  write_safetensors(path, good);
  const std::string bytes = read_whole_file(path);
  for (const size_t kept : {size_t{0}, size_t{5}, size_t{300}, bytes.size() / 2, bytes.size() - 1}) {
    write_atomically(path, bytes.substr(0, kept));
    EXPECT_THAT(refusal(path), HasSubstr("m.safetensors: ")) << kept << " bytes";
  }
}

/// A small file as released ones are: parameters without a prefix, sizes in the metadata.
SafeTensors released_pose(const PoseNetwork& network) {
  SafeTensors content;
  inhabit::nn::collect_parameters(*network, "", content);
  const PoseSizes& s = network->sizes;
  int64_t end = 0;
  const char* keys[] = {"start_goal", "start_environment", "start_interaction", "start_hand", "start_gating"};
  for (size_t i = 0; i < 5; ++i) content.metadata[keys[i]] = std::to_string(end += s.inputs[i]);
  content.metadata["dim_gating"] = std::to_string(s.gating);
  content.metadata["hidden"] = std::to_string(s.hidden);
  content.metadata["encoders"] = "[20, 9, 12, 17, 5]";
  content.metadata["experts"] = std::to_string(s.experts);
  content.metadata["gating_hidden"] = std::to_string(s.gating_first);
  content.metadata["outputs"] = std::to_string(s.outputs);
  return content;
}

TEST(InteractModelFile, ReadsReleasedWeights) {
  const TempFolder folder;
  const std::string path = folder / "r.safetensors";
  const Networks n = untrained_networks(small_interact_config());
  const SafeTensors good = released_pose(n.pose);
  write_safetensors(path, good);
  const Networks loaded = load_networks(path);
  ASSERT_FALSE(loaded.pose.is_empty());
  expect_same_parameters(*loaded.pose, *n.pose);
  EXPECT_EQ(loaded.pose->sizes.row, loaded.input_scale.mean.size(0));
  for (const auto& [key, value] : std::initializer_list<std::pair<const char*, const char*>>{{"hidden", "-3"},
                                                                                             {"hidden", "1e30"},
                                                                                             {"encoders", "[20, 9]"},
                                                                                             {"encoders", "x"},
                                                                                             {"start_hand", "3"},
                                                                                             {"dim_gating", "9"},
                                                                                             {"outputs", "zwei"}}) {
    SafeTensors bad = good;
    bad.metadata[key] = value;
    write_safetensors(path, bad);
    EXPECT_THAT(refusal_of([&] { load_networks(path); }), HasSubstr("r.safetensors: ")) << key << " " << value;
    bad.metadata.erase(key);
    write_safetensors(path, bad);
    EXPECT_THAT(refusal_of([&] { load_networks(path); }), HasSubstr(key));
  }
}

}  // namespace
}  // namespace inhabit::interact
