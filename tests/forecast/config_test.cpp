#include "inhabit/forecast/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "inhabit/forecast/network.h"
#include "refusal_of.h"

using namespace inhabit;
using namespace inhabit::forecast;

TEST(Config, JsonRoundTripKeepsEverything) {
  for (const char* name : {"paper", "compact"}) {
    Config config = preset(name);
    EXPECT_NO_THROW(validate(config, name));
    config.joints = 21;
    config.root = 14;
    config.sigma = 0.17;
    config.decode_from_past = true;
    const Config back = config_from_json(to_json(config), "test");
    EXPECT_TRUE(back == config);
    EXPECT_FALSE(back == preset(name));
  }
}

TEST(Config, PaperPresetHasThePapersSize) {
  ContactNetwork network(preset("paper"));
  int64_t parameters = 0;
  for (const auto& parameter : network->parameters()) parameters += parameter.numel();
  EXPECT_NEAR(static_cast<double>(parameters), 15.2e6, 0.1e6);
}

TEST(Config, RefusesWhatCannotBe) {
  const auto message = [](const std::string& text) {
    return refusal_of([&] { return config_from_json(text, "model.safetensors"); });
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(message("{"), HasSubstr("model.safetensors"));
  EXPECT_THAT(message("[]"), HasSubstr("no JSON object"));
  EXPECT_THAT(message("{}"), HasSubstr("malformed"));
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = to_json(preset("compact"));
    const size_t place = text.find(from);
    EXPECT_NE(place, std::string::npos) << from;
    return text.replace(place, from.size(), to);
  };
  EXPECT_THAT(message(with("\"past\":30", "\"past\":0")), HasSubstr("'past'"));
  EXPECT_THAT(message(with("\"past\":30", "\"past\":\"x\"")), HasSubstr("'past' has the wrong type"));
  EXPECT_THAT(message(with("\"past\":30", "\"passed\":30")), HasSubstr("no setting is called 'passed'"));
  EXPECT_THAT(message(with("\"hidden\":128", "\"hidden\":1000000000")), HasSubstr("hidden"));
  EXPECT_THAT(message(with("\"root\":0", "\"root\":22")), HasSubstr("'root'"));
  EXPECT_THAT(message(with("\"dropout\":0.0", "\"dropout\":1.0")), HasSubstr("dropout"));
  EXPECT_THAT(message(with("\"sigma\":0.2", "\"sigma\":-1")), HasSubstr("sigma"));
  EXPECT_THAT(message(with("\"contact_coefficients\":12", "\"contact_coefficients\":91")), HasSubstr("coefficients"));
  EXPECT_THROW(preset("huge"), Error);
}
