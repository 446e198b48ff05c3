// Protects `inhabit import`: what is there is listed, the data set it makes trains, and what is wrong is one line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/command.h"
#include "cli/refusal.h"
#include "data/import_folders.h"
#include "data/import_scene_folders.h"
#include "inhabit/data/native.h"

namespace inhabit {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Import, ListsMakesAndGoesOn) {
  const TempFolder folder;
  const std::string amass = folder / "amass", out = folder / "out";
  write_amass(amass);
  const CommandResult listed = run_command("import amass " + amass + " --list");
  EXPECT_EQ(listed.exit_code, 0) << listed.err;
  EXPECT_THAT(listed.out, AllOf(HasSubstr("5 recordings of 4 people; train 2, val 2, test 1"), HasSubstr("by person"),
                                HasSubstr("A/01/walk to sofa_poses")));
  EXPECT_FALSE(std::filesystem::exists(out));
  const CommandResult made = run_command("import amass " + amass + " --out " + out + " --jobs 2");
  EXPECT_EQ(made.exit_code, 1) << "a recording is broken";
  EXPECT_THAT(made.out, HasSubstr("4 clips, 0.2 minutes"));
  EXPECT_THAT(made.err, AllOf(HasSubstr("skipped: "), HasSubstr("broken_poses.npz"), HasSubstr("1 of 5")));
  std::filesystem::remove(out + "/dataset.json");
  const CommandResult again = run_command("import amass " + amass + " --out " + out);
  EXPECT_THAT(again.out, HasSubstr("4 of them were there already"));
  EXPECT_EQ(open_dataset(out).clips.size(), 4U);
}

TEST(Import, IsDoneInParts) {
  const TempFolder folder;
  const std::string amass = folder / "amass", out = folder / "out";
  write_amass(amass);
  const CommandResult first = run_command("import amass " + amass + " --out " + out + " --shard 1/2");
  EXPECT_THAT(first.out, HasSubstr("shard 1-of-2"));
  EXPECT_FALSE(std::filesystem::exists(out + "/dataset.json"));
  const CommandResult last = run_command("import amass " + amass + " --out " + out + " --shard 2/2");
  EXPECT_THAT(last.out, HasSubstr("4 clips, 0.2 minutes"));
  EXPECT_EQ(open_dataset(out).clips.size(), 4U);
  std::filesystem::create_directories(folder / "other");
  expect_refused("import amass " + amass + " --out " + folder / "other" + " --shard 3/2", {"--shard: '3/2' is not I/N"},
                 folder / "other");
}

TEST(Import, MakesWhatTrainingReads) {
  const TempFolder folder;
  const std::string prox = folder / "prox", out = folder / "out";
  for (const char* scene : {"N0Sofa", "Werkraum", "MPH11"}) write_prox(prox, scene, 120, 330);
  write_prox(prox, "MPH16", 120, 330);
  const CommandResult made = run_command("import prox " + prox + " --out " + out);
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, AllOf(HasSubstr("4 clips"), HasSubstr("train 2, val 1, test 1"),
                              HasSubstr("splits: the paper's scenes; of what is trained on a tenth by scene")));
  const CommandResult trained =
      run_command("train forecast --stage motion --data " + out + " --out " + folder / "m.safetensors" +
                  " --set decoder=recurrent training.motion_steps=2 training.motion_batch=2");
  EXPECT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "m.safetensors"));
}

TEST(Import, SaysWhatIsWrongInOneLine) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "empty");
  const std::string empty = folder / "empty";
  expect_refused("import amass " + empty + " --out " + folder / "out", {"holds no recording of amass: DATASET/PERSON"},
                 empty);
  expect_refused("import amass " + empty, {"--out: is needed, or --list"}, empty);
  expect_refused("import grab " + empty + " --list", {"trumans"}, empty);
  expect_refused("import prox " + folder / "none" + " --list", {"there is no such folder"}, empty);
}

}  // namespace
}  // namespace inhabit
