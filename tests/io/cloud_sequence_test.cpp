// Protects the reader of point clouds by frame: folders in the order of their numbers, both forms of .npz, axes and
// units, and one clear line for what is no sequence.
#include "inhabit/io/cloud_sequence.h"

#include <gtest/gtest.h>

#include <fstream>

#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using torch::Tensor;

Tensor cloud_of(int64_t count, double first) {
  return torch::arange(3 * count, torch::kFloat32).view({count, 3}) + first;
}

void write_clouds(const TempFolder& folder, const std::vector<std::string>& names) {
  for (size_t i = 0; i < names.size(); ++i) write_npy(folder / names[i], cloud_of(4, 100 * static_cast<double>(i)));
}

std::string folder_refusal(const TempFolder& folder) {
  return refusal_of([&] { open_clouds(folder.path.string()); });
}

TEST(CloudSequence, FoldersAreInTheOrderOfTheirNumbers) {
  const TempFolder folder;
  write_clouds(folder, {"cloud_8.npy", "cloud_9.npy", "cloud_10.npy"});
  std::ofstream(folder / "readme.txt") << "not a cloud";
  const CloudSequence clouds = open_clouds(folder.path.string());
  ASSERT_EQ(clouds.frames, 3);
  for (int64_t t = 0; t < 3; ++t) EXPECT_EQ(clouds.read(t)[0][0].item<float>(), 100.F * static_cast<float>(t));
}

TEST(CloudSequence, TheNumberThatCountsMayStandAmongOthers) {
  const TempFolder folder;  // as PROX names its frames: number and time
  write_clouds(folder, {"s001_frame_00009__00.00.00.300.npy", "s001_frame_00010__00.00.00.333.npy",
                        "s001_frame_00011__00.00.00.366.npy"});
  const CloudSequence clouds = open_clouds(folder.path.string());
  ASSERT_EQ(clouds.frames, 3);
  EXPECT_EQ(clouds.read(1)[0][0].item<float>(), 100.F);
}

TEST(CloudSequence, BothFormsOfNpz) {
  const TempFolder folder;
  Npz npz;
  npz.tensors["points"] = torch::stack({cloud_of(5, 0), cloud_of(5, 50)});
  write_npz(folder / "even.npz", npz);
  EXPECT_EQ(open_clouds(folder / "even.npz").frames, 2);
  EXPECT_TRUE(torch::equal(open_clouds(folder / "even.npz").read(1), cloud_of(5, 50)));
  npz.tensors["points"] = torch::cat({cloud_of(5, 0), cloud_of(2, 50)});
  npz.tensors["counts"] = torch::tensor({5, 2});
  write_npz(folder / "ragged.npz", npz);
  EXPECT_TRUE(torch::equal(open_clouds(folder / "ragged.npz").read(1), cloud_of(2, 50)));
}

TEST(CloudSequence, UnitsAndAxesAreThoseAskedFor) {
  const TempFolder folder;
  Npz npz;
  npz.tensors["points"] = torch::tensor({1000.F, 2000.F, 3000.F}).view({1, 1, 3});
  write_npz(folder / "mm.npz", npz);
  const Tensor at = open_clouds(folder / "mm.npz", {0.001, true}).read(0);
  EXPECT_TRUE(torch::allclose(at, torch::tensor({1.F, 3.F, -2.F}).view({1, 3})));
}

TEST(CloudSequence, RefusesWhatIsNoSequence) {
  const TempFolder folder;
  EXPECT_NE(folder_refusal(folder).find("no point clouds"), std::string::npos);
  write_clouds(folder, {"a_1.npy", "a_2.npy", "a_4.npy"});
  EXPECT_NE(folder_refusal(folder).find("after a_2 comes a_4"), std::string::npos) << folder_refusal(folder);
  std::ofstream(folder / "a_3.ply") << "ply";
  EXPECT_NE(folder_refusal(folder).find("both .npy and .ply"), std::string::npos) << folder_refusal(folder);
  std::filesystem::remove(folder / "a_3.ply");
  write_clouds(folder, {"other.npy"});
  EXPECT_NE(folder_refusal(folder).find("not numbered alike"), std::string::npos) << folder_refusal(folder);

  Npz npz;
  const auto refusal = [&](const std::function<void()>& change) {
    npz = {};
    npz.tensors["points"] = torch::stack({cloud_of(5, 0), cloud_of(5, 50)});
    change();
    return refusal_of([&] {
      const CloudSequence clouds = clouds_from_npz(npz, "file.npz");
      for (int64_t t = 0; t < clouds.frames; ++t) clouds.read(t);
    });
  };
  EXPECT_EQ(refusal([] {}), "");
  EXPECT_NE(refusal([&] { npz.tensors["points"][1][3][0] = NAN; }).find("file.npz, frame 1: a point is not finite"),
            std::string::npos);
  EXPECT_NE(refusal([&] { npz.tensors["points"] = cloud_of(5, 0); }).find("(T, N, 3)"), std::string::npos);
  EXPECT_NE(refusal([&] {
              npz.tensors["points"] = torch::zeros({2, 5, 2});
            }).find("three coordinates"),
            std::string::npos);
  EXPECT_NE(refusal([&] {
              npz.tensors["points"] = torch::zeros({2, 0, 3});
            }).find("frame 0: holds no points"),
            std::string::npos);
  const auto counted = [&](const Tensor& counts) {
    return refusal([&] {
      npz.tensors["points"] = cloud_of(7, 0);
      npz.tensors["counts"] = counts;
    });
  };
  EXPECT_NE(counted(torch::tensor({5, 1})).find("do not add up to the 7 points"), std::string::npos);
  EXPECT_NE(counted(torch::tensor({8, -1})).find("do not add up"), std::string::npos);
  EXPECT_NE(counted(torch::tensor({7.F})).find("whole numbers"), std::string::npos);
  EXPECT_NE(counted(torch::tensor({7, 0})).find("frame 1: holds no points"), std::string::npos);
  npz.tensors.clear();
  EXPECT_NE(refusal_of([&] { clouds_from_npz(npz, "file.npz"); }).find("points"), std::string::npos);
  EXPECT_NE(refusal_of([] { open_clouds("nowhere.npz"); }).find("nowhere.npz"), std::string::npos);
  EXPECT_NE(refusal_of([] { open_clouds("nowhere"); }).find("nowhere"), std::string::npos);
}

}  // namespace
}  // namespace inhabit
