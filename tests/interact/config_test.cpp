// Protects the configuration: it comes back from JSON as it was, its defaults are the paper's, and what no network can
// be built or trained with is refused in one line.
#include "inhabit/interact/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "refusal_of.h"

namespace inhabit::interact {
namespace {

using ::testing::HasSubstr;

TEST(InteractConfig, EverySettingComesBackFromJson) {
  const auto defaults = nlohmann::json::parse(to_json(Config()));
  std::vector<std::pair<std::string, nlohmann::json>> settings;
  for (const auto& [key, value] : defaults.items())
    if (value.is_object())
      for (const auto& [inner, field] : value.items()) settings.emplace_back(key + "." + inner, field);
    else if (key != "preset")
      settings.emplace_back(key, value);
  EXPECT_GT(settings.size(), 45U);
  for (const auto& [key, value] : settings) {
    Config config;
    nlohmann::json other = !value.is_boolean() || !value.get<bool>();
    if (value.is_number_integer()) other = value.get<int>() + 1;
    if (value.is_number_float()) other = value.get<double>() == 0 ? 0.5 : value.get<double>() * 0.75;
    if (value.is_array()) other = {1, 2, 3, 4, 5};
    if (key == "training.sampling_to") other = 0.9;
    set_fields(config, {key + "=" + other.dump()});
    EXPECT_FALSE(config == Config()) << key;
    const Config back = config_from_json(to_json(config), "test");
    EXPECT_TRUE(back == config) << key;
  }
}

TEST(InteractConfig, DefaultsAreThePapers) {
  const Config c = preset("paper");
  EXPECT_TRUE(c == config_from_json("{}", "test"));
  EXPECT_EQ(c.keys(), 13);
  EXPECT_EQ(c.future_points(), 7);
  EXPECT_EQ(c.ego_points(), 1408) << "E, sec. 4.3";
  EXPECT_EQ(c.chair_size(), 2048) << "I, sec. 4.3";
  EXPECT_EQ(c.encoders, (std::vector<int>{512, 128, 256, 512, 128})) << "Table 5";
  EXPECT_EQ(c.encoder_layers, 3);
  EXPECT_EQ(c.experts, 10);
  EXPECT_EQ(c.control_hidden, 512);
  EXPECT_EQ(c.contact_z, 6);
  EXPECT_DOUBLE_EQ(c.training.pose_rate * c.training.pose_floor, 5e-6);
  EXPECT_DOUBLE_EQ(c.training.control_rate * c.training.control_floor, 5e-6);
}

TEST(InteractConfig, TheReleasesGridHasItsPoints) {
  Config c;
  c.ego_rings = c.ego_layers = 9;
  EXPECT_EQ(c.ego_points(), 2034);
}

TEST(InteractConfig, PresetsCanBe) {
  for (const char* name : {"paper", "compact"}) {
    const Config c = preset(name);
    EXPECT_EQ(c.preset, name);
    EXPECT_EQ(refusal_of([&] { validate(c, name); }), "");
  }
  EXPECT_THAT(refusal_of([] { preset("huge"); }), HasSubstr("there are paper and compact"));
}

TEST(InteractConfig, RefusesWhatCannotBe) {
  const auto refusal = [](const std::string& text) {
    return refusal_of([&] { config_from_json(text, "m.safetensors"); });
  };
  EXPECT_THAT(refusal("{"), HasSubstr("m.safetensors: the configuration is no JSON"));
  EXPECT_THAT(refusal(R"({"expertz": 5})"), HasSubstr("no setting is called 'expertz'"));
  EXPECT_THAT(refusal(R"({"experts": "five"})"), HasSubstr("'experts' has the wrong type"));
  for (const char* setting : {"rate=0",
                              "joints=0",
                              "past_keys=-1",
                              "future_keys=0",
                              "key_step=0",
                              "actions=0",
                              "ego_rings=1",
                              "ego_layers=1000000000",
                              "chair_grid=0",
                              "encoders=[1,2,3,4]",
                              "encoders=[1,2,3,4,0]",
                              "encoder_layers=0",
                              "experts=0",
                              "hidden=1000000000",
                              "gating_hidden=0",
                              "control_encoder=0",
                              "control_hidden=-4",
                              "control_layers=0",
                              "contact_hidden=0",
                              "contact_code=0",
                              "contact_z=0",
                              "training.pose_steps=-1",
                              "training.rollout_steps=-1",
                              "training.rollout_frames=0",
                              "training.rollout_rate=-1",
                              "training.rollout_average=1",
                              "training.rollout_hand_weight=-1",
                              "training.batch=0",
                              "training.pose_rate=-1",
                              "training.warmup=2",
                              "training.pose_floor=1.5",
                              "training.dropout=1",
                              "training.control_frames=1",
                              "training.sampling_from=0.8",
                              "training.contact_beta=-1",
                              "inference.goal_sit=1.1",
                              "inference.contact_spread=-1",
                              "baselines.samp_z=0",
                              "baselines.samp_experts=0"}) {
    Config c;
    set_fields(c, {setting});
    const std::string key = std::string(setting).substr(0, std::string(setting).find('='));
    EXPECT_THAT(refusal_of([&] { validate(c, "m"); }), HasSubstr("m: configuration: '" + key + "' is out of range"))
        << setting;
  }
}

}  // namespace
}  // namespace inhabit::interact
