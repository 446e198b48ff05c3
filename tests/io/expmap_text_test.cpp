#include "inhabit/io/expmap_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "inhabit/io/safetensors.h"
#include "refusal_of.h"
#include "shared.h"

using namespace inhabit;

namespace {

std::string row(int columns, const std::string& value = "0.1", const std::string& separator = ",") {
  std::string out;
  for (int k = 0; k < columns; ++k) out += (k ? separator : "") + value;
  return out + "\n";
}

std::string text_error(const std::string& text) {
  return refusal_of([&] { return parse_expmap_channels(text, "walk.txt"); });
}

}  // namespace

TEST(ExpmapText, ReadsCommasBlanksAndWindowsLineEnds) {
  EXPECT_EQ(parse_expmap_channels(row(117) + row(117), "a").sizes(), (std::vector<int64_t>{2, 117}));
  EXPECT_EQ(parse_expmap_channels(row(99, "+1e-1", "  "), "a").sizes(), (std::vector<int64_t>{1, 99}));
  EXPECT_EQ(parse_expmap_channels("\n" + row(99, "-0", " ,\t") + "\r\n\r\n", "a").sizes(),
            (std::vector<int64_t>{1, 99}));
}

TEST(ExpmapText, SaysInOneLineWhatIsWrongAndWhere) {
  EXPECT_EQ(text_error(""), "walk.txt: holds no frames");
  EXPECT_EQ(text_error("\n \n"), "walk.txt: holds no frames");
  EXPECT_THAT(text_error(row(98)), testing::HasSubstr("walk.txt: line 1: 98 columns"));
  EXPECT_THAT(text_error(row(117) + row(116)), testing::HasSubstr("line 2: 116 columns, the first line has 117"));
  EXPECT_THAT(text_error(row(117) + row(117).substr(0, 200)), testing::HasSubstr("line 2"));
  EXPECT_THAT(text_error(row(234, "1")), testing::HasSubstr("decimal points"));
  EXPECT_THAT(text_error(row(117, "0,1", ";")), testing::HasSubstr("line 1"));
  EXPECT_THAT(text_error(row(117) + row(117, "nan")), testing::HasSubstr("line 2: 'nan' is not a finite number"));
  EXPECT_THAT(text_error(row(117, "inf")), testing::HasSubstr("line 1"));
  EXPECT_THAT(text_error(row(117, "1e60")), testing::HasSubstr("too large"));
  EXPECT_THAT(text_error(row(117, "")), testing::HasSubstr("line 1: '' is not a number"));
  EXPECT_THAT(text_error(row(200000)), testing::HasSubstr("more than 1000 columns"));
  EXPECT_THAT(text_error(std::string("\x7f"
                                     "ELF\0\0\1",
                                     7)),
              testing::HasSubstr("binary"));
  EXPECT_THAT(text_error("hello\nworld\n"), testing::HasSubstr("line 1: 'hello' is not a number"));
  EXPECT_THROW(read_expmap_channels("/nowhere/walk.txt"), Error);
}

TEST(ExpmapText, OneFrameIsAMotion) {
  const SourceMotion motion = expmap_motion(parse_expmap_channels(row(117, "0"), "a"), "a");
  EXPECT_EQ(motion.clip.frames(), 1);
  EXPECT_EQ(motion.clip.skeleton.size(), 38);
  // At rest the CMU person's left toes are left of, below and before the root.
  const torch::Tensor toes = motion.clip.joints[0][motion.clip.skeleton.find("LeftToeBase")];
  EXPECT_GT(toes[0].item<float>(), 0.3F);
  EXPECT_LT(toes[1].item<float>(), -0.85F);
  EXPECT_GT(toes[2].item<float>(), 0.1F);
}

TEST(ExpmapText, Human36MRootColumnsAreStepsInTheRootsFrame) {
  // Three rows, each 90 degrees to the left (about +Y) and 20 mm ahead (+Z) as seen before the rotation.
  torch::Tensor channels = torch::zeros({3, 99});
  channels.slice(0, 1).select(1, 2) = 20;
  channels.slice(0, 1).select(1, 4) = -M_PI / 2;
  const SourceMotion motion = expmap_motion(channels, "steps");
  const torch::Tensor path = motion.clip.root_path();
  EXPECT_TRUE(torch::allclose(path[1], torch::tensor({0.0F, 0.0F, 0.02F}), 0, 1e-6));
  EXPECT_TRUE(torch::allclose(path[2], torch::tensor({0.02F, 0.0F, 0.02F}), 0, 1e-6)) << path;
  EXPECT_EQ(motion.clip.rate, 50);
}

TEST(ExpmapText, TheRestRowIsLeftOutOfMotionButNotOfChannels) {
  const std::string folder = shared_folder();
  if (folder.empty()) GTEST_SKIP() << "no recordings beside the project";
  const std::string path = folder + "/data/cmu/train/walking/walking_1.txt";
  const torch::Tensor channels = read_expmap_channels(path);
  const SourceMotion motion = read_expmap_text(path);
  EXPECT_EQ(channels.size(0), 344);
  ASSERT_EQ(motion.clip.frames(), 343);
  EXPECT_EQ(motion.notes.size(), 1U);
  // No frame jumps: at 120 Hz no joint of a walker goes faster than 8 m/s.
  const torch::Tensor steps = motion.clip.joints.diff(1, 0).norm(2, -1);
  EXPECT_LT(steps.max().item<float>(), 8.0F / 120);
  // A person walks: 0.9 to 1.3 m/s over the ground, the root 0.9 to 1.05 m high.
  const torch::Tensor path_ends = motion.clip.root_path();
  const double speed = (path_ends[-1] - path_ends[0]).norm().item<double>() / motion.clip.seconds();
  EXPECT_GT(speed, 0.9);
  EXPECT_LT(speed, 1.4);
}

TEST(ExpmapText, JointPositionsMatchThePublishedLoaders) {
  for (const auto& [kind, name] : {std::pair{ExpmapSkeleton::cmu, "cmu"}, {ExpmapSkeleton::h36m, "h36m"}}) {
    const SafeTensors file = read_safetensors(std::string(INHABIT_SOURCE_DIR "/tests/data/parity/") + name +
                                              "_forward_kinematics.safetensors");
    const torch::Tensor expected = file.tensors.at("out.joints");
    const torch::Tensor found = expmap_joint_positions(kind, file.tensors.at("in.expmap"));
    EXPECT_LT((found - expected).abs().max().item<double>() / expected.abs().max().item<double>(), 1e-5) << name;
  }
}
