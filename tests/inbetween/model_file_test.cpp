// Protects model files of in-betweening: what was saved comes back, and files of other systems or with damage are
// refused in one line that names them.
#include "inhabit/inbetween/model_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "inbetween/small_network.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/train/model_mean.h"
#include "largest.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::inbetween {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using torch::Tensor;

Networks small_networks() {
  Networks n;
  n.config = small_inbetween_config();
  n.config.partial_keys = true;
  n.config.t_star = 5;
  n.network = untrained(n.config);
  n.scale.mean = torch::randn({kFeatureCount});
  n.scale.deviation = torch::rand({kFeatureCount}) + 0.01;
  return n;
}

TEST(InbetweenModelFile, ComesBackAsItWasSaved) {
  const torch::NoGradGuard no_gradients;
  const TempFolder folder;
  Networks saved = small_networks();
  saved.network->train();
  save_networks(folder / "m.safetensors", saved);
  saved.network->eval();
  const Networks loaded = load_networks(folder / "m.safetensors");
  EXPECT_TRUE(loaded.config == saved.config);
  EXPECT_TRUE(torch::equal(loaded.scale.mean, saved.scale.mean));
  EXPECT_TRUE(torch::equal(loaded.scale.deviation, saved.scale.deviation));
  EXPECT_FALSE(loaded.network->is_training());
  const NetworkInput in(saved.config, 2);
  EXPECT_TRUE(torch::equal(in.through(loaded.network), in.through(saved.network)));
}

TEST(InbetweenModelFile, KeepsPathNetWhereThereIsOne) {
  const torch::NoGradGuard no_gradients;
  const TempFolder folder;
  Networks saved = small_networks();
  save_networks(folder / "without.safetensors", saved);
  EXPECT_FALSE(load_networks(folder / "without.safetensors").path);
  saved.path = PathNet();
  saved.path->eval();
  save_networks(folder / "m.safetensors", saved);
  Networks loaded = load_networks(folder / "m.safetensors");
  ASSERT_TRUE(loaded.path);
  EXPECT_FALSE(loaded.path->is_training());
  const Tensor map = torch::rand({1, kMapWide, kMapLong}), length = torch::tensor({3.F});
  EXPECT_TRUE(
      torch::equal(loaded.path->forward(map, length).rounds.back(), saved.path->forward(map, length).rounds.back()));
  SafeTensors bad = read_safetensors(folder / "m.safetensors");
  bad.tensors["path.move.bias"] = torch::full({2}, std::nan(""));
  write_safetensors(folder / "m.safetensors", bad);
  EXPECT_THAT(refusal_of([&] { load_networks(folder / "m.safetensors"); }),
              AllOf(HasSubstr("path.move.bias"), HasSubstr("not finite")));
}

TEST(InbetweenModelFile, KeepsFootContactNetWhichNoMeanHas) {
  const torch::NoGradGuard no_gradients;
  const TempFolder folder;
  Networks saved = small_networks();
  const std::string without = folder / "without.safetensors", with = folder / "with.safetensors";
  save_networks(without, saved);
  EXPECT_FALSE(load_networks(without).feet);
  saved.feet = foot_contact_net(saved.config);
  save_networks(with, saved);
  Networks loaded = load_networks(with);
  ASSERT_TRUE(loaded.feet);
  const Tensor features = torch::randn({1, 16, 9});
  EXPECT_TRUE(torch::equal(loaded.feet(features), saved.feet(features)));
  write_safetensors(folder / "mean.safetensors", mean_of_models({with, without}, {0.5, 0.5}));
  EXPECT_FALSE(load_networks(folder / "mean.safetensors").feet) << "it reads what other weights know";
}

TEST(InbetweenModelFile, HalfPrecisionIsNearlyTheSame) {
  const torch::NoGradGuard no_gradients;
  const TempFolder folder;
  const Networks saved = small_networks();
  save_networks(folder / "whole.safetensors", saved);
  save_networks(folder / "half.safetensors", saved, /*half=*/true);
  const Networks half = load_networks(folder / "half.safetensors");
  const NetworkInput in(saved.config, 2);
  const Tensor exact = in.through(saved.network);
  EXPECT_LT(largest(in.through(half.network) - exact), 0.01 * largest(exact));
  EXPECT_LT(largest((half.scale.deviation - saved.scale.deviation) / saved.scale.deviation), 1e-3);
  EXPECT_LT(std::filesystem::file_size(folder / "half.safetensors"),
            std::filesystem::file_size(folder / "whole.safetensors") * 6 / 10);
}

TEST(InbetweenModelFile, CompactWeightsStayUnderSixteenMebibytes) {
  const TempFolder folder;
  Networks n = small_networks();
  n.config = preset("features");
  n.network = Denoiser(n.config);
  save_networks(folder / "half.safetensors", n, /*half=*/true);
  EXPECT_LT(std::filesystem::file_size(folder / "half.safetensors"), 16U << 20);
}

TEST(InbetweenModelFile, RefusesFilesOfOtherSystemsAndDamage) {
  const TempFolder folder;
  const std::string path = folder / "m.safetensors";
  save_networks(path, small_networks());
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
              HasSubstr("is not a model of scene-inbetweening"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["system"] = "contact-forecast"; }), HasSubstr("is not a model of"));
  EXPECT_THAT(changed([](auto& f) { f.metadata.clear(); }), HasSubstr("metadata lacks 'latent_dim'"));
  EXPECT_THAT(changed([](auto& f) { f.metadata.erase("config"); }), HasSubstr("lacks the configuration"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = "{"; }), HasSubstr("no JSON"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = R"({"widht": 4})"; }), HasSubstr("'widht'"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = R"({"width": -4})"; }), HasSubstr("out of range"));
  EXPECT_THAT(changed([](auto& f) { f.metadata["config"] = to_json(preset("features")); }), HasSubstr("not ["))
      << "a network of other sizes";
  for (const char* name :
       {"scale.mean", "scale.deviation", "net.unet.downs.0.0.blocks.0.block1.0.weight", "net.unet.ups.0.3.conv.bias",
        "net.scene_embedding.pos_embedding", "net.cond_process.lin2.weight", "net.beta_process.lin0.bias"}) {
    SCOPED_TRACE(name);
    EXPECT_THAT(changed([&](auto& f) { f.tensors.erase(name); }), HasSubstr(name));
    EXPECT_THAT(changed([&](auto& f) { f.tensors[name] = torch::ones({2, 2}); }), HasSubstr(name));
    EXPECT_THAT(changed([&](auto& f) { f.tensors[name].view({-1})[0] = std::nan(""); }),
                AllOf(HasSubstr(name), HasSubstr("not finite")));
  }
  EXPECT_THAT(changed([](auto& f) { f.tensors["scale.deviation"][3] = 0; }), HasSubstr("not positive"));
  write_safetensors(path, good);
  const std::string bytes = read_whole_file(path);
  for (const size_t kept : {size_t{0}, size_t{5}, size_t{300}, bytes.size() / 2, bytes.size() - 1}) {
    write_atomically(path, bytes.substr(0, kept));
    EXPECT_THAT(refusal(path), HasSubstr("m.safetensors: ")) << kept << " bytes";
  }
}

}  // namespace
}  // namespace inhabit::inbetween
