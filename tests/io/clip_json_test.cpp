#include "inhabit/io/clip_json.h"

#include <gtest/gtest.h>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

Clip small_clip() {
  Clip clip;
  clip.skeleton = {{"root", "a \"quoted\" name", "b"}, {-1, 0, 1}, torch::randn({3, 3})};
  clip.rate = 29.97;
  clip.rotations = torch::randn({4, 3, 3});
  clip.trans = torch::randn({4, 3}) * 1e-7;
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  clip.action_names = {"walk", "sit"};
  clip.action = torch::tensor({0, 0, 1, 1}, torch::kInt64);
  clip.contact = torch::ones({4, 3});
  return clip;
}

std::string json_error(const std::string& text) {
  return refusal_of([&] { return parse_clip_json(text, "file"); });
}

TEST(ClipJson, KeepsEveryBit) {
  torch::manual_seed(1);
  const Clip clip = small_clip();
  const Clip back = parse_clip_json(clip_json(clip, "x"), "x");
  EXPECT_EQ(back.rate, clip.rate);
  EXPECT_EQ(back.skeleton.names, clip.skeleton.names);
  EXPECT_EQ(back.skeleton.parents, clip.skeleton.parents);
  EXPECT_EQ(back.action_names, clip.action_names);
  EXPECT_TRUE(torch::equal(back.skeleton.offsets, clip.skeleton.offsets));
  EXPECT_TRUE(torch::equal(back.joints, clip.joints));
  EXPECT_TRUE(torch::equal(back.rotations, clip.rotations));
  EXPECT_TRUE(torch::equal(back.trans, clip.trans));
  EXPECT_TRUE(torch::equal(back.action, clip.action));
  EXPECT_TRUE(torch::equal(back.contact, clip.contact));
  EXPECT_FALSE(back.betas.defined());
}

TEST(ClipJson, JointsFollowFromRotations) {
  torch::manual_seed(2);
  const Clip clip = small_clip();
  std::string text = clip_json(clip, "x");
  const size_t begin = text.find("\"joints\": "), end = text.find("\"rotations\": ");
  text.erase(begin, end - begin);
  EXPECT_TRUE(torch::allclose(parse_clip_json(text, "x").joints, clip.joints));
}

TEST(ClipJson, BadFilesAreNamedWithTheirFault) {
  const std::string good = clip_json(small_clip(), "x");
  auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return json_error(text);
  };
  EXPECT_NE(json_error("").find("not JSON"), std::string::npos);
  EXPECT_NE(json_error("[1, 2]").find("not a clip"), std::string::npos);
  EXPECT_NE(json_error(good.substr(0, good.size() / 2)).find("cut short"), std::string::npos);
  EXPECT_NE(changed("29.97", "-1"), "");
  EXPECT_NE(changed("29.97", "\"fast\"").find("rate"), std::string::npos);
  EXPECT_NE(changed("\"parent\": 1", "\"parent\": 7").find("parent"), std::string::npos);
  EXPECT_NE(changed("\"joints\": [[[", "\"joints\": [[[0,").find("length"), std::string::npos);
  EXPECT_NE(changed("\"joints\": [[[", "\"joints\": [[[\"x\",").find("joints"), std::string::npos);
  const auto says = [](const std::string& why, const std::string& part) {
    EXPECT_NE(why.find(part), std::string::npos) << why;
  };
  says(changed("29.97", "NaN"), "line 5 has NaN or Infinity");
  says(changed("29.97", "-Infinity"), "line 5 has NaN or Infinity");
  says(changed("29.97", "1e400"), "too large");
  says(changed("\"version\": 1", "\"version\": 2"), "version");
  says(changed("\"frames\": 4", "\"frames\": 5"), "holds 4 frames, \"frames\" says 5");
  says(changed("\"name\": \"b\"", "\"name\": \"root\""), "one name");
  EXPECT_NE(json_error(std::string(100000, '[')), "");
  EXPECT_NE(json_error("{\"format\": \"inhabit clip\", \"skeleton\": [], \"rate\": 30}"), "");
}

}  // namespace
}  // namespace inhabit
