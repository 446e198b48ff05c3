// Protects model files: what was saved comes back, networks that are not there stay away, and files of other systems or
// with damage are refused in one line that names them.
#include "inhabit/anticipate/model_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "anticipate/small_networks.h"
#include "inhabit/anticipate/futures.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/safetensors.h"
#include "largest.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::anticipate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

template <class Network>
void expect_same_parameters(const Network& a, const Network& b, double tolerance = 0) {
  ASSERT_FALSE(b.is_empty());
  EXPECT_FALSE(b->is_training());
  const auto before = a->named_parameters();
  for (const auto& parameter : b->named_parameters())
    EXPECT_LE(largest(parameter.value() - before[parameter.key()]), tolerance) << parameter.key();
}

TEST(AnticipateModelFile, ComesBackAsItWasSaved) {
  const TempFolder folder;
  const Networks saved = untrained();
  {
    const torch::NoGradGuard no_gradients;
    for (torch::Tensor& buffer : saved.ltd->buffers())
      if (buffer.is_floating_point()) buffer.add_(0.5);  // running means and variances too
  }
  save_networks(folder / "m.safetensors", saved);
  const Networks loaded = load_networks(folder / "m.safetensors");
  EXPECT_TRUE(loaded.config == saved.config);
  EXPECT_TRUE(torch::equal(loaded.skeleton.offsets, saved.skeleton.offsets));
  EXPECT_EQ(loaded.skeleton.names, standard_joint_names());
  EXPECT_TRUE(torch::equal(loaded.scale.mean, saved.scale.mean));
  EXPECT_TRUE(torch::equal(loaded.scale.deviation, saved.scale.deviation));
  EXPECT_TRUE(torch::equal(loaded.clusters.poses, saved.clusters.poses));
  EXPECT_TRUE(torch::equal(loaded.clusters.labels, saved.clusters.labels));
  ASSERT_TRUE(loaded.memory);
  ASSERT_EQ(loaded.memory->recordings().size(), 4U);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(torch::equal(loaded.memory->recordings()[i].features, saved.memory->recordings()[i].features)) << i;
    EXPECT_TRUE(torch::equal(loaded.memory->recordings()[i].typical, saved.memory->recordings()[i].typical)) << i;
  }
  expect_same_parameters(saved.intention, loaded.intention);
  expect_same_parameters(saved.pose, loaded.pose);
  expect_same_parameters(saved.seq2seq, loaded.seq2seq);
  expect_same_parameters(saved.ltd, loaded.ltd);
  expect_same_parameters(saved.hisrep, loaded.hisrep);
  expect_same_parameters(saved.vae, loaded.vae);
  expect_same_parameters(saved.dlow, loaded.dlow);
  expect_same_parameters(saved.mix_match, loaded.mix_match);
  expect_same_parameters(saved.grammar, loaded.grammar);
  const torch::Tensor past = people(60)[0].features.slice(0, 0, 12).unsqueeze(0);
  EXPECT_TRUE(torch::equal(ltd_future(loaded, past, 9), ltd_future(saved, past, 9)));
  const FutureNoise noise = draw_noise(saved.config, 2, 9, 1);
  EXPECT_TRUE(
      torch::equal(plain_futures(loaded, past, noise, 9).features, plain_futures(saved, past, noise, 9).features));
}

TEST(AnticipateModelFile, HalfPrecisionIsNearlyTheSame) {
  const TempFolder folder;
  const Networks saved = untrained();
  save_networks(folder / "whole.safetensors", saved);
  save_networks(folder / "half.safetensors", saved, /*half=*/true);
  expect_same_parameters(saved.pose, load_networks(folder / "half.safetensors").pose, 5e-4);
  EXPECT_LT(std::filesystem::file_size(folder / "half.safetensors"),
            std::filesystem::file_size(folder / "whole.safetensors") * 6 / 10);
}

TEST(AnticipateModelFile, NetworksThatAreNotThereStayAway) {
  const TempFolder folder;
  Networks some = untrained();
  some.intention = nullptr;
  some.seq2seq = nullptr;
  some.ltd = nullptr;
  some.hisrep = nullptr;
  some.dlow = nullptr;
  some.mix_match = nullptr;
  some.grammar = nullptr;
  some.config.naive_clusters = true;
  some.clusters = cluster_recordings(people(60), some.config, 1);
  save_networks(folder / "m.safetensors", some);
  const Networks loaded = load_networks(folder / "m.safetensors");
  EXPECT_TRUE(loaded.intention.is_empty() && loaded.seq2seq.is_empty() && loaded.ltd.is_empty() &&
              loaded.hisrep.is_empty());
  EXPECT_TRUE(loaded.dlow.is_empty() && loaded.mix_match.is_empty() && loaded.grammar.is_empty());
  EXPECT_FALSE(loaded.pose.is_empty() || loaded.vae.is_empty());
  EXPECT_FALSE(loaded.clusters.labels.defined());
  some = untrained();
  some.vae = nullptr;
  save_networks(folder / "m.safetensors", some);
  EXPECT_THAT(refusal_of([&] { load_networks(folder / "m.safetensors"); }), HasSubstr("a DLow without the VAE"));
}

TEST(AnticipateModelFile, RefusesFilesOfOtherSystemsAndDamage) {
  const TempFolder folder;
  const std::string path = folder / "m.safetensors";
  save_networks(path, untrained());
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
              HasSubstr("is not a model of intention-anticipation"));
  EXPECT_THAT(changed([](auto& f) { f.metadata.clear(); }), HasSubstr("is not a model of"));
  EXPECT_THAT(changed([](auto& f) { f.metadata.erase("config"); }), HasSubstr("lacks the configuration"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = "{"; }), HasSubstr("no JSON"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = R"({"hiden": 4})"; }), HasSubstr("'hiden'"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = R"({"hidden": -4})"; }), HasSubstr("out of range"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = "{}"; }), HasSubstr("intention_net.encoder"))
      << "networks of other sizes";
  for (const char* name : {"skeleton.offsets", "scale.mean", "scale.deviation", "clusters.poses", "clusters.labels",
                           "pose_net.out.weight", "intention_net.decoder.bias_hh", "seq2seq_net.gru.weight_ih_l0",
                           "ltd_net.norm0.running_var", "hisrep_net.query.0.weight"}) {
    SCOPED_TRACE(name);
    EXPECT_THAT(changed([&](auto& f) { f.tensors.erase(name); }), HasSubstr(name));
    EXPECT_THAT(changed([&](auto& f) { f.tensors[name] = torch::ones({2, 2}); }), HasSubstr(name));
    EXPECT_THAT(changed([&](auto& f) { f.tensors[name].view({-1})[0] = std::nan(""); }),
                AllOf(HasSubstr(name), HasSubstr("not finite")));
  }
  EXPECT_THAT(changed([](auto& f) { f.tensors["scale.deviation"][3] = 0; }), HasSubstr("not positive"));
  for (const char* name : {"memory.features", "memory.frames", "memory.typical", "memory.validation"}) {
    SCOPED_TRACE(name);
    EXPECT_THAT(changed([&](auto& f) { f.tensors.erase(name); }), HasSubstr(name));
    EXPECT_THAT(changed([&](auto& f) { f.tensors[name] = torch::ones({2, 2}); }), HasSubstr("memory."));
  }
  EXPECT_THAT(changed([](auto& f) { f.tensors["memory.validation"] = torch::zeros({3}, torch::kInt64); }),
              HasSubstr("memory.validation"));
  for (const int64_t frames : {int64_t{0}, int64_t{-3}, int64_t{59}, int64_t{61}, std::numeric_limits<int64_t>::max()})
    EXPECT_THAT(changed([&](auto& f) { f.tensors["memory.frames"][2] = frames; }), HasSubstr("memory")) << frames;
  EXPECT_THAT(changed([](auto& f) {
                auto config = nlohmann::json::parse(f.metadata["config"]);
                config["naive_clusters"] = true;
                f.metadata["config"] = config.dump();
              }),
              HasSubstr("as many as its labels"))
      << "6 clusters, 3 labels: a label would be read beyond the scores";
  EXPECT_THAT(changed([](auto& f) { f.tensors["memory.typical"][7] = std::nan(""); }), HasSubstr("not finite"));
  EXPECT_THAT(changed([](auto& f) {
                f.tensors["memory.features"] = f.tensors["memory.features"].slice(0, 0, 12).clone();
                f.tensors["memory.typical"] = f.tensors["memory.typical"].slice(0, 0, 12).clone();
                f.tensors["memory.frames"] = torch::tensor({int64_t{12}});
                f.tensors["memory.validation"] = torch::tensor({int64_t{0}});
              }),
              HasSubstr("too short to be remembered"));
  EXPECT_THAT(changed([](auto& f) {
                for (auto it = f.tensors.begin(); it != f.tensors.end();)
                  it = it->first.find("_net.") != std::string::npos ? f.tensors.erase(it) : std::next(it);
              }),
              HasSubstr("holds no network"));
  write_safetensors(path, good);
  const std::string bytes = read_whole_file(path);
  for (const size_t kept : {size_t{0}, size_t{5}, size_t{300}, bytes.size() / 2, bytes.size() - 1}) {
    write_atomically(path, bytes.substr(0, kept));
    EXPECT_THAT(refusal(path), HasSubstr("m.safetensors: ")) << kept << " bytes";
  }
}

}  // namespace
}  // namespace inhabit::anticipate
