// Protects the configuration: it comes back from JSON as it was, and what no network can be built or trained with is
// refused in one line.
#include "inhabit/anticipate/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "refusal_of.h"

namespace inhabit::anticipate {
namespace {

using ::testing::HasSubstr;

TEST(Config, EverySettingComesBackFromJson) {
  // Each setting in turn takes another value that can be.
  const auto defaults = nlohmann::json::parse(to_json(Config()));
  std::vector<std::pair<std::string, nlohmann::json>> settings;
  for (const auto& [key, value] : defaults.items())
    if (value.is_object())
      for (const auto& [inner, field] : value.items()) settings.emplace_back(key + "." + inner, field);
    else if (key != "preset")  // names what was set, sets nothing
      settings.emplace_back(key, value);
  for (const auto& [key, value] : settings) {
    Config config;
    nlohmann::json other = !value.is_boolean() || !value.get<bool>();
    if (value.is_number_integer()) other = value == 0 ? 2 : value.get<int>() - 1;
    if (value.is_number_float()) other = value.get<double>() / 2;
    if (key == "released") config.future = 100;  // as its labels need
    set_fields(config, {key + "=" + other.dump()});
    EXPECT_FALSE(config == Config()) << key;
    const Config back = config_from_json(to_json(config), "test");
    EXPECT_TRUE(back == config) << key;
    EXPECT_TRUE(back == config_from_json(to_json(back), "test")) << key;
  }
}

TEST(Config, DefaultsAreThePapers) {
  const Config c = config_from_json("{}", "test");
  EXPECT_TRUE(c == Config());
  EXPECT_EQ(c.gamma, 10);
  EXPECT_EQ(c.training.rec_frames, 15);
  EXPECT_EQ(c.kappa, 8);
  EXPECT_EQ(c.labels, 8);
  EXPECT_EQ(c.rate, 25);
  EXPECT_EQ(c.observed, 50);
}

/// {"a": {"b": value}} for the key a.b.
std::string object_with(const std::string& key, const std::string& value) {
  const size_t dot = key.find('.');
  if (dot == std::string::npos) return "{\"" + key + "\": " + value + "}";
  return "{\"" + key.substr(0, dot) + "\": " + object_with(key.substr(dot + 1), value) + "}";
}

TEST(Config, RefusesWhatCannotBe) {
  const auto refusal = [](const std::string& text) {
    return refusal_of([&] { config_from_json(text, "m.safetensors"); });
  };
  EXPECT_THAT(refusal("{"), HasSubstr("m.safetensors: the configuration is no JSON"));
  EXPECT_THAT(refusal("[1]"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal(R"({"gama": 5})"), HasSubstr("no setting is called 'gama'"));
  EXPECT_THAT(refusal(R"({"gamma": "five"})"), HasSubstr("'gamma' has the wrong type"));
  EXPECT_THAT(refusal(R"({"intention": 3})"), HasSubstr("'intention' has the wrong type"));
  for (const auto& [key, value] :
       std::initializer_list<std::pair<std::string, std::string>>{{"rate", "0"},
                                                                  {"rate", "1e300"},
                                                                  {"observed", "7"},
                                                                  {"observed", "100000"},
                                                                  {"future", "-1"},
                                                                  {"gamma", "0"},
                                                                  {"gamma", "100000"},
                                                                  {"training.rec_frames", "-1"},
                                                                  {"kappa", "1"},
                                                                  {"labels", "0"},
                                                                  {"clusters", "0"},
                                                                  {"hidden", "1000000000"},
                                                                  {"noise", "-1"},
                                                                  {"noise", "160"},
                                                                  {"intention_features", "0"},
                                                                  {"training.discriminator_frames", "1"},
                                                                  {"training.discriminator_frames", "51"},
                                                                  {"training.discriminator_frames", "31"},
                                                                  {"training.pose_discriminator_weight", "-1"},
                                                                  {"training.diversity_weight", "1e9"},
                                                                  {"baselines.ltd_past", "51"},
                                                                  {"baselines.ltd_future", "51"},
                                                                  {"baselines.ltd_blocks", "0"},
                                                                  {"baselines.hisrep_query", "1"},
                                                                  {"baselines.hisrep_future", "0"},

                                                                  {"baselines.dlow_samples", "1"},
                                                                  {"baselines.mix_hidden", "0"},
                                                                  {"baselines.grammar_rules", "0"},
                                                                  {"baselines.grammar_rollouts", "0"},
                                                                  {"baselines.seq2seq_hidden", "0"}})
    EXPECT_THAT(refusal(object_with(key, value)), HasSubstr("'" + key + "' is out of range")) << value;
  EXPECT_THAT(refusal(R"({"observed": 9, "baselines": {"ltd_past": 5}})"), HasSubstr("discriminator_frames"))
      << "its views begin in the observation";
}

TEST(Config, SettingsFromTheCommandLine) {
  Config c;
  set_fields(c, {"gamma=5", "intention=false", "training.pose_discriminator_weight=0.25"});
  EXPECT_EQ(c.gamma, 5);
  EXPECT_FALSE(c.intention);
  EXPECT_EQ(c.training.pose_discriminator_weight, 0.25);
  const Config before = c;
  const auto refusal = [&](const std::string& setting) { return refusal_of([&] { set_fields(c, {setting}); }); };
  for (const char* text : {"gamma", "gamma=", "gamma=five", "=5", "gamma=5=6", ""})
    EXPECT_THAT(refusal(text), ::testing::Not("")) << text;
  EXPECT_THAT(refusal("gama=5"), HasSubstr("gama=5: configuration: no setting is called 'gama'"));
  EXPECT_THAT(refusal("gamma=true"), HasSubstr("wrong type"));
  EXPECT_THAT(refusal("gamma=2.5"), HasSubstr("wrong type"));
  EXPECT_TRUE(c == before) << "a refused setting changes nothing";

  set_fields(c, {"observed=12"});  // does not fit the others yet
  EXPECT_THAT(refusal_of([&] { validate(c, "m"); }),
              HasSubstr("m: configuration: 'baselines.ltd_past' is out of range"));
  set_fields(c, {"baselines.ltd_past=10", "baselines.hisrep_query=4", "baselines.hisrep_future=5"});
  EXPECT_EQ(refusal_of([&] { validate(c, "m"); }), "");
}

}  // namespace
}  // namespace inhabit::anticipate
