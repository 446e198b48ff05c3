// Protects `inhabit import` of people in scenes: they are where they were in their scenes, and touch what they touched.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "data/import_scene_folders.h"
#include "data/imported.h"
#include "inhabit/io/png_mask.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/scene/query.h"
#include "refusal_of.h"
#include "shared.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using ::testing::Contains;

TEST(ImportProx, PutsPeopleIntoTheirScenes) {
  const TempFolder folder;
  write_prox(folder / "prox", "MPH16", 120, 330);
  write_prox(folder / "prox", "N0Sofa", 120, 330);
  std::filesystem::create_directories(folder / "prox/fittings/Werkraum_03301_01/results");
  const ImportSet set = open_import_set("prox", folder / "prox");
  EXPECT_THAT(set.missing, Contains("scenes/Werkraum.ply"));
  const ImportResult r = import_dataset(set, folder / "out");
  ASSERT_EQ(r.dataset.clips.size(), 2U);
  EXPECT_EQ(r.skipped.size(), 1U);
  const DatasetClip &test = clip_called(r.dataset, "MPH16_00162_01"),
                    &train = clip_called(r.dataset, "N0Sofa_00162_01");
  EXPECT_EQ(test.split + " " + train.split, "test train");
  const Clip clip = load_clip(r.dataset, test), should = sitter(120, 330).clip;
  EXPECT_EQ(clip.frames(), 210);  // three that were missing lie between the others
  EXPECT_EQ(clip.gender, "female");
  EXPECT_LT(off(clip, should), 0.02);
  EXPECT_LT(turned(slice(clip, 0, 40), slice(should, 0, 40)), 1e-3);
  EXPECT_LT(turned(slice(clip, 40, 43), slice(should, 40, 43)), 0.2);
  EXPECT_LT(turned(slice(clip, 43, 210), slice(should, 43, 210)), 1e-3);
  // The room was a metre lower and +Z up: it is again as it was, and the person in it.
  EXPECT_LT((clip.root_path() - should.root_path()).norm(2, 1).max().item<double>(), 0.05);
  const Scene scene = load_scene(r.dataset, test.scene);
  const ClosestPoints floor = SceneQuery(scene).closest(torch::tensor({{0.F, 0.3F, 0.F}}));
  EXPECT_NEAR(floor.points[0][1].item<double>(), 0, 0.03);
  EXPECT_GT(touching(clip, 0) + touching(clip, 1) + touching(clip, 2), 0.5) << "nobody sits";
  EXPECT_GT(touching(clip, 10), 0.3);
  const Npz arrays = read_npz(folder / "out/" + test.file);
  EXPECT_TRUE(torch::equal(arrays.at("left_hand_pose", ""), torch::full({210, 12}, 0.5)));
  EXPECT_GT(windows_of(folder / "out", "train"), 0);
}

TEST(ImportGimo, DecodesVposersCodesAndPutsPeopleIntoTheScan) {
  const TempFolder folder;
  write_gimo(folder / "gimo", 120, 330);
  const ImportSet set = open_import_set("gimo", folder / "gimo");
  EXPECT_TRUE(set.missing.empty()) << set.missing[0];
  const ImportResult r = import_dataset(set, folder / "out");
  ASSERT_EQ(r.dataset.clips.size(), 1U) << (r.skipped.empty() ? "" : r.skipped[0]);  // of the other there is nothing
  const DatasetClip& entry = r.dataset.clips[0];
  EXPECT_EQ(entry.source + " " + entry.split, "hall/2022-01-23_300 test");
  const Clip clip = load_clip(r.dataset, entry), should = sitter(120, 330).clip;
  EXPECT_EQ(clip.frames(), 210);
  EXPECT_LT(turned(slice(clip, 0, 40), slice(should, 0, 40)), 0.02);
  EXPECT_LT(turned(slice(clip, 43, 210), slice(should, 43, 210)), 0.02);
  EXPECT_LT((clip.root_path() - should.root_path()).norm(2, 1).max().item<double>(), 0.05);
  // The scan was 1.03 times too large and stood elsewhere.
  const Mesh room = merged_mesh(load_scene(r.dataset, entry.scene)),
             as_it_was = merged_mesh(read_scene_file(kSitterRoom).scene);
  EXPECT_LT((std::get<0>(room.vertices.max(0)) - std::get<0>(as_it_was.vertices.max(0))).abs().max().item<double>(),
            0.05);
  EXPECT_GT(touching(clip, 0) + touching(clip, 1) + touching(clip, 2), 0.5) << "nobody sits";
  EXPECT_TRUE(
      torch::equal(read_npz(folder / "out/" + entry.file).at("left_hand_pose", ""), torch::full({210, 45}, 0.5)));
  EXPECT_GT(windows_of(folder / "out", "test"), 0);
  std::filesystem::remove_all(folder / "gimo/vposer_v1_0");
  EXPECT_THAT(open_import_set("gimo", folder / "gimo").missing,
              Contains(::testing::HasSubstr("vposer_v1_0/snapshots/TR00_E096.pt")));
}

/// A camera's axes are no world's: the person is put upright, the sofa with them. Which way they then look is open.
TEST(ImportCouch, PutsPeopleAndTheirChairUpright) {
  const TempFolder folder;
  write_couch(folder / "couch", 60, 330);
  const ImportSet set = open_import_set("couch", folder / "couch");
  ASSERT_EQ(set.broken.size(), 1U) << "one recording has no frames near to one another";
  const ImportResult r = import_dataset(set, folder / "out");
  ASSERT_EQ(r.dataset.clips.size(), 1U) << (r.skipped.empty() ? "" : r.skipped[0]);
  const DatasetClip& entry = r.dataset.clips[0];
  EXPECT_EQ(entry.source + " " + entry.split, "Date01_Sub02_sofa_sit test");
  const Clip clip = load_clip(r.dataset, entry), should = sitter(60, 330).clip;
  EXPECT_EQ(clip.gender, "male");
  const torch::Tensor up = clip.joints.select(2, 1), up_should = should.joints.select(2, 1);
  EXPECT_LT((up - up.min() - up_should + up_should.min()).abs().max().item<double>(), 0.05) << "it slopes";
  const Scene scene = load_scene(r.dataset, entry.scene);
  double top = 0, low = 1;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.name.rfind("sofa", 0) != 0) continue;
    top = std::max(top, mesh.vertices.select(1, 1).max().item<double>());
    low = std::min(low, mesh.vertices.select(1, 1).min().item<double>());
  }
  double should_top = 0;
  for (const Mesh& mesh : read_scene_file(kSitterRoom).scene.meshes)
    if (mesh.name.rfind("sofa", 0) == 0)
      should_top = std::max(should_top, mesh.vertices.select(1, 1).max().item<double>());
  EXPECT_NEAR(top, should_top, 0.06);
  EXPECT_NEAR(low, 0, 0.06);
  ASSERT_EQ(clip.object_names, std::vector<std::string>{"sofa"});
  for (const int64_t t : {0L, 99L, 119L, 120L, 121L, clip.frames() - 1}) {
    const torch::Tensor moved = clip.object_pose[t][0] - clip.object_pose[0][0];
    // The frame without a mesh keeps the place before.
    EXPECT_NEAR(moved.narrow(0, 0, 3).norm().item<double>(), sofa_slid(t == 120 ? 119 : t), 1e-4) << t;
    EXPECT_LT(moved.narrow(0, 3, 3).norm().item<double>(), 1e-3) << t;
  }
  const int64_t lowest = up.select(1, 0).argmin().item<int64_t>();
  EXPECT_NEAR(clip.object_pose[lowest][0][4].item<double>(), heading(clip, lowest), 1e-3);
  EXPECT_GT(touching(clip, 0) + touching(clip, 1) + touching(clip, 2), 0.5) << "nobody sits";
  EXPECT_GT(windows_of(folder / "out", "test"), 0);
}

TEST(ImportTrumans, ReadsRowsOfOneArrayAndItsObjects) {
  const TempFolder folder;
  write_trumans(folder / "trumans");
  const ImportResult r = imported("trumans", folder / "trumans", folder / "out");
  // A bad frame cuts the second motion in two.
  ASSERT_EQ(r.dataset.clips.size(), 4U) << (r.skipped.empty() ? "" : r.skipped[0]);
  EXPECT_EQ(clip_called(r.dataset, "seg1").frames, 70);
  EXPECT_EQ(clip_called(r.dataset, "seg1_1").frames, 129);
  EXPECT_EQ(clip_called(r.dataset, "seg1").split, clip_called(r.dataset, "seg1_1").split);
  const DatasetClip& entry = clip_called(r.dataset, "seg0");
  const Clip clip = load_clip(r.dataset, entry);
  EXPECT_LT((clip.root_path() - sitter(120, 320).clip.root_path()).norm(2, 1).max().item<double>(), 0.05);
  EXPECT_LT(turned(clip, sitter(120, 320).clip), 1e-3);
  EXPECT_EQ(clip.object_names, std::vector<std::string>{"sofa"});
  EXPECT_NEAR(clip.object_pose[0][0][0].item<double>(), 1, 1e-4);
  EXPECT_NEAR(clip.object_pose[0][0].narrow(0, 3, 3).norm().item<double>(), M_PI / 2, 1e-4);
  // The sofa stands where it stood in the room.
  const auto box = [](const Scene& scene) {
    torch::Tensor points;
    for (const Mesh& m : scene.meshes)
      if (m.name.rfind("sofa", 0) == 0) points = points.defined() ? torch::cat({points, m.vertices}) : m.vertices;
    return torch::cat({std::get<0>(points.min(0)), std::get<0>(points.max(0))});
  };
  const torch::Tensor is = box(load_scene(r.dataset, entry.scene)), should = box(read_scene_file(kSitterRoom).scene);
  EXPECT_LT((is - should).abs().max().item<double>(), 0.05) << is << should;
  EXPECT_GT(touching(clip, 0) + touching(clip, 1) + touching(clip, 2), 0.5) << "nobody sits";
  EXPECT_EQ(read_npz(folder / "out/" + entry.file).at("left_hand_pose", "").size(1), 45);
  EXPECT_GT(windows_of(folder / "out", "all"), 0);
}

TEST(ImportTrumans, TheRecordingAtHand) {
  const std::string shared = shared_folder();
  if (shared.empty() || !std::filesystem::exists(shared + "/data/trumans/room.glb"))
    GTEST_SKIP() << "no such recording";
  const TempFolder folder;
  const ImportResult r = imported("trumans", shared + "/data/trumans", folder / "out");
  ASSERT_EQ(r.dataset.clips.size(), 1U);
  const Clip clip = load_clip(r.dataset, r.dataset.clips[0]);
  EXPECT_EQ(clip.frames(), 2660);
  double seated = 0;
  for (const int64_t j : {0, 1, 2}) seated = std::max(seated, touching(clip, j));
  EXPECT_GT(seated, 2) << "somebody sits in it";
  EXPECT_GT(touching(clip, 10) + touching(clip, 11), 20);
}

/// A room of the game seen from 3 m above its floor: the floor, and on it the person, whose pixels do not count.
TEST(ImportGtaIm, MakesACloudOfTheDepth) {
  const TempFolder folder;
  const std::string recording = folder / "gta/FPS-30/2020-06-04-01";
  const Clip walk = sitter(0, 120).clip;
  Npz npz = write_gta_im(recording, walk.joints, torch::full({kGtaRows, kGtaColumns}, 3.0));
  const ImportResult r = imported("gta-im", folder / "gta", folder / "out");
  ASSERT_EQ(r.dataset.clips.size(), 1U) << (r.skipped.empty() ? "" : r.skipped[0]);
  EXPECT_EQ(r.dataset.clips[0].split, "test");
  const Clip clip = load_clip(r.dataset, r.dataset.clips[0]);
  EXPECT_EQ(clip.frames(), 120);
  EXPECT_LT(off(clip, walk), 0.01);
  EXPECT_LT(limbs_off(clip, walk), 0.01);
  const torch::Tensor points = load_scene(r.dataset, r.dataset.clips[0].scene).points;
  ASSERT_TRUE(points.defined());
  EXPECT_EQ(points.size(0), kGtaRows * kGtaColumns - 7 * 7);  // without the person and a pixel around
  EXPECT_LT((points.select(1, 1) - points[0][1]).abs().max().item<double>(), 0.01);
  // 64 pixels at 3 m with a focal length of 40 pixels, around the camera's place in +Y-up axes.
  EXPECT_NEAR(points.select(1, 0).min().item<double>(), 100 - 32 * 3 / 40.0, 0.02);
  EXPECT_NEAR(points.select(1, 2).max().item<double>(), -100 + 17 * 3 / 40.0, 0.02);
  EXPECT_GT(windows_of(folder / "out", "test"), 0);
  torch::Tensor to_world = torch::linalg_inv(npz.tensors["world2cam_trans"][0]);
  to_world[3][0] = 1e9;
  npz.tensors["world2cam_trans"] = torch::linalg_inv(to_world).expand({walk.frames(), 4, 4}).contiguous();
  write_npz(recording + "/info_frames.npz", npz);
  EXPECT_THAT(refusal_of([&] { imported("gta-im", folder / "gta", folder / "far"); }),
              ::testing::HasSubstr("its camera stands nowhere"));
}

TEST(ImportGtaIm, SomebodySitsOnWhatTheCameraSees) {
  const TempFolder folder;
  const Clip sitting = sitter(120, 330).clip;
  const torch::Tensor last = sitting.joints[-1][0];
  const double x = last[0].item<double>(), z = last[2].item<double>();
  // What a camera 3 m above the place sees of the room.
  std::vector<float> directions;
  for (int64_t row = 0; row < kGtaRows; ++row)
    for (int64_t column = 0; column < kGtaColumns; ++column) {
      const Eigen::Vector3d d =
          Eigen::Vector3d(static_cast<double>(column - 32) / 40, -1, static_cast<double>(row - 18) / 40).normalized();
      for (int i = 0; i < 3; ++i) directions.push_back(static_cast<float>(d[i]));
    }
  const torch::Tensor d = torch::tensor(directions).view({-1, 3});
  const torch::Tensor from = torch::tensor({x, 3.0, z}, torch::kFloat32).expand_as(d).contiguous();
  const RayHits hits = SceneQuery(read_scene_file(kSitterRoom).scene).cast(from, d);
  const torch::Tensor heights = torch::where(hits.hit, hits.points.select(1, 1), torch::zeros({1}));  // 0 outside
  const torch::Tensor here = torch::tensor({x, 0.0, z}, torch::kFloat32);
  write_gta_im(folder / "gta/FPS-30/2020-06-04-01", sitting.joints - here, (3 - heights).view({kGtaRows, kGtaColumns}));
  const ImportResult r = imported("gta-im", folder / "gta", folder / "out");
  ASSERT_EQ(r.dataset.clips.size(), 1U) << (r.skipped.empty() ? "" : r.skipped[0]);
  const Clip clip = load_clip(r.dataset, r.dataset.clips[0]);
  EXPECT_LT(off(clip, sitting), 0.01);
  EXPECT_GT(touching(clip, 0) + touching(clip, 1) + touching(clip, 2), 0.5) << "nobody sits";
  EXPECT_GT(touching(clip, 10) + touching(clip, 11), 0.5) << "no foot stands";
  EXPECT_TRUE(sits(clip));
}

}  // namespace
}  // namespace inhabit
