// Protects what is read: cameras (gravity, both directions of poses, refusals), numbered files, depth maps (several of
// a frame, jumps), masks of any kind of PNG. Whatever is damaged, of another size or not finite is one clear line.
#include "inhabit/reconstruct/images.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/io/atomic_file.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/png_mask.h"
#include "inhabit/reconstruct/camera.h"
#include "inhabit/reconstruct/depth_map.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::reconstruct {
namespace {

using ::testing::HasSubstr;

const std::string kLens = R"("fx": 200, "fy": 210, "cx": 79.5, "cy": 59.5, "width": 160, "height": 120)";

std::string camera_refusal(const std::string& text) {
  return refusal_of([&] { parse_camera(text, "camera.json"); });
}

TEST(ReconstructCamera, GravityBecomesDown) {
  // Without a pose the world is a level camera's own: +Y down. Upright it looks along -Z from the origin.
  const Camera level = parse_camera("{" + kLens + "}", "c");
  EXPECT_LT((level.upright * Eigen::Vector3d(0, 1, 0) + Eigen::Vector3d::UnitY()).norm(), 1e-12);
  // 30 degrees down: gravity in its axes is half ahead.
  const Camera down = parse_camera("{" + kLens + R"(, "gravity": [0, 1.7320508075688772, 1]})", "c");
  const Eigen::Vector3d ahead = down.to_world[0].linear() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(ahead.y(), -0.5, 1e-9);
  // The pixel in the middle of a level camera's image looks ahead.
  EXPECT_LT((level.ray(79.5, 59.5) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(ReconstructCamera, BothDirectionsOfAPoseAndItsOwnFile) {
  const std::string forth = R"("camera_to_world": [[0,0,1,2],[0,1,0,3],[-1,0,0,4]])";
  const std::string back = R"("world_to_camera": [[0,0,-1,4],[0,1,0,-3],[1,0,0,-2],[0,0,0,1]])";
  const Camera a = parse_camera("{" + kLens + "," + forth + "}", "c"),
               b = parse_camera("{" + kLens + "," + back + "}", "c"), c = parse_camera(camera_json(a), "c");
  EXPECT_TRUE(a.to_world[0].isApprox(b.to_world[0], 1e-9));
  EXPECT_TRUE(a.to_world[0].isApprox(c.to_world[0], 1e-9));
  const OnImage at = project(a, a.to_world[0].inverse(), a.to_world[0] * Eigen::Vector3d(0.2, 0.1, 2));
  EXPECT_EQ(at.column, std::lround(200 * 0.1 + 79.5));
  EXPECT_EQ(at.row, std::lround(210 * 0.05 + 59.5));
  EXPECT_FALSE(project(a, a.to_world[0].inverse(), a.to_world[0] * Eigen::Vector3d(0, 0, -2)).inside());
}

TEST(ReconstructCamera, RefusesWhatIsNone) {
  EXPECT_THAT(camera_refusal("{"), HasSubstr("camera.json"));
  EXPECT_THAT(camera_refusal("[]"), HasSubstr("no JSON object"));
  EXPECT_THAT(camera_refusal(R"({"fx": 1})"), HasSubstr("is missing"));
  EXPECT_THAT(camera_refusal("{" + kLens + R"(, "zoom": 2})"), HasSubstr("zoom"));
  EXPECT_THAT(camera_refusal("{" + kLens + R"(, "gravity": [0, 0, 0]})"), HasSubstr("no direction"));
  EXPECT_THAT(camera_refusal("{" + kLens + R"(, "gravity": [0, 1e999, 0]})"), HasSubstr("camera.json"));
  EXPECT_THAT(camera_refusal("{" + kLens + R"(, "camera_to_world": [[2,0,0,0],[0,2,0,0],[0,0,2,0]]})"),
              HasSubstr("no rotation"));
  EXPECT_THAT(camera_refusal("{" + kLens + R"(, "camera_to_world": [[1,0,0,1e9],[0,1,0,0],[0,0,1,0]]})"),
              HasSubstr("out of range"));
  EXPECT_THAT(camera_refusal("{" + kLens + R"(, "camera_to_world": [[1,0,0,0]]})"), HasSubstr("3 or 4 rows"));
  EXPECT_THAT(camera_refusal("{" + kLens + R"(, "motion": "there"})"), HasSubstr("'motion'"));
  EXPECT_THAT(camera_refusal(R"({"fx": 0, "fy": 1, "cx": 0, "cy": 0, "width": 10, "height": 10})"), HasSubstr("'fx'"));
  EXPECT_THAT(camera_refusal(R"({"fx": 9, "fy": 9, "cx": 0, "cy": 0, "width": 1e12, "height": 10})"),
              HasSubstr("'width'"));
}

TEST(ReconstructImages, NumbersTellFrames) {
  const TempFolder folder;
  for (const char* name : {"take2_cam1_7.npy", "take2_cam1_10.npy", "take2_cam1_8.npy"})
    write_npy(folder / name, torch::ones({2, 3}));
  const std::vector<NumberedFile> files = numbered_files({folder / "*.npy"});
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files[0].number, 7);
  EXPECT_EQ(files[2].number, 10);
  const ImageSequence depth = open_depth(files, 7, 2, 3);
  EXPECT_EQ(depth.frames, (std::vector<int64_t>{0, 1, 3}));
  EXPECT_EQ(depth.index_of(3), 2);
  EXPECT_EQ(depth.index_of(2), -1);
  write_npy(folder / "take2_cam1_07.npy", torch::ones({2, 3}));
  EXPECT_THAT(refusal_of([&] { numbered_files({folder / "*.npy"}); }), HasSubstr("have number 7"));
  write_npy(folder / "depth.npy", torch::ones({2, 3}));
  EXPECT_THAT(refusal_of([&] { numbered_files({folder / "depth.npy"}); }), HasSubstr("no number"));
  EXPECT_THAT(refusal_of([&] { numbered_files({folder / "nothing_*.npy"}); }), HasSubstr("no such file"));
}

TEST(ReconstructImages, DamagedDepthIsRefused) {
  const TempFolder folder;
  const auto refusal = [&](const torch::Tensor& map) {
    write_npy(folder / "d_1.npy", map);
    return refusal_of([&] { open_depth({{folder / "d_1.npy", 1}}, 1, 4, 5).read(0); });
  };
  EXPECT_EQ(refusal(torch::ones({4, 5})), "");
  EXPECT_EQ(refusal(torch::ones({3, 4, 5}, torch::kFloat64)), "");
  EXPECT_THAT(refusal(torch::full({4, 5}, NAN)), HasSubstr("not finite"));
  EXPECT_THAT(refusal(torch::full({4, 5}, std::numeric_limits<float>::infinity())), HasSubstr("not finite"));
  EXPECT_THAT(refusal(torch::full({4, 5}, 1e300, torch::kFloat64)), HasSubstr("not finite"));
  EXPECT_THAT(refusal(torch::ones({5, 4})), HasSubstr("(5, 4)"));
  EXPECT_THAT(refusal(torch::ones({0, 4, 5})), HasSubstr("(0, 4, 5)"));
  EXPECT_THAT(refusal(torch::ones({2, 2, 4, 5})), HasSubstr("(2, 2, 4, 5)"));
  write_npy(folder / "d_1.npy", torch::ones({4, 5}));
  std::filesystem::resize_file(folder / "d_1.npy", 150);
  EXPECT_THAT(refusal_of([&] { open_depth({{folder / "d_1.npy", 1}}, 1, 4, 5).read(0); }), HasSubstr("d_1.npy"));
}

TEST(ReconstructImages, MasksComeBackAndDamagedOnesAreRefused) {
  const TempFolder folder;
  torch::manual_seed(1);
  const torch::Tensor mask = torch::rand({30, 41}).gt(0.5);
  const std::string path = folder / "m.png";
  write_mask_png(path, mask);
  EXPECT_TRUE(read_mask_png(path, 30, 41).equal(mask));
  write_mask_png(folder / "none.png", torch::zeros({30, 41}, torch::kBool));
  EXPECT_FALSE(read_mask_png(folder / "none.png", 30, 41).any().item<bool>());
  EXPECT_THAT(refusal_of([&] { read_mask_png(path, 41, 30); }), HasSubstr("41 x 30 pixels"));
  const std::string bytes = read_whole_file(path, 1 << 20);
  for (size_t length = 0; length + 13 < bytes.size(); length += 7)  // the last 12 bytes only say that it ends
    EXPECT_NE(refusal_of([&] { parse_mask_png(bytes.substr(0, length), 30, 41, path); }), "") << length;
  std::string wrong = bytes;
  wrong[bytes.size() / 2] = static_cast<char>(wrong[bytes.size() / 2] ^ 0x55);
  EXPECT_THAT(refusal_of([&] { parse_mask_png(wrong, 30, 41, path); }), HasSubstr("no PNG image"));
}

TEST(ReconstructDepthMaps, AreSureWhereTheyAgree) {
  torch::Tensor maps = torch::arange(24, torch::kFloat32).view({1, 4, 6}).repeat({3, 1, 1}) + 1;
  maps[1][2][3] += 20;  // they differ here
  maps[2][0][0] = 0;    // unknown
  const DepthMap out = combined(maps, 0.05);
  torch::Tensor sure = torch::ones({4, 6}, torch::kBool);
  sure[2][3] = false, sure[0][0] = false;
  EXPECT_TRUE(out.sure.equal(sure));
  EXPECT_FLOAT_EQ(out.raw[1][1].item<float>(), 8);
  // Another unit and origin changes nothing of it.
  torch::Tensor other = maps * 1000 + 70;
  other[2][0][0] = 0;
  EXPECT_TRUE(combined(other, 0.05).sure.equal(sure));
}

TEST(ReconstructDepthMaps, AreUnknownBesideJumps) {
  DepthMap map{torch::ones({5, 8}), torch::ones({5, 8}, torch::kBool)};
  map.raw.slice(1, 4) = 3;
  map.raw[0][0] = -9;  // behind the camera
  const torch::Tensor metres = metric_depth(map, {0.5, 0.5}, 0.05);
  EXPECT_FLOAT_EQ(metres[4][2].item<float>(), 1);
  EXPECT_FLOAT_EQ(metres[4][6].item<float>(), 2);
  for (const int64_t unknown : {3, 4}) EXPECT_EQ(metres[4][unknown].item<float>(), 0);
  EXPECT_EQ(metres[0][0].item<float>(), 0);
}

}  // namespace
}  // namespace inhabit::reconstruct
