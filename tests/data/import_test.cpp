// Protects `inhabit import` of motion without scenes: folders in the layouts of the data sets' owners become data sets
// that training reads, with splits and parameters, what is broken is skipped and said, and a run goes on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "data/expmap_file.h"
#include "data/import_folders.h"
#include "data/imported.h"
#include "inhabit/body/body_model.h"
#include "inhabit/io/asf_amc.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/motion/resample.h"
#include "io/cdf_bytes.h"
#include "refusal_of.h"
#include "shared.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

TEST(ImportAmass, KeepsPeopleApartAndTheirParameters) {
  const TempFolder folder;
  write_amass(folder / "amass");
  const ImportSet set = open_import_set("amass", folder / "amass");
  ASSERT_EQ(set.recordings.size(), 5U);
  EXPECT_EQ(set.recordings[0].person, "A/01");
  const ImportResult r = import_dataset(set, folder / "out");
  EXPECT_EQ(r.made, 4);
  ASSERT_EQ(r.skipped.size(), 1U);
  EXPECT_THAT(r.skipped[0], HasSubstr("broken_poses.npz"));
  std::map<std::string, int> splits;
  for (const DatasetClip& clip : r.dataset.clips) ++splits[clip.split];
  EXPECT_EQ(splits, (std::map<std::string, int>{{"test", 1}, {"train", 2}, {"val", 1}}));
  const Dataset data = open_dataset(folder / "out");
  EXPECT_EQ(data.provenance.at("skipped").size(), 1U);
  const DatasetClip& entry = clip_called(data, "A/01/walk to sofa_poses");
  EXPECT_EQ(entry.file, "clips/A__01__walk_to_sofa_poses.npz");
  const Clip clip = load_clip(data, entry);
  EXPECT_EQ(read_npz(data.folder + "/" + entry.file).at("source_rate", "source_rate").item<double>(), 60);
  EXPECT_EQ(clip.frames(), 90);  // 180 at 60 Hz
  EXPECT_EQ(clip.gender, "female");
  EXPECT_EQ(clip.source_body, "smplh");
  EXPECT_NEAR(clip.source_betas[15].item<double>(), 1.5, 1e-6);
  const Clip should = resample(sitter(120, 300).clip, 15);
  EXPECT_LT(off(clip, should), 1e-3);
  EXPECT_LT(turned(clip, should), 1e-3);
  EXPECT_TRUE(torch::equal(read_npz(folder / "out/" + entry.file).at("pose_hand", ""), torch::full({90, 90}, 0.125)));
  // The floor is at 0, and the feet stand on it.
  EXPECT_NEAR(clip.joints.select(2, 1).min().item<double>(), 0.02, 0.04);
  EXPECT_GT(touching(clip, 10), 0.3);
  EXPECT_GT(windows_of(folder / "out", "all"), 0);
}

/// An SMPL-H body whose bones are a tenth longer than the built-in one's: four vertices a joint.
BodyModel longer_body() {
  constexpr int64_t J = 52, V = 4 * J;
  const BodyModel& builtin = builtin_body();
  Npz npz;
  torch::Tensor rest = torch::zeros({J, 3}), parents = torch::zeros({2, J}, torch::kInt64);
  rest.slice(0, 0, kStandardJoints).copy_(builtin.skeleton.rest_joints() * 1.1);
  for (int64_t j = 0; j < J; ++j) {
    const int64_t hand = j < 37 ? 20 : 21;
    parents[0][j] = j < kStandardJoints ? builtin.skeleton.parents[static_cast<size_t>(j)] : hand;
    parents[1][j] = j;
    if (j >= kStandardJoints) rest[j] = rest[hand] + torch::tensor({0.F, -0.05F, 0.F});
  }
  npz.tensors["v_template"] = rest.repeat_interleave(4, 0);
  npz.tensors["shapedirs"] = torch::zeros({V, 3, 16});
  npz.tensors["J_regressor"] = torch::eye(J).repeat_interleave(4, 1) / 4;
  npz.tensors["weights"] = torch::eye(J).repeat_interleave(4, 0);
  npz.tensors["kintree_table"] = parents;
  npz.tensors["f"] = torch::tensor({{0, 1, 2}});
  return smpl_model_from_npz(npz, "body");
}

TEST(ImportAmass, HasThePersonsOwnBonesWhereTheBodyIsGiven) {
  const TempFolder folder;
  write_amass(folder / "amass");
  const BodyModel body = longer_body();
  const ImportResult r = import_dataset(open_import_set("amass", folder / "amass", &body), folder / "out");
  const Clip clip = load_clip(r.dataset, clip_called(r.dataset, "A/01/walk to sofa_poses"));
  EXPECT_EQ(clip.skeleton.size(), kStandardJoints);
  for (const int64_t j : {4, 7, 18, 20})
    EXPECT_NEAR(clip.skeleton.offsets[j].norm().item<double>(),
                1.1 * builtin_body().skeleton.offsets[j].norm().item<double>(), 1e-5);
  EXPECT_FALSE(clip.betas.defined());  // they are the other body's
  EXPECT_EQ(clip.source_betas.size(0), 16);
}

TEST(ImportDataset, GoesOnWhereItEnded) {
  const TempFolder folder;
  write_amass(folder / "amass");
  const ImportResult first = imported("amass", folder / "amass", folder / "out");
  const std::string kept = folder / "out/" + first.dataset.clips[0].file,
                    lost = folder / "out/" + first.dataset.clips[1].file,
                    torn = folder / "out/" + first.dataset.clips[2].file;
  const std::string bytes = read_whole_file(lost);
  const auto time = std::filesystem::last_write_time(kept);
  std::filesystem::remove(lost);
  std::filesystem::remove(folder / "out/dataset.json");
  write_atomically(torn, bytes.substr(0, bytes.size() / 2));
  const ImportResult second = imported("amass", folder / "amass", folder / "out");
  EXPECT_EQ(second.kept, 2);
  EXPECT_EQ(second.made, 2);
  EXPECT_EQ(std::filesystem::last_write_time(kept), time);
  EXPECT_EQ(read_whole_file(lost), bytes);
  EXPECT_EQ(open_dataset(folder / "out").clips.size(), 4U);
  write_samp(folder / "samp");
  EXPECT_THAT(refusal_of([&] { imported("samp", folder / "samp", folder / "out"); }), HasSubstr("another format"));
  std::filesystem::remove(folder / "out/import.json");
  EXPECT_THAT(refusal_of([&] { imported("amass", folder / "amass", folder / "out"); }), HasSubstr("there already"));
}

TEST(ImportDataset, ShardsMakeOneDataSet) {
  const TempFolder folder;
  write_amass(folder / "amass");
  imported("amass", folder / "amass", folder / "whole");
  const ImportSet set = open_import_set("amass", folder / "amass");
  ImportOptions options;
  options.shard = {2, 2};
  EXPECT_FALSE(import_dataset(set, folder / "parts", options).dataset.whole);
  options.shard = {1, 2};
  const ImportResult last = import_dataset(set, folder / "parts", options);
  EXPECT_TRUE(last.dataset.whole);
  EXPECT_EQ(last.skipped.size(), 1U);
  const auto index = [&](const char* name) { return read_whole_file(folder / (std::string(name) + "/dataset.json")); };
  EXPECT_EQ(index("parts"), index("whole"));
  for (const DatasetClip& clip : last.dataset.clips)
    EXPECT_EQ(read_whole_file(folder / "parts/" + clip.file), read_whole_file(folder / "whole/" + clip.file));
}

TEST(ImportDataset, RefusesFoldersWithoutRecordings) {
  const TempFolder folder;
  for (const std::string& format : import_formats()) {
    const std::string said = refusal_of([&] { open_import_set(format, folder.path.string()); });
    EXPECT_THAT(said, HasSubstr("holds no recording of " + format)) << said;
  }
  EXPECT_THAT(refusal_of([&] { open_import_set("amass", folder / "none"); }), HasSubstr("no such folder"));
  EXPECT_THAT(refusal_of([&] { open_import_set("bvh", folder.path.string()); }), HasSubstr("amass, trumans, samp"));
  // Nothing but broken recordings.
  std::filesystem::create_directories(folder / "p");
  write_atomically(folder / "p/a_stageii.pkl", "cos\nsystem\n(S'true'\ntR.");
  EXPECT_THAT(refusal_of([&] { imported("samp", folder / "p", folder / "out"); }), HasSubstr("needs os.system"));
}

TEST(ImportSamp, ReadsPickles) {
  const TempFolder folder;
  write_samp(folder / "samp");
  const ImportResult r = imported("samp", folder / "samp", folder / "out");
  ASSERT_EQ(r.dataset.clips.size(), 3U);
  EXPECT_THAT(r.dataset.provenance.at("splits").get<std::string>(), HasSubstr("by recording"));
  const DatasetClip& entry = clip_called(r.dataset, "pkl/chair_mo001_stageii");
  const Clip clip = load_clip(r.dataset, entry);
  EXPECT_EQ(clip.source_body, "smplx");
  EXPECT_EQ(clip.source_betas.size(0), 300);
  EXPECT_LT(off(clip, sitter(100, 300).clip), 1e-3);
  EXPECT_LT(turned(clip, sitter(100, 300).clip), 1e-3);
  EXPECT_EQ(read_npz(folder / "out/" + entry.file).at("pose_hand", "").size(1), 90);
}

/// A person's joints as Human3.6M has them: 32 rows, of which 17 count, 50 Hz, +Z up. (T, 32, 3) metres.
torch::Tensor human36m_positions(const Sitter& person) {
  const std::map<int64_t, int64_t> of = {{0, 0},   {1, 2},   {2, 5},   {3, 8},   {6, 1},   {7, 4},
                                         {8, 7},   {12, 6},  {13, 9},  {14, 12}, {15, 15}, {17, 16},
                                         {18, 18}, {19, 20}, {25, 17}, {26, 19}, {27, 21}};
  const Clip at_50 = resample(person.clip, 50);
  torch::Tensor positions = torch::zeros({at_50.frames(), 32, 3});
  for (const auto& [row, joint] : of) {
    const torch::Tensor p = at_50.joints.select(1, joint);
    positions.select(1, row).copy_(torch::stack({p.select(1, 0), -p.select(1, 2), p.select(1, 1)}, 1));
  }
  return positions;
}

TEST(ImportHuman36m, ReadsPositionsOfJoints) {
  const TempFolder folder;
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0) GTEST_SKIP() << "no Python with NumPy";
  std::filesystem::create_directories(folder / "h36m");
  write_npy(folder / "p.npy", human36m_positions(sitter(0, 120)));
  write_npy(folder / "s.npy", human36m_positions(sitter(120, 330)));
  write_atomically(folder / "make.py",
                   "import numpy as np\np, s = np.load('p.npy'), np.load('s.npy')\n"
                   "np.savez_compressed('h36m/data_3d_h36m.npz', positions_3d={'S1': {'Walking 1': p, 'Sitting': s},"
                   " 'S8': {'Eating': p[:, [0, 1, 2, 3, 6, 7, 8, 12, 13, 14, 15, 17, 18, 19, 25, 26, 27]]},"
                   " 'S9': {'Walking': p}, 'S11': {'Walking': p[:, :5]}})\n");
  ASSERT_EQ(std::system(("cd '" + folder.path.string() + "' && /usr/bin/python3 make.py").c_str()), 0);
  const ImportResult r = imported("human36m", folder / "h36m", folder / "out");
  ASSERT_EQ(r.dataset.clips.size(), 4U);
  ASSERT_EQ(r.skipped.size(), 1U);
  EXPECT_THAT(r.skipped[0], HasSubstr("S11/Walking: is not (T, 32, 3)"));
  EXPECT_THAT(r.dataset.actions, ::testing::UnorderedElementsAre("walking", "sitting", "eating"));
  EXPECT_EQ(clip_called(r.dataset, "S9/Walking").split, "test");
  const Clip clip = load_clip(r.dataset, clip_called(r.dataset, "S1/Sitting"));
  EXPECT_EQ(clip.action_names[static_cast<size_t>(clip.action[0].item<int64_t>())], "sitting");
  EXPECT_LT(limbs_off(clip, sitter(120, 330).clip), 0.02);
  EXPECT_TRUE(sits(clip));
  EXPECT_GT(touching(clip, 10) + touching(clip, 11), 0.5) << "no foot stands";
  const Clip walk = load_clip(r.dataset, clip_called(r.dataset, "S1/Walking 1"));
  EXPECT_LT(limbs_off(walk, sitter(0, 120).clip), 0.02);
  EXPECT_LT(limbs_off(load_clip(r.dataset, clip_called(r.dataset, "S8/Eating")), walk), 1e-5);
}

/// The owners' file of somebody: one record of frames and 96 columns, millimetres.
std::string human36m_cdf(const torch::Tensor& positions, const CdfForm& form = {}, const char* name = "Pose") {
  return cdf_bytes({{name, (positions * 1000).reshape({1, -1, 96})}}, form);
}

TEST(ImportHuman36m, ReadsTheOwnersFiles) {
  const TempFolder folder;
  const torch::Tensor walk = human36m_positions(sitter(0, 120)), sit = human36m_positions(sitter(120, 330));
  const auto write = [&](const std::string& file, const std::string& bytes) {
    make_folders(folder / ("h36m/" + file));
    write_atomically(folder / ("h36m/" + file), bytes);
  };
  const std::string feature = "/MyPoseFeatures/D3_Positions/";
  write("S1" + feature + "Walking 1.cdf", human36m_cdf(walk));
  write("S1" + feature + "Sitting.cdf", human36m_cdf(sit, {.column_major = true, .pack_variables = true}));
  write("S1" + feature + "TakingPhoto 1.cdf", human36m_cdf(walk, {.big_endian = true, .pack_file = true}));
  write("S8/Photo.cdf", human36m_cdf(walk.to(torch::kFloat64), {.wide = false}));
  write("S9" + feature + "WalkDog.cdf", cdf_bytes({{"Pose", (walk * 1000).reshape({-1, 96})}}));
  // What cannot be read, each in its own way.
  torch::Tensor lost = walk.clone();
  lost[3][7][1] = std::nanf("");
  write("S11" + feature + "Eating.cdf", human36m_cdf(lost));
  write("S11" + feature + "Eating 1.cdf", human36m_cdf(walk).substr(0, 9000));
  write("S11" + feature + "Posing.cdf", human36m_cdf(walk, {}, "Angles"));
  write("S11" + feature + "Posing 1.cdf", cdf_bytes({{"Pose", torch::zeros({1, 50, 64})}}));
  // What lies beside and is not read: other features of the same people, and the text, which is split otherwise.
  write("S1/MyPoseFeatures/D3_Positions_mono/Walking 1.54138969.cdf", human36m_cdf(walk));
  write("S1/MyPoseFeatures/D2_Positions/Walking 1.54138969.cdf", cdf_bytes({{"Pose", torch::zeros({1, 50, 64})}}));
  write_expmap(folder / "h36m/S5/walking_1.txt", 99, 250, 0);
  const ImportSet set = open_import_set("human36m", folder / "h36m");
  EXPECT_EQ(set.recordings.size(), 9U);
  EXPECT_TRUE(set.broken.empty());
  EXPECT_EQ(set.missing.size(), 3U) << "S5, S6 and S7";
  const ImportResult r = import_dataset(set, folder / "out");
  EXPECT_EQ(r.made, 5);
  EXPECT_THAT(r.skipped, ::testing::UnorderedElementsAre(
                             HasSubstr("Eating.cdf"), HasSubstr("Eating 1.cdf: is cut short or damaged"),
                             HasSubstr("Posing.cdf: has no array Pose (it has Angles)"),
                             HasSubstr("Posing 1.cdf: its variable Pose does not have 32 joints a frame")));
  EXPECT_THAT(r.dataset.actions,
              ::testing::UnorderedElementsAre("walking", "sitting", "photo", "walkdog", "eating", "posing"));
  EXPECT_EQ(clip_called(r.dataset, "S9/WalkDog").split, "test");
  const Clip sits_down = load_clip(r.dataset, clip_called(r.dataset, "S1/Sitting"));
  EXPECT_EQ(sits_down.action_names[static_cast<size_t>(sits_down.action[0].item<int64_t>())], "sitting");
  EXPECT_LT(limbs_off(sits_down, sitter(120, 330).clip), 0.02);
  EXPECT_TRUE(sits(sits_down));
  const Clip walks = load_clip(r.dataset, clip_called(r.dataset, "S1/Walking 1"));
  EXPECT_LT(limbs_off(walks, sitter(0, 120).clip), 0.02);
  EXPECT_NEAR(walks.joints.select(2, 1).min().item<double>(), 0.02, 0.06) << "metres, upright, on the floor";
  for (const char* same : {"S1/TakingPhoto 1", "S8/Photo", "S9/WalkDog"})
    EXPECT_LT(limbs_off(load_clip(r.dataset, clip_called(r.dataset, same)), walks), 1e-3) << same;
}

TEST(ImportHuman36m, SaysThatPositionsOfCamerasAreNotRead) {
  const TempFolder folder;
  const std::string file = folder / "h36m/S1/MyPoseFeatures/D3_Positions_mono/Walking 1.54138969.cdf";
  make_folders(file);
  write_atomically(file, human36m_cdf(torch::zeros({4, 32, 3})));
  EXPECT_THAT(refusal_of([&] { open_import_set("human36m", folder / "h36m"); }),
              HasSubstr("holds no recording of human36m: D3_Positions_mono is not read"));
}

TEST(ImportCmu, ReadsTheTextWithThePapersSplits) {
  const TempFolder folder;
  const std::string text = read_whole_file(INHABIT_SOURCE_DIR "/tests/fuzz/seeds/motion_set/walking.txt");
  for (const char* file : {"train/walking/walking_1.txt", "train/walking/walking_2.txt", "test/walking/walking_3.txt",
                           "train/running/running_1.txt"}) {
    make_folders(folder / "cmu/" + file);
    write_atomically(folder / "cmu/" + std::string(file), file[6] == 'r' ? "1,2,3\n" : text);
  }
  const ImportSet set = open_import_set("cmu", folder / "cmu");
  EXPECT_EQ(set.recordings.size(), 3U);
  ASSERT_EQ(set.broken.size(), 1U);
  EXPECT_THAT(set.broken[0], HasSubstr("running_1.txt"));
  EXPECT_THAT(set.missing, Contains(HasSubstr("no training file of basketball")));
}

TEST(ImportCmu, TheTextBecomesADataSetOfItsActions) {
  const TempFolder folder;
  for (const char* file : {"train/walking/walking_1", "train/walking/walking_2", "test/walking/walking_3",
                           "train/running/running_1", "test/running/running_2"})
    write_expmap(folder / ("cmu/" + std::string(file) + ".txt"), 117, 400, 17);
  const ImportResult r = imported("cmu", folder / "cmu", folder / "out");
  EXPECT_EQ(r.made, 5);
  EXPECT_TRUE(r.skipped.empty());
  const Dataset data = open_dataset(folder / "out");
  EXPECT_THAT(data.actions, ::testing::UnorderedElementsAre("walking", "running"));
  std::map<std::string, int> splits;
  for (const DatasetClip& entry : data.clips) {
    ++splits[entry.split];
    const Clip clip = load_clip(data, entry);
    EXPECT_EQ(clip.frames(), 100) << "120 Hz";
    EXPECT_NEAR(clip.joints.select(2, 1).min().item<double>(), 0, 0.15) << entry.file << " stands on the floor";
    EXPECT_THAT(entry.source, HasSubstr(clip.action_names[static_cast<size_t>(clip.action[0].item<int64_t>())]));
  }
  EXPECT_EQ(splits, (std::map<std::string, int>{{"test", 2}, {"train", 2}, {"val", 1}}));
  EXPECT_GT(windows_of(folder / "out", "train"), 0);
}

TEST(ImportCmu, SomebodySitsDownInTheText) {
  const TempFolder folder;
  for (const char* file :
       {"train/basketball/basketball_1", "train/basketball/basketball_2", "test/basketball/basketball_3"})
    write_sitting_expmap(folder / ("cmu/" + std::string(file) + ".txt"));
  const ImportResult r = imported("cmu", folder / "cmu", folder / "out");
  EXPECT_EQ(r.made, 3);
  const Clip clip = load_clip(r.dataset, r.dataset.clips.front());
  EXPECT_TRUE(sits(clip)) << clip.joints[0][0][1].item<double>() << " " << clip.joints[-1][0][1].item<double>();
  EXPECT_GT(touching(clip, 10) + touching(clip, 11), 2) << "no foot stands";
}

TEST(ImportCmu, RecordingsWithTheirSkeletonsAreSplitByPerson) {
  const std::string shared = shared_folder();
  if (shared.empty()) GTEST_SKIP() << "no recordings beside the project";
  const TempFolder folder;
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared + "/data"))
    if (entry.path().extension() == ".amc" && std::filesystem::file_size(entry.path()) < (1U << 20))
      found.push_back(entry.path());
  ASSERT_FALSE(found.empty());
  std::sort(found.begin(), found.end());
  found.resize(std::min<size_t>(found.size(), 4));
  for (const std::filesystem::path& amc : found) {
    const std::string person = amc.stem().string().substr(0, amc.stem().string().find('_'));
    std::filesystem::create_directories(folder / "cmu/" + person);
    std::filesystem::copy(amc, folder / "cmu/" + person);
    std::filesystem::copy(find_asf(amc.string()), folder / "cmu/" + person + "/" + person + ".asf",
                          std::filesystem::copy_options::skip_existing);
  }
  const ImportResult r = imported("cmu", folder / "cmu", folder / "out");
  EXPECT_EQ(r.made, static_cast<int64_t>(found.size()));
  EXPECT_GT(touching(load_clip(r.dataset, r.dataset.clips.front()), 10), 0) << "feet stand";
}

TEST(ImportHuman36m, ExponentialMapsBecomeADataSetSplitByPerson) {
  const TempFolder folder;
  for (const char* file : {"S1/walking_1", "S6/eating_1", "S5/walking_1", "S11/eating_1"})
    write_expmap(folder / ("h36m/" + std::string(file) + ".txt"), 99, 250, 0);
  const ImportResult r = imported("human36m", folder / "h36m", folder / "out");
  EXPECT_EQ(r.skipped.size(), 0U);
  std::map<std::string, int> splits;
  for (const DatasetClip& entry : r.dataset.clips) ++splits[entry.split];
  EXPECT_EQ(splits, (std::map<std::string, int>{{"test", 1}, {"train", 3}, {"val", 1}})) << "S5, and the end of S11";
  const Clip clip = load_clip(r.dataset, clip_called(r.dataset, "train/walking_1"));
  EXPECT_EQ(clip.frames(), 150) << "50 Hz";
  EXPECT_THAT(r.dataset.actions, ::testing::UnorderedElementsAre("walking", "eating"));
}

}  // namespace
}  // namespace inhabit
