#include "inhabit/io/bvh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "io/replaced.h"
#include "refusal_of.h"
#include "shared.h"
#include "temp_folder.h"

using namespace inhabit;
using testing::HasSubstr;

namespace {

// A person of two bones, 90 cm and 40 cm, whose second bone hangs down and rotates about its start.
std::string small(const std::string& motion, const std::string& joint_channels = "3 Zrotation Xrotation Yrotation") {
  return "HIERARCHY\nROOT Hips\n{\n\tOFFSET 0.0 0.0 0.0\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation "
         "Xrotation "
         "Yrotation\n\tJOINT  Left Leg {\n\t\tOFFSET\t0  -90   0\n\t\tCHANNELS " +
         joint_channels + "\n\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0 -40 0\n\t\t}\n\t}\n}\n" + motion;
}
const std::string kTwoFrames =
    "MOTION\nFrames: 2\nFrame Time: 0.0333\n10 95 20 0 0 0  0 0 0\n10\t95  20 0 0 90   0  90 0\n\n";

std::string bvh_error(const std::string& text) {
  return refusal_of([&] { return parse_bvh(text, "walk.bvh"); });
}

void expect_near(const torch::Tensor& found, std::vector<float> expected, double tolerance = 1e-5) {
  EXPECT_TRUE(torch::allclose(found, torch::tensor(expected), 0, tolerance)) << found;
}

Clip random_clip(uint64_t seed, double largest_angle) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  Clip clip;
  clip.skeleton.names = standard_joint_names();
  clip.skeleton.parents = standard_parents();
  clip.skeleton.offsets = torch::empty({22, 3});
  clip.rotations = torch::empty({5, 22, 3});
  clip.trans = torch::empty({5, 3});
  for (torch::Tensor t : {clip.skeleton.offsets, clip.rotations, clip.trans})
    for (float *p = t.data_ptr<float>(), *end = p + t.numel(); p < end; ++p) *p = uniform(random);
  clip.skeleton.offsets *= 0.3;
  clip.rotations *= largest_angle;
  return clip;
}

}  // namespace

TEST(Bvh, ReadsPlacesRotationsAndUnits) {
  const SourceMotion motion = parse_bvh(small(kTwoFrames), "walk.bvh");
  EXPECT_EQ(motion.unit, "centimetres");
  EXPECT_THAT(motion.notes, testing::ElementsAre(HasSubstr("centimetres")));
  EXPECT_DOUBLE_EQ(motion.clip.rate, 30);  // 0.0333 is 1/30 in four digits
  EXPECT_EQ(motion.clip.skeleton.names, (std::vector<std::string>{"Hips", "Left Leg", "Left Leg_end"}));
  expect_near(motion.clip.joints[0].flatten(), {0.1F, 0.95F, 0.2F, 0.1F, 0.05F, 0.2F, 0.1F, -0.35F, 0.2F});
  // The root rotates 90 degrees about +Y, the leg 90 about its own x: the shin points along the leg frame's -z.
  expect_near(motion.clip.joints[1].flatten(), {0.1F, 0.95F, 0.2F, 0.1F, 0.05F, 0.2F, -0.3F, 0.05F, 0.2F});
}

TEST(Bvh, ChannelsMultiplyInTheOrderWritten) {
  const std::string rows = "MOTION\nFrames: 1\nFrame Time: 0.01\n0 0 0 0 0 0  90 90 0\n";
  // Zrotation Xrotation: R = Rz Rx, -y -> Rx -> -z -> Rz -> -z.
  expect_near(parse_bvh(small(rows), "a").clip.joints[0][2], {0, -0.9F, -0.4F});
  // Xrotation Zrotation: R = Rx Rz, -y -> Rz -> +x -> Rx -> +x.
  expect_near(parse_bvh(small(rows, "3 Xrotation Zrotation Yrotation"), "a").clip.joints[0][2], {0.4F, -0.9F, 0});
}

TEST(Bvh, PositionsOfAJointStandInPlaceOfItsOffset) {
  const std::string six = "6 Xposition Yposition Zposition Zrotation Xrotation Yrotation";
  const std::string text = small(
      "MOTION\nFrames: 3\nFrame Time: .01\n0 0 0 0 0 0 0 -80 0 0 0 0\n0 0 0 0 0 0 0 -85 0 0 0 0\n"
      "0 0 0 0 0 90 5 -95 0 0 0 0\n",
      six);
  const SourceMotion motion = parse_bvh(text, "a");
  EXPECT_THAT(motion.notes, testing::ElementsAre(HasSubstr("centimetres")));
  const TempFolder folder;
  write_atomically(folder / "a.bvh", text);
  Notes notes;
  read_clip(folder / "a.bvh", {}, &notes);
  EXPECT_THAT(notes, testing::IsSupersetOf({HasSubstr("centimetres"), HasSubstr("1 joints translate")}));
  expect_near(motion.clip.translations[2][1], {0.05F, -0.95F, 0});
  expect_near(motion.clip.skeleton.offsets[1], {0, -0.85F, 0});
  expect_near(motion.clip.joints[0][1], {0, -0.80F, 0});
  expect_near(motion.clip.joints[2][1], {0, -0.95F, -0.05F});
  expect_near(motion.clip.joints[2][2], {0, -1.35F, -0.05F});
}

TEST(Bvh, UnitsFollowThePersonOrTheGivenScale) {
  const auto scaled = [](const std::string& shank, const std::string& foot, std::optional<double> scale = {}) {
    return parse_bvh(replaced(replaced(small(kTwoFrames), "-90", shank), "-40", foot), "a", scale).metres_per_unit;
  };
  EXPECT_DOUBLE_EQ(scaled("-0.9", "-0.4"), 1);
  EXPECT_DOUBLE_EQ(scaled("-90", "-40"), 0.01);
  EXPECT_DOUBLE_EQ(scaled("-900", "-400"), 0.001);
  EXPECT_DOUBLE_EQ(scaled("-36", "-16"), 0.0254);
  EXPECT_DOUBLE_EQ(scaled("-16", "-7"), 0.0254 / 0.45);
  EXPECT_DOUBLE_EQ(scaled("-5000", "-4000", 0.002), 0.002);
  EXPECT_THROW(scaled("-90", "-40", -1), Error);
  EXPECT_THAT(bvh_error(replaced(small(kTwoFrames), "-90", "-90000")), HasSubstr("give the scale"));
  EXPECT_THAT(bvh_error(replaced(replaced(small(kTwoFrames), "-90", "0"), "-40", "0")), HasSubstr("give the scale"));
}

TEST(Bvh, RatesAreThoseTheDigitsStandFor) {
  const auto rate = [](const std::string& time) {
    return parse_bvh(replaced(small(kTwoFrames), "0.0333", time), "a").clip.rate;
  };
  EXPECT_DOUBLE_EQ(rate("0.0083333"), 120);
  EXPECT_DOUBLE_EQ(rate(".04"), 25);
  EXPECT_DOUBLE_EQ(rate("1"), 1);
  EXPECT_NEAR(rate("0.033367"), 29.97, 1e-3);
}

TEST(Bvh, SaysInOneLineWhatIsWrongAndWhere) {
  const std::string good = small(kTwoFrames);
  EXPECT_EQ(bvh_error(""), "walk.bvh: is empty");
  EXPECT_THAT(bvh_error(std::string("BVH\0\1\2", 6)), HasSubstr("binary"));
  EXPECT_THAT(bvh_error("solid cube\n facet\n"), HasSubstr("line 1: expected 'HIERARCHY', found 'solid'"));
  EXPECT_THAT(bvh_error(good.substr(0, 54)), HasSubstr("the file ends inside the hierarchy"));
  EXPECT_THAT(bvh_error(good.substr(0, good.find("MOTION"))), HasSubstr("expected 'MOTION'"));
  EXPECT_THAT(bvh_error(good.substr(0, good.size() - 12)), HasSubstr("line"));
  EXPECT_THAT(bvh_error(replaced(good, "Frames: 2", "Frames: 0")), HasSubstr("no frames"));
  EXPECT_THAT(bvh_error(replaced(good, "Frames: 2", "Frames: -2")), HasSubstr("line 16: '-2' is not in"));
  EXPECT_THAT(bvh_error(replaced(good, "Frames: 2", "Frames: 90000000")), HasSubstr("the file is shorter"));
  EXPECT_THAT(bvh_error(replaced(good, "Frames: 2", "Frames: 1")), HasSubstr("go on after the last of 1 frames"));
  EXPECT_THAT(bvh_error(replaced(good, "0.0333", "0")), HasSubstr("line 17: frame time 0"));
  EXPECT_THAT(bvh_error(replaced(good, "0.0333", "-0.0333")), HasSubstr("frame time"));
  EXPECT_THAT(bvh_error(replaced(good, "0.0333", "1e9")), HasSubstr("frame time"));
  EXPECT_THAT(bvh_error(replaced(good, "0.0333", "0,0333")),
              HasSubstr("line 17: '0,0333' has a comma where a decimal point is expected"));
  EXPECT_THAT(bvh_error(replaced(good, "10 95 20", "10 95,5 20")), HasSubstr("line 18: '95,5' has a comma"));
  EXPECT_THAT(bvh_error(replaced(good, "10 95 20", "10 nan 20")), HasSubstr("line 18: 'nan' is not a finite number"));
  EXPECT_THAT(bvh_error(replaced(good, "10 95 20", "10 1e99 20")), HasSubstr("line 18: '1e99' is too large"));
  EXPECT_THAT(bvh_error(replaced(good, "0  -90   0", "0 -inf 0")), HasSubstr("line 7"));
  EXPECT_THAT(bvh_error(replaced(good, "Xposition", "Wposition")), HasSubstr("line 5: unknown channel 'Wposition'"));
  EXPECT_THAT(bvh_error(replaced(good, "Yposition", "Xposition")), HasSubstr("one channel twice"));
  EXPECT_THAT(bvh_error(replaced(good, "CHANNELS 6", "CHANNELS 60")), HasSubstr("line 5: '60' is not in [0, 6]"));
  EXPECT_THAT(bvh_error(replaced(good, "End Site", "End")), HasSubstr("expected 'Site'"));
  EXPECT_THROW(read_bvh("/nowhere/walk.bvh"), Error);
}

TEST(Bvh, DeepAndCrowdedHierarchiesAreRefusedWithoutHarm) {
  std::string text = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (int k = 0; k < 5000; ++k) text += "JOINT j\n{\nOFFSET 0 1 0\n";
  EXPECT_THAT(bvh_error(text), HasSubstr("more than 2000 joints"));
}

TEST(Bvh, NamesOfOlderToolsBecomeUtf8) {
  std::string text = small(kTwoFrames);
  text.replace(text.find("Left Leg"), 8, "LinkerFu\xDF");
  EXPECT_EQ(parse_bvh(text, "a").clip.skeleton.names[1], "LinkerFu\xC3\x9F");
  text.replace(text.find("LinkerFu\xDF"), 9, "\xE5\xB7\xA6\xE8\x85\xBF");
  EXPECT_EQ(parse_bvh(text, "a").clip.skeleton.names[1], "\xE5\xB7\xA6\xE8\x85\xBF") << "UTF-8 stays";
}

TEST(Bvh, OneFrameIsAMotion) {
  EXPECT_EQ(parse_bvh(small("MOTION\nFrames: 1\nFrame Time: 1\n0 0 0 0 0 0 0 0 0"), "a").clip.frames(), 1);
}

TEST(Bvh, WhatIsWrittenIsReadBackAlike) {
  const TempFolder folder;
  const std::string path = folder / "a.bvh";
  for (const double angle : {1.5, 3.1}) {
    Clip clip = random_clip(7, angle);
    clip.rate = 30;
    clip.rotations[2] = 0;
    clip.rotations[3][4] = torch::tensor({0.0F, static_cast<float>(M_PI / 2), 0.0F});  // gimbal lock
    clip.rotations[3][5] = torch::tensor({0.0F, static_cast<float>(-M_PI / 2), 0.0F});
    // joints follow from the rotations; validate() needs them there
    clip.joints = torch::zeros({5, 22, 3});
    write_bvh(path, clip);
    const SourceMotion back = read_bvh(path, 0.01);
    EXPECT_EQ(back.clip.rate, 30);
    const SourceMotion metres = (write_bvh(path, clip, 1), read_bvh(path, 1.0));
    // Ours is in another order of joints (depth first) and has end sites.
    for (int j = 0; j < 22; ++j) {
      const int k = back.clip.skeleton.find(standard_joint_names()[static_cast<size_t>(j)]);
      ASSERT_GE(k, 0);
      EXPECT_TRUE(torch::allclose(back.clip.joints.select(1, k), metres.clip.joints.select(1, k), 0, 1e-5));
      if (j > 0) {
        EXPECT_TRUE(torch::allclose(back.clip.skeleton.offsets[k], clip.skeleton.offsets[j], 0, 1e-6));
      }
    }
    const torch::Tensor root = clip.trans + clip.skeleton.offsets[0];
    EXPECT_TRUE(torch::allclose(back.clip.root_path(), root, 0, 1e-6));
    // Rotations as such: their joints, posed.
    Clip again = back.clip;
    write_bvh(path, again);
    EXPECT_TRUE(
        torch::allclose(read_bvh(path, 0.01).clip.joints.slice(1, 0, 4), back.clip.joints.slice(1, 0, 4), 0, 1e-5));
  }
}

TEST(Bvh, EndSitesStayEndSites) {
  const TempFolder folder;
  Clip hanging = parse_bvh(small(kTwoFrames), "walk.bvh").clip;
  write_bvh(folder / "a.bvh", hanging);
  EXPECT_EQ(read_bvh(folder / "a.bvh").clip.skeleton.names, hanging.skeleton.names) << "as they were read";
  Clip moved = hanging;
  moved.rotations = hanging.rotations.clone();
  moved.rotations[1][2][0] = 0.5F;
  write_bvh(folder / "moved.bvh", moved);
  EXPECT_THAT(read_whole_file(folder / "moved.bvh"), testing::Not(HasSubstr("_end")))
      << "what has no channels in its file has none, however a network moves it";
  hanging.file = {};
  write_bvh(folder / "a.bvh", hanging);
  Clip again = read_bvh(folder / "a.bvh").clip;
  again.file = {};
  EXPECT_EQ(again.skeleton.names, (std::vector<std::string>{"Hips", "Left_Leg", "Left_Leg_end"}));
  expect_near(again.skeleton.offsets.flatten(), {0, 0, 0, 0, -0.9F, 0, 0, -0.4F, 0});
  EXPECT_TRUE(torch::allclose(again.joints, hanging.joints, 0, 1e-5));
  write_bvh(folder / "b.bvh", again);
  const auto hierarchy = [&](const char* name) {
    const std::string text = read_whole_file(folder / name);
    return text.substr(0, text.find("MOTION"));
  };
  EXPECT_EQ(hierarchy("b.bvh"), hierarchy("a.bvh"));
  // One that rotates has a rotation to keep.
  Clip turning = hanging;
  turning.rotations = hanging.rotations.clone();
  turning.rotations[1][2][0] = 0.5F;
  write_bvh(folder / "c.bvh", turning);
  EXPECT_NEAR(read_bvh(folder / "c.bvh").clip.rotations[1][2][0].item<float>(), 0.5F, 1e-5);
}

TEST(Bvh, PositionsAloneAreNotWritten) {
  Clip clip = random_clip(1, 1);
  clip.rotations = torch::Tensor();
  clip.joints = torch::zeros({5, 22, 3});
  const TempFolder folder;
  EXPECT_THROW(write_bvh(folder / "no.bvh", clip), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
}

TEST(Bvh, ARecordingIsAPersonOfPlausibleSize) {
  const std::string folder = shared_folder();
  if (folder.empty()) GTEST_SKIP() << "no recordings beside the project";
  const SourceMotion motion = read_bvh(folder + "/data/bvh/sample.bvh");
  EXPECT_EQ(motion.clip.frames(), 1300);
  EXPECT_DOUBLE_EQ(motion.clip.rate, 40);
  EXPECT_EQ(motion.unit, "centimetres");
  const torch::Tensor height = motion.clip.joints.select(2, 1).amax(1) - motion.clip.joints.select(2, 1).amin(1);
  EXPECT_NEAR(height.median().item<double>(), 1.7, 0.25);
}
