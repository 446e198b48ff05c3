// Protects the data sets of actions: their layouts, their splits, their rates, and that what is missing or damaged is
// named and left out, of a native data set refused.
#include "inhabit/data/motion_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "anticipate/people.h"
#include "data/expmap_file.h"
#include "refusal_of.h"
#include "shared.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;

/// Pieces of each action and split, "walking train" -> how many.
std::map<std::string, int64_t> counts(const std::vector<ActionMotion>& motions) {
  std::map<std::string, int64_t> out;
  for (const ActionMotion& motion : motions) ++out[motion.action + " " + motion.split];
  return out;
}

TEST(MotionSet, CmusSplitIsTheFoldersAndTheLastTrainingFiles) {
  const TempFolder folder;
  const auto write = [&](const std::string& path, int64_t frames) {
    write_expmap(folder / ("cmu/" + path), 117, frames, 17);
  };
  for (const char* name : {"walking_1", "walking_2", "walking_10"})
    write("train/walking/" + std::string(name) + ".txt", 25);
  write("test/walking/walking_1.txt", 25);
  write("train/soccer/soccer_1.txt", 25);
  write("train/soccer/soccer_2.txt", 145);  // no test file: 30 frames at 25 Hz, the last ten are tested on
  write("test/washwindow/washwindow_1.txt", 25);
  write("train/running/running_1.txt", 25);
  std::ofstream(folder / "cmu/train/running/running_2.txt") << "no numbers\n";
  std::ofstream(folder / "cmu/train/running/notes.txt") << "not a recording\n";

  Notes notes;
  std::vector<int64_t> told;
  const auto motions = read_motion_set("cmu:" + folder / "cmu", 25, &notes, [&](int64_t done, int64_t all) {
    told.push_back(done);
    EXPECT_EQ(all, 9);
  });
  EXPECT_THAT(told, ::testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9)) << "files, the damaged one too";
  EXPECT_EQ(counts(motions), (std::map<std::string, int64_t>{{"walking train", 2},
                                                             {"walking val", 1},
                                                             {"walking test", 1},
                                                             {"soccer train", 2},
                                                             {"soccer test", 1},
                                                             {"washwindow test", 1},
                                                             {"running train", 1}}));
  for (const ActionMotion& motion : motions) {
    EXPECT_EQ(motion.clip.rate, 25) << motion.name;
    EXPECT_EQ(motion.clip.skeleton.names, standard_joint_names()) << motion.name;
    EXPECT_NO_THROW(validate(motion.clip, motion.name));
    if (motion.split == "val") {
      EXPECT_EQ(motion.name, "walking_10") << "the last by number";
    }
    if (motion.name == "soccer_2") {
      EXPECT_EQ(motion.clip.frames(), motion.split == "train" ? 20 : 11) << motion.split;
    }
  }
  EXPECT_THAT(notes, Contains("no training file of washwindow"));
  EXPECT_THAT(notes, Contains("no test file of soccer: the last third of soccer_2 is tested on"));
  EXPECT_THAT(notes, Contains("no training file of basketball"));
  EXPECT_THAT(notes, Contains("no test file of basketball"));
  EXPECT_THAT(notes, Contains(HasSubstr("left out: " + folder / "cmu/train/running/running_2.txt")));
}

TEST(MotionSet, Human36MTestsOnS5AndValidatesOnTheEndOfS11) {
  const TempFolder folder;
  // 50 Hz; the root's columns are steps, of which the first row's height counts for nothing.
  for (const char* file : {"S1/walking_1", "S1/walkingdog_1", "S5/walking_1", "S5/walking_2", "S11/eating_1"})
    write_expmap(folder / ("h36m/" + std::string(file) + ".txt"), 99, 41, 0);
  Notes notes;
  const auto motions = read_motion_set("h36m:" + folder / "h36m", 25, &notes);
  EXPECT_EQ(
      counts(motions),
      (std::map<std::string, int64_t>{
          {"walking train", 1}, {"walkingdog train", 1}, {"walking test", 2}, {"eating train", 1}, {"eating val", 1}}));
  for (const ActionMotion& motion : motions) {
    EXPECT_EQ(motion.clip.rate, 25);
    const int64_t frames = motion.action != "eating" ? 21 : motion.split == "train" ? 16 : 5;
    EXPECT_EQ(motion.clip.frames(), frames) << motion.action << " " << motion.split;
    const double thigh = motion.clip.skeleton.offsets[4].norm().item<double>();
    EXPECT_NEAR(thigh, 0.45, 0.01) << "metres";
  }
  EXPECT_EQ(notes.size(), 7U * 15 - 4) << "one for each subject and action that is missing";
  EXPECT_THAT(notes, Contains("no file of S9 sittingdown"));
}

TEST(MotionSet, NativeDataSetsKeepTheirSplitsAndMostFramesGiveTheAction) {
  const TempFolder folder;
  write_people(folder / "people", 30);
  Notes notes;
  int64_t told = 0;
  const auto motions = read_motion_set(folder / "people", 25, &notes, [&](int64_t done, int64_t) { told = done; });
  EXPECT_EQ(told, 8) << "clips";
  EXPECT_EQ(
      counts(motions),
      (std::map<std::string, int64_t>{
          {"walk train", 2}, {"wave train", 2}, {"walk val", 1}, {"wave val", 1}, {"walk test", 1}, {"wave test", 1}}));
  EXPECT_TRUE(notes.empty());
  EXPECT_EQ(read_motion_set(folder / "people", 12.5, &notes)[0].clip.frames(), 15);

  Dataset data = create_dataset(folder / "mixed", {"walk", "wave"});
  data.rate = 25;
  for (const int64_t walking : {9, 11, -1}) {
    DatasetClip entry{"clips/" + std::to_string(data.clips.size()) + ".npz", "", "train", 0, ""};
    Clip clip = person("walk", 20);
    if (walking >= 0) {
      clip.action_names = data.actions;
      clip.action = torch::ones({20}, torch::kInt64);
      clip.action.slice(0, 0, walking) = 0;
    }
    write_clip(data, entry, clip);
    data.clips.push_back(entry);
  }
  write_index(data);
  const auto mixed = read_motion_set(folder / "mixed", 25, &notes);
  ASSERT_EQ(mixed.size(), 3U);
  EXPECT_EQ(mixed[0].action, "wave");
  EXPECT_EQ(mixed[1].action, "walk");
  EXPECT_EQ(mixed[2].action, "motion") << "none is annotated";
}

TEST(MotionSet, OfANativeDataSetOnlyTrainingClipsMayBeUnreadable) {
  const TempFolder folder;
  write_people(folder / "people", 30);
  const auto read = [&] { return read_motion_set(folder / "people", 25).size(); };
  std::map<std::string, std::string> file;  // one of each split
  for (const DatasetClip& clip : open_dataset(folder / "people").clips)
    file[clip.split] = folder / "people" + "/" + clip.file;
  std::ofstream(file.at("train")) << "damaged";
  EXPECT_EQ(read(), 7U);
  fs::remove(file.at("train"));
  EXPECT_EQ(read(), 7U);
  std::ofstream(file.at("val")) << "damaged";
  EXPECT_THAT(refusal_of(read), HasSubstr(file.at("val") + ": "));
  fs::remove(file.at("val"));
  EXPECT_THAT(refusal_of(read), HasSubstr(file.at("val") + ": "));
}

TEST(MotionSet, RefusesSourcesThatHoldNothing) {
  const TempFolder folder;
  const auto refusal = [](const std::string& source) { return refusal_of([&] { read_motion_set(source, 25); }); };
  EXPECT_THAT(refusal("cmu:" + folder / "none"), HasSubstr("cmu:" + folder / "none" + ": holds no motion"));
  EXPECT_THAT(refusal("h36m:" + folder.path.string()), HasSubstr("h36m:" + folder.path.string() + ": holds no motion"));
  EXPECT_THAT(refusal(folder / "none"), HasSubstr("none/dataset.json"));
  EXPECT_THAT(refusal(""), HasSubstr("dataset.json"));
  fs::create_directories(folder / "cmu/train/walking");
  std::ofstream(folder / "cmu/train/walking/walking_1.txt") << "";
  EXPECT_THAT(refusal("cmu:" + folder / "cmu"), HasSubstr("holds no motion that can be read"));
}

TEST(MotionSet, TheRecordingsOfCmuAreAllThere) {
  const std::string shared = shared_folder();
  if (shared.empty()) GTEST_SKIP() << "no recordings beside the project";
  Notes notes;
  const auto motions = read_motion_set("cmu:" + shared + "/data/cmu", 25, &notes);
  std::map<std::string, int64_t> splits;
  for (const ActionMotion& motion : motions) ++splits[motion.split];
  // 38 files: 30 to train on in 7 actions, of which 6 have a last one to validate on; 6 to test on and the ends of two.
  EXPECT_EQ(splits, (std::map<std::string, int64_t>{{"train", 26}, {"val", 6}, {"test", 8}}));
  EXPECT_EQ(counts(motions).at("directing_traffic train"), 2);
  EXPECT_EQ(counts(motions).count("directing_traffic val"), 0U);
  EXPECT_THAT(notes, ::testing::UnorderedElementsAre(
                         "no training file of washwindow",
                         "no test file of basketball_signal: the last third of basketball_signal_5 is tested on",
                         "no test file of directing_traffic: the last third of directing_traffic_4 is tested on"));
}

TEST(LeftOutFold, LeavesEveryRecordingOutOnceAndOpensNoTest) {
  std::vector<ActionMotion> motions;
  for (const char* name : {"w1", "w2", "w3", "w4", "w5"}) motions.push_back({name, "walk", "train", {}});
  motions.push_back({"w6", "walk", "test", {}});
  for (const char* name : {"t1", "t2"}) motions.push_back({name, "traffic", "train", {}});
  EXPECT_EQ(single_folds(motions), 5);
  for (const int64_t folds : {2, 3, 5, 7}) {
    std::map<std::string, int64_t> left_out;
    for (int64_t fold = 0; fold < folds; ++fold) {
      std::map<std::string, int64_t> splits;
      for (const ActionMotion& motion : left_out_fold(motions, folds, fold)) {
        EXPECT_NE(motion.name, "w6");
        if (motion.split == "left_out") ++left_out[motion.name];
        ++splits[motion.action + " " + motion.split];
      }
      EXPECT_EQ(splits["walk val"], 1) << folds << " folds, " << fold;
      EXPECT_EQ(splits["traffic val"], 0);
      EXPECT_GT(splits["walk train"], 0);
      EXPECT_GT(splits["traffic train"], 0);
    }
    EXPECT_EQ(left_out.size(), 7U);
    for (const auto& [name, times] : left_out) EXPECT_EQ(times, 1) << name;
  }
  EXPECT_THAT(refusal_of([&] { left_out_fold(motions, 1, 0); }), HasSubstr("folds"));
}

}  // namespace
}  // namespace inhabit
