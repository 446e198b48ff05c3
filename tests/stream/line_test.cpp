// Protects the reader of a stream's lines against whatever comes, and what it says of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/io/pose_line.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& line) {
  return refusal_of([&] { parse_stream_line(line); });
}

TEST(StreamLine, PosesWithAndWithoutAPersonAndUnseenJoints) {
  auto line = std::get<PoseLine>(
      parse_stream_line(R"({"time":1.5,"person":"anna","joints":[[1,2,3],null,[4,null,-6.5e-1]],"confidence":0.4})"));
  EXPECT_EQ(line.time, 1.5);
  EXPECT_EQ(line.person, "anna");
  ASSERT_EQ(line.joints.sizes(), torch::IntArrayRef({3, 3}));
  EXPECT_TRUE(torch::equal(line.joints[0], torch::tensor({1.F, 2.F, 3.F})));
  EXPECT_TRUE(torch::isnan(line.joints[1]).all().item<bool>());
  EXPECT_TRUE(torch::isnan(line.joints[2][1]).item<bool>());
  EXPECT_FLOAT_EQ(line.joints[2][2].item<float>(), -0.65F);
  line = std::get<PoseLine>(parse_stream_line(R"({"time":-3,"person":17,"joints":[[0,0,0]]})"));
  EXPECT_EQ(line.person, "17");
  EXPECT_EQ(std::get<PoseLine>(parse_stream_line(R"({"time":0,"joints":[null]})")).person, "person");
}

TEST(StreamLine, Names) {
  const auto names = std::get<JointNames>(parse_stream_line(R"({"names":["root","b"],"parents":[-1,0]})"));
  EXPECT_THAT(names.names, testing::ElementsAre("root", "b"));
  EXPECT_THAT(names.parents, testing::ElementsAre(-1, 0));
  EXPECT_TRUE(std::get<JointNames>(parse_stream_line(R"({"names":["root"]})")).parents.empty());
}

TEST(StreamLine, EverythingElseIsRefusedInOneLine) {
  EXPECT_THAT(refusal(""), HasSubstr("empty"));
  EXPECT_THAT(refusal("hello"), HasSubstr("not JSON"));
  EXPECT_THAT(refusal(R"({"time":1,"joints":[[1,2,3])"), HasSubstr("cut short"));
  EXPECT_THAT(refusal(R"({"time":1,"joints":[[NaN,2,3]]})"), HasSubstr("NaN"));
  EXPECT_THAT(refusal(R"({"time":1e999,"joints":[[1,2,3]]})"), HasSubstr("too large"));
  EXPECT_THAT(refusal("[1,2]"), HasSubstr("no JSON object"));
  EXPECT_THAT(refusal(R"({"joints":[[1,2,3]]})"), HasSubstr("time"));
  EXPECT_THAT(refusal(R"({"time":"now","joints":[[1,2,3]]})"), HasSubstr("time"));
  EXPECT_THAT(refusal(R"({"time":1})"), HasSubstr("joints"));
  EXPECT_THAT(refusal(R"({"time":1,"joints":[]})"), HasSubstr("joints"));
  EXPECT_THAT(refusal(R"({"time":1,"joints":{}})"), HasSubstr("joints"));
  EXPECT_THAT(refusal(R"({"time":1,"joints":[[1,2]]})"), HasSubstr("three numbers"));
  EXPECT_THAT(refusal(R"({"time":1,"joints":[[1,2,"3"]]})"), HasSubstr("three numbers"));
  EXPECT_THAT(refusal(R"({"time":1,"joints":[[1,2,1e5]]})"), HasSubstr("10 km"));
  EXPECT_THAT(refusal(R"({"time":1,"person":"","joints":[[1,2,3]]})"), HasSubstr("person"));
  EXPECT_THAT(refusal(R"({"time":1,"person":[1],"joints":[[1,2,3]]})"), HasSubstr("person"));
  EXPECT_THAT(refusal(R"({"time":1,"person":"a\nb","joints":[[1,2,3]]})"), HasSubstr("control character"));
  EXPECT_THAT(refusal(R"({"time":1,"person":")" + std::string(65, 'x') + R"(","joints":[[1,2,3]]})"), HasSubstr("64"));
  EXPECT_THAT(refusal(R"({"names":[]})"), HasSubstr("names"));
  EXPECT_THAT(refusal(R"({"names":["a",3.5]})"), HasSubstr("name"));
  EXPECT_THAT(refusal(R"({"names":["a"],"parents":[99999999999]})"), HasSubstr("parent"));
  EXPECT_NE(refusal("{\"time\":1,\"joints\":" + std::string(200000, '[')), "") << "nothing is nested so deeply";
  std::string many = R"({"time":1,"joints":[null)";
  for (int i = 0; i < 1000; ++i) many += ",null";
  EXPECT_THAT(refusal(many + "]}"), HasSubstr("1 to 1000"));
}

TEST(StreamLine, PlacesAreWrittenToATenthOfAMillimetre) {
  std::string text;
  append_places(text, torch::tensor({1.00004F, -0.25F, NAN, 0.F, 1234.5F, -2e-5F}).view({1, 2, 3}));
  EXPECT_EQ(text, "[[[1,-0.25,null],[0,1234.5,0]]]");
}

}  // namespace
}  // namespace inhabit
