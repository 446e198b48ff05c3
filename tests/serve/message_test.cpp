// Protects the reading of what pages send: every order, and one line of refusal for everything else.
#include "inhabit/serve/message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "refusal_of.h"

namespace inhabit::serve {
namespace {

using testing::HasSubstr;

TEST(Message, SaysWhatIsAskedFor) {
  const Message walk = parse_message(R"({"do": "walk", "to": [1.5, -2], "number": 7})");
  EXPECT_EQ(walk.number, 7);
  EXPECT_EQ(std::get<Walk>(walk.order).to, Eigen::Vector2d(1.5, -2));
  EXPECT_EQ(std::get<Sit>(parse_message(R"({"do": "sit", "chair": "sofa_0"})").order).chair, "sofa_0");
  const Touch touch =
      std::get<Touch>(parse_message(R"({"do": "contact", "hand": "right", "at": [1, 2, 3], "chair": "c"})").order);
  EXPECT_EQ(touch.hand, 1);
  EXPECT_EQ(*touch.at, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(touch.chair, "c");
  EXPECT_FALSE(std::get<Touch>(parse_message(R"({"do": "contact", "hand": "left", "at": null})").order).at);
  EXPECT_TRUE(std::get<Record>(parse_message(R"({"do": "record", "on": true})").order).on);
  EXPECT_EQ(std::get<Look>(parse_message(R"({"do": "futures", "on": false})").order).what, Preview::futures);
  const Take take =
      std::get<Take>(parse_message(R"({"do": "pose", "pose": "step", "at": [0, 1], "heading": -3})").order);
  EXPECT_EQ(take.pose, "step");
  EXPECT_EQ(take.heading, -3);
  for (const char* plain : {"draw", "stand", "restart"})
    EXPECT_NO_THROW(parse_message(std::string(R"({"do": ")") + plain + "\"}"));
}

TEST(Message, AnythingElseIsRefusedInOneLine) {
  const auto refusal = [](const std::string& text) { return refusal_of([&] { parse_message(text); }); };
  const std::vector<std::pair<std::string, std::string>> all = {
      {"", "is no JSON"},
      {"{", "is no JSON"},
      {std::string("{\"do\": \"walk\", \"to\": [NaN, 0]}"), "is no JSON"},
      {R"({"do": "walk", "to": [1e999, 0]})", "is no JSON"},
      {"\xff\xfe", "is no JSON"},
      {std::string(2000, '['), "is no JSON"},
      {"[1, 2]", "no JSON object"},
      {"{}", "has no \"do\""},
      {R"({"do": 3})", "do is no name"},
      {R"({"do": "fly"})", "there are contact, draw"},
      {R"({"do": "walk"})", "has no \"to\""},
      {R"({"do": "walk", "to": [1]})", "list of 2 numbers"},
      {R"({"do": "walk", "to": [1, "x"]})", "to is no number"},
      {R"({"do": "walk", "to": [1e30, 0]})", "beyond 1000"},
      {R"({"do": "walk", "to": {"x": 1}})", "list of 2 numbers"},
      {R"({"do": "contact", "hand": "foot", "at": null})", "neither left nor right"},
      {R"({"do": "contact", "hand": "left", "at": [1, 2]})", "list of 3 numbers"},
      {R"({"do": "record", "on": 1})", "neither true nor false"},
      {R"({"do": "sit", "chair": ")" + std::string(500, 'x') + "\"}", "chair is no name"},
      {R"({"do": "draw", "number": -1})", "number is no count"},
      {R"({"do": "draw", "number": 99999999999})", "number is no count"},
  };
  for (const auto& [text, part] : all) {
    EXPECT_THAT(refusal(text), HasSubstr(part)) << text.substr(0, 80);
    EXPECT_THAT(refusal(text), testing::StartsWith("message: ")) << text.substr(0, 80);
    EXPECT_THAT(refusal(text), testing::Not(HasSubstr("\n"))) << text.substr(0, 80);
  }
}

}  // namespace
}  // namespace inhabit::serve
