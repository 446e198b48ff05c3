#include "inhabit/io/asf_amc.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "inhabit/error.h"
#include "inhabit/io/expmap_text.h"
#include "io/replaced.h"
#include "refusal_of.h"
#include "shared.h"
#include "temp_folder.h"

using namespace inhabit;
using testing::HasSubstr;

namespace {

// Root, a back bone up and a leg down with a hinge about an oblique axis; 1 unit = 0.0564444 m.
const std::string kAsf =
    ":version 1.10\n:name VICON\n:units\n  mass 1.0\n  length 0.45\n  angle deg\n:documentation\n   text: of no "
    "use\n:root\n"
    "   order TX TY TZ RX RY RZ\n   axis XYZ\n   position 0 0 0\n   orientation 0 0 0\n:bonedata\n"
    "  begin\n     id 1\n     name back\n     direction 0 1 0\n     length 8\n     axis 0 0 0  XYZ\n    dof rx ry rz\n"
    "    limits (-20.0 45.0)\n           (-30.0 30.0)\n           (-30.0 30.0)\n  end\n"
    "  begin\n     id 2\n     name thigh\n     direction 0 -1 0\n     length 8\n     axis 0 0 0  XYZ\n  end\n"
    "  begin\n     id 3\n     name shin\n     direction 0 -1 0\n     length 8\n     axis 0 90 0  XYZ\n    dof rx\n  "
    "end\n"
    ":hierarchy\n  begin\n    root back thigh\n    thigh shin\n  end\n";
const std::string kAmc =
    "#!OML:ASF somewhere.ASF\n:FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 16 2 0 0 0\nback 0 0 0\nshin 0\n"
    "2\nroot 1 16 2 0 90 0\nback 90 0 90\nshin 90\n";

std::string asf_error(const std::string& asf, const std::string& amc) {
  return refusal_of([&] { return parse_asf_amc(asf, "a.asf", amc, "a.amc"); });
}

}  // namespace

TEST(AsfAmc, BonesRotateAboutTheirOwnAxes) {
  const SourceMotion motion = parse_asf_amc(kAsf, "a.asf", kAmc, "a.amc");
  const double unit = 0.0254 / 0.45;
  EXPECT_DOUBLE_EQ(motion.metres_per_unit, unit);
  EXPECT_DOUBLE_EQ(motion.clip.rate, 120);
  EXPECT_EQ(motion.clip.skeleton.names,
            (std::vector<std::string>{"root", "back", "back_end", "thigh", "shin", "shin_end"}));
  const torch::Tensor found = motion.clip.joints / unit;
  const auto at = [&](int frame, int joint, std::vector<float> expected) {
    EXPECT_TRUE(torch::allclose(found[frame][joint], torch::tensor(expected), 0, 1e-4))
        << frame << " " << joint << " " << found[frame][joint];
  };
  at(0, 0, {1, 16, 2});
  at(0, 2, {1, 24, 2});
  at(0, 5, {1, 0, 2});
  // The root's rotation by 90 degrees about +Y takes +Z to +X. The back's x rotation comes first (up -> ahead), then z
  // leaves ahead alone.
  at(1, 2, {9, 16, 2});
  // The shin's own x axis is -z of the world (axis 0 90 0): down goes to -x, which the root rotates to +z.
  at(1, 4, {1, 8, 2});
  at(1, 5, {1, 8, 10});
}

TEST(AsfAmc, SaysInOneLineWhatIsWrongAndWhere) {
  EXPECT_THAT(asf_error("", kAmc), HasSubstr("a.asf: holds no bones"));
  EXPECT_THAT(asf_error(kAsf, ""), HasSubstr("a.amc: holds no frames"));
  EXPECT_THAT(asf_error(std::string("\0\1", 2), kAmc), HasSubstr("a.asf: is binary"));
  EXPECT_THAT(asf_error(kAsf, "hello there\n"), HasSubstr("a.amc: line 1: expected the number of the first frame"));
  EXPECT_THAT(asf_error(kAsf, kAmc.substr(0, kAmc.size() - 9)), HasSubstr("frame 2 lacks bone 'shin'"));
  EXPECT_THAT(asf_error(kAsf, kAmc.substr(0, kAmc.size() - 3)), HasSubstr("bone 'shin' needs 1 numbers"));
  EXPECT_THAT(asf_error(kAsf, replaced(kAmc, "shin 0", "shin 0 3")), HasSubstr("line 7: bone 'shin' has more than 1"));
  EXPECT_THAT(asf_error(kAsf, replaced(kAmc, "shin 0", "tail 0")), HasSubstr("line 7: bone 'tail' is not in a.asf"));
  EXPECT_THAT(asf_error(kAsf, replaced(kAmc, "shin 0", "shin 0,5")), HasSubstr("line 7: '0,5' has a comma"));
  EXPECT_THAT(asf_error(kAsf, replaced(kAmc, "shin 0", "shin NaN")), HasSubstr("line 7: 'NaN'"));
  EXPECT_THAT(asf_error(kAsf, replaced(kAmc, "shin 0", "back 0 0 0")), HasSubstr("stands twice"));
  EXPECT_THAT(asf_error(replaced(kAsf, "thigh shin", "shin thigh"), kAmc), HasSubstr("hangs on two others"));
  EXPECT_THAT(asf_error(replaced(kAsf, "root back thigh", "root back"), kAmc), HasSubstr("does not hang on the root"));
  EXPECT_THAT(
      asf_error(replaced(kAsf, "    root back thigh\n    thigh shin", "    root back\n    thigh shin\n    shin thigh"),
                kAmc),
      HasSubstr("does not hang on the root (or on a cycle)"));
  EXPECT_THAT(asf_error(replaced(kAsf, "thigh shin", "thigh root"), kAmc), HasSubstr("the root cannot hang"));
  EXPECT_THAT(asf_error(replaced(kAsf, "thigh shin", "thigh fin"), kAmc), HasSubstr("unknown bone 'fin'"));
  EXPECT_THAT(asf_error(replaced(kAsf, "name shin", "name back"), kAmc), HasSubstr("two bones are called 'back'"));
  EXPECT_THAT(asf_error(replaced(kAsf, "dof rx ry rz", "dof rx rq"), kAmc), HasSubstr("'rq' is no degree of freedom"));
  EXPECT_THAT(asf_error(replaced(kAsf, "length 8", "length 8,5"), kAmc), HasSubstr("has a comma"));
  EXPECT_THAT(asf_error(replaced(kAsf, "length 0.45", "length 0"), kAmc), HasSubstr("must be positive"));
  EXPECT_THAT(asf_error(kAsf.substr(0, kAsf.find("id 3")), kAmc), HasSubstr("the file ends inside a bone"));
}

TEST(AsfAmc, TheSkeletonIsFoundBesideTheMotion) {
  const TempFolder folder;
  const auto write = [&](const std::string& name, const std::string& text) { std::ofstream(folder / name) << text; };
  write("07_02.amc", kAmc);
  EXPECT_THROW(find_asf(folder / "07_02.amc"), Error);
  write("other.asf", kAsf);
  EXPECT_EQ(find_asf(folder / "07_02.amc"), folder / "other.asf");
  write("08.asf", kAsf);
  EXPECT_THROW(find_asf(folder / "07_02.amc"), Error);
  write("07.asf", kAsf);
  EXPECT_EQ(find_asf(folder / "07_02.amc"), folder / "07.asf");
  EXPECT_EQ(read_asf_amc(folder / "07_02.amc").clip.frames(), 2);
  EXPECT_EQ(read_asf_amc(folder / "07_02.amc", folder / "other.asf").clip.frames(), 2);
  EXPECT_THROW(read_asf_amc(folder / "none.amc"), Error);
}

TEST(AsfAmc, AgreesWithTheSameRecordingAsExponentialMaps) {
  const std::string folder = shared_folder();
  if (folder.empty()) GTEST_SKIP() << "no recordings beside the project";
  // walking_1 is CMU's subject 2, trial 1, on a skeleton whose bones differ by up to some centimetres.
  const Clip amc = read_asf_amc(folder + "/data/asf_amc/02_01.amc").clip;
  const Clip text = read_expmap_text(folder + "/data/cmu/train/walking/walking_1.txt").clip;
  ASSERT_EQ(amc.frames(), text.frames());
  EXPECT_TRUE(torch::allclose(amc.root_path(), text.root_path(), 0, 1e-4));
  for (const auto& [bone, joint] : {std::pair{"ltibia", "LeftLeg"}, {"lfoot", "LeftFoot"}, {"rtoes", "RightToeBase"}}) {
    const torch::Tensor apart =
        (amc.joints.select(1, amc.skeleton.find(bone)) - text.joints.select(1, text.skeleton.find(joint))).norm(2, -1);
    EXPECT_LT(apart.max().item<double>(), 0.06) << bone;
  }
}
