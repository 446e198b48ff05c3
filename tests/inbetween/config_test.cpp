// Protects the configuration of in-betweening: it survives its JSON, the presets are the sizes they promise, and what
// cannot be built is refused in one line.
#include "inhabit/inbetween/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using ::testing::HasSubstr;

TEST(Config, ComesBackFromItsJson) {
  Config c = preset("features");
  c.t_star = 20;
  c.multipliers = {1, 3, 2};
  c.scene_encoder.depth = 5;
  c.inference.guidance = 1.5;
  c.local_scene = false;
  EXPECT_TRUE(config_from_json(to_json(c), "here") == c);
}

TEST(Config, PresetsAreThePapersAndACompactOne) {
  const Config paper = preset("paper"), compact = preset("compact");
  EXPECT_TRUE(paper == Config());
  EXPECT_EQ(paper.mask_channels(), 1);
  EXPECT_EQ(compact.mask_channels(), kMaskChannels);
  EXPECT_EQ(compact.preset, "compact");
  EXPECT_LT(compact.width, paper.width);
  EXPECT_EQ(compact.frames, paper.frames);
  for (const Config& c : {paper, compact}) validate(c, "preset");
  EXPECT_THAT(refusal_of([] { preset("huge"); }), HasSubstr("'huge'"));
}

TEST(Config, SaysWhichModelWasNotTrainedOnNoisyKeys) {
  Config c = preset("features");
  EXPECT_EQ(refusal_of([&] { require_noise_aware(c, "m.safetensors"); }),
            "m.safetensors: was not trained on noisy key frames");
  c.t_star = 20;
  EXPECT_EQ(refusal_of([&] { require_noise_aware(c, "m.safetensors"); }), "");
  c = preset("compact");  // was, but takes keys as they are
  EXPECT_NE(refusal_of([&] { require_noise_aware(c, "m.safetensors"); }), "");
  c.t_star = 20;  // residual motion imputes nothing
  EXPECT_NE(refusal_of([&] { require_noise_aware(c, "m.safetensors"); }), "");
  c.t_star = 0;
  c.inference.noisy_keys = true;
  EXPECT_EQ(refusal_of([&] { require_noise_aware(c, "m.safetensors"); }), "");
}

TEST(Config, RefusesWhatCannotBeBuilt) {
  const auto refusal = [](const std::string& text) { return refusal_of([&] { config_from_json(text, "here"); }); };
  EXPECT_EQ(refusal("{}"), "");
  EXPECT_THAT(refusal("{"), HasSubstr("here: the configuration is no JSON"));
  EXPECT_THAT(refusal("[3]"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal(R"({"widht": 3})"), HasSubstr("'widht'"));
  EXPECT_THAT(refusal(R"({"width": "3"})"), HasSubstr("'width' has the wrong type"));
  EXPECT_THAT(refusal(R"({"multipliers": [2, 1.5]})"), HasSubstr("'multipliers' has the wrong type"));
  for (const char* bad : {R"({"rate": 0})",
                          R"({"frames": 1})",
                          R"({"frames": 200})",
                          R"({"padded": 126})",
                          R"({"width": 0})",
                          R"({"width": 1e300})",
                          R"({"width": 90})",
                          R"({"multipliers": []})",
                          R"({"multipliers": [2]})",
                          R"({"multipliers": [2, -1]})",
                          R"({"multipliers": [1, 16]})",
                          R"({"scene_patch": 7})",
                          R"({"scene_side": 50, "scene_patch": 10})",
                          R"({"scene_side": 4, "scene_patch": 2})",
                          R"({"scene_side": 192, "scene_patch": 2})",
                          R"({"scene_width": 0})",
                          R"({"scene_heads": 9999999999999})",
                          R"({"anchors": 0})",
                          R"({"diffusion_steps": 1})",
                          R"({"t_star": -1})",
                          R"({"t_star": 1001})",
                          R"({"keys_seen": false})",
                          R"({"inference": {"guidance": -1}})",
                          R"({"inference": {"noisy_keys": true}})",
                          R"({"training": {"scene_dropout": 2}})"}) {
    SCOPED_TRACE(bad);
    const std::string why = refusal(bad);
    EXPECT_TRUE(why.find("out of range") != std::string::npos || why.find("wrong type") != std::string::npos) << why;
  }
}

TEST(Config, ReadsTheSizesOfReleasedWeights) {
  const std::map<std::string, std::string> metadata = {
      {"latent_dim", "16"},
      {"dim_mults", "[1, 2]"},
      {"vit", R"({"dim": 24, "depth": 2, "heads": 3, "mlp": 32, "image": 48, "patch": 12, "channels": 24})"},
      {"frames", "121"},
      {"padded_frames", "128"},
      {"features", "201"},
      {"bps_points", "64"},
      {"t_star", "20"},
      {"diffusion_steps", "1000"},
      {"guidance", "2.5"}};
  const Config c = released_config(metadata, "here");
  EXPECT_EQ(c.width, 16);
  EXPECT_EQ(c.multipliers, (std::vector<int>{1, 2}));
  EXPECT_EQ(c.scene_encoder.heads, 3);
  EXPECT_EQ(c.t_star, 20);
  const auto changed = [&](const std::string& key, const std::string& value) {
    auto bad = metadata;
    if (value.empty())
      bad.erase(key);
    else
      bad[key] = value;
    return refusal_of([&] { released_config(bad, "here"); });
  };
  for (const auto& [key, value] : metadata) {
    EXPECT_THAT(changed(key, ""), HasSubstr("lacks '" + key + "'"));
    EXPECT_THAT(changed(key, "{"), HasSubstr("'" + key + "' has the wrong type"));
  }
  EXPECT_THAT(changed("features", "263"), HasSubstr("another size"));
  EXPECT_THAT(
      changed("vit", R"({"dim": 24, "depth": 2, "heads": 3, "mlp": 32, "image": 96, "patch": 12, "channels": 24})"),
      HasSubstr("another size"));
  EXPECT_THAT(changed("vit", "{}"), HasSubstr("'image' has the wrong type"));
}

}  // namespace
}  // namespace inhabit::inbetween
