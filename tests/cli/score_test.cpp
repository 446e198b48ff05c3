#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/examples.h"
#include "cli/refusal.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/files.h"
#include "inhabit/motion/resample.h"

TEST(Score, RealMotionScoresHigherAgainstItselfThanAgainstOther) {
  const TempFolder folder;
  const auto ndms = [&](const std::string& reference) {
    const CommandResult r = run_command("score ndms --motion " + kWalk + " --reference " + reference +
                                        " --observed 25 --json " + folder / "s.json");
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return nlohmann::json::parse(inhabit::read_whole_file(folder / "s.json"));
  };
  const auto own = ndms(kWalk), other = ndms(kSit);
  EXPECT_GT(own["ndms"].get<double>(), 0.99);
  EXPECT_LT(other["ndms"].get<double>(), own["ndms"].get<double>() - 0.1);
  EXPECT_EQ(own["words"].get<int>(), 50) << "3 s at 25 Hz, of which 1 s observed: one word for each forecast frame";
}

TEST(Score, NdmsKnowsNeitherPlaceNorHeadingUnlessThePackagesWordsAreAskedFor) {
  // Who glides along swings as one who stays when poses alone are looked at, and not in the world.
  const TempFolder folder;
  inhabit::Clip still = inhabit::slice(inhabit::read_clip(kWalk), 0, 60), gliding;
  still.joints = still.joints - still.joints.narrow(1, 0, 1) * torch::tensor({1.F, 0.F, 1.F});
  gliding = still;
  gliding.joints = still.joints + torch::linspace(0, 3, 60).view({60, 1, 1}) * torch::tensor({1.F, 0.F, 0.F});
  for (inhabit::Clip* clip : {&still, &gliding}) clip->rotations = clip->trans = torch::Tensor();
  inhabit::write_clip_npz(folder / "still.npz", still);
  inhabit::write_clip_npz(folder / "gliding.npz", gliding);
  const auto ndms = [&](const std::string& words) {
    const CommandResult r = run_command("score ndms --motion " + folder / "gliding.npz" + " --reference " +
                                        folder / "still.npz" + words + " --json " + folder / "s.json");
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return nlohmann::json::parse(inhabit::read_whole_file(folder / "s.json"))["ndms"].get<double>();
  };
  EXPECT_GT(ndms(""), 0.9);
  EXPECT_GT(ndms(" --words dlow"), 0.9);
  EXPECT_LT(ndms(" --words package"), 0.6);
}

TEST(Score, AMotionHasNoErrorAndNoSpectralDistanceToItself) {
  const TempFolder folder;
  CommandResult r = run_command("score npss --motion " + kWalk + " --truth " + kWalk + " --json " + folder / "n.json");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NEAR(nlohmann::json::parse(inhabit::read_whole_file(folder / "n.json"))["npss"].get<double>(), 0, 1e-9);
  r = run_command("score error --motion " + kWalk + " " + kSit + " --truth " + kWalk + " --json " + folder / "e.json");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const auto error = nlohmann::json::parse(inhabit::read_whole_file(folder / "e.json"));
  EXPECT_NEAR(error["best_of_n_mm"].get<double>(), 0, 1e-3);
  EXPECT_GT(error["pose_error_mm"].get<double>(), 10);
  r = run_command("score apd --motion " + kWalk + " " + kSit + " --json " + folder / "a.json");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_GT(nlohmann::json::parse(inhabit::read_whole_file(folder / "a.json"))["apd_m"].get<double>(), 0.05);
}

nlohmann::json scored(const std::string& arguments, int exit_code = 0) {
  const TempFolder folder;
  const CommandResult r = run_command("score " + arguments + " --json " + folder / "s.json");
  EXPECT_EQ(r.exit_code, exit_code) << arguments << "\n" << r.err;
  return nlohmann::json::parse(inhabit::read_whole_file(folder / "s.json"));
}

TEST(Score, OneWhoStandsStillAsTheyWalkIsWrongInTheWorld) {
  const TempFolder folder;
  inhabit::Clip still = inhabit::read_clip(kWalk);
  const torch::Tensor gone = (still.joints.narrow(1, 0, 1) - still.joints[0][0]) * torch::tensor({1.F, 0.F, 1.F});
  still.joints = still.joints - gone;
  still.trans = still.trans - gone.squeeze(1);
  inhabit::write_clip_npz(folder / "still.npz", still);
  const auto error = scored("error --motion " + folder / "still.npz" + " --truth " + kWalk);
  EXPECT_LT(error["pose_error_mm"].get<double>(), 1);
  EXPECT_GT(error["world_error_mm"].get<double>(), 1000);
  EXPECT_NEAR(error["path_error_mm"].get<double>(), error["world_error_mm"].get<double>(), 1);
}

/// Joints alone as a network writes them: any name, millimetres, 60 frames a second, z up, flattened.
TEST(Score, TakesJointsOfAnybodyWithTheirUnitAndRate) {
  const TempFolder folder;
  const inhabit::Clip walk = inhabit::read_clip(kWalk);
  const torch::Tensor j = inhabit::resample(walk, 60).joints;
  const torch::Tensor z_up = torch::stack({j.select(2, 0), -j.select(2, 2), j.select(2, 1)}, 2) * 1000;
  inhabit::Npz npz;
  npz.tensors["keypoints"] = z_up.reshape({j.size(0), 66});
  inhabit::write_npz(folder / "net.npz", npz);
  const std::string net = folder / "net.npz" + " --scale 0.001 --up z --input-rate 60";
  const auto own = scored("skating --motion " + kWalk), theirs = scored("skating --motion " + net);
  EXPECT_NEAR(theirs["foot_skating"].get<double>(), own["foot_skating"].get<double>(), 0.03);
  const auto jerk = scored("jerk --motion " + kWalk + " --reference " + kWalk), other = scored("jerk --motion " + net);
  EXPECT_DOUBLE_EQ(jerk["jerk_ratio"].get<double>(), 1);
  EXPECT_NEAR(other["jerk"].get<double>(), jerk["jerk"].get<double>(), 0.2 * jerk["jerk"].get<double>());
  EXPECT_NEAR(other["speed"].get<double>(), 1.29, 0.02);
  const auto in = scored("penetration --motion " + net + " --scene " + kRoom);
  EXPECT_LT(in["collision_frame_ratio"].get<double>(), 0.1);
  const auto error = scored("error --motion " + kWalk + " --truth " + kWalk);
  EXPECT_NEAR(error["world_error_mm"].get<double>(), 0, 1e-3);
}

TEST(Score, DeepInTheSceneIsSaidWithTheFilesOwnFrame) {
  const TempFolder folder;
  inhabit::Clip sit = inhabit::read_clip(kSit);
  inhabit::Clip sunk = inhabit::slice(sit, 0, 60);
  sunk.rate = 60;  // half of the frames are looked at
  const auto clean = scored("penetration --motion " + kWalk + " --scene " + kRoom);
  // Stands from frame 20 on where somebody's seat is in the end.
  const torch::Tensor seat = sit.joints[sit.frames() - 1][0], from = sit.joints[0][0],
                      there = (seat - from) * torch::tensor({1.F, 0.F, 1.F});
  for (torch::Tensor* poses : {&sunk.joints, &sunk.trans, &sunk.rotations}) {
    *poses = poses->clone();
    poses->slice(0, 20).copy_(poses->slice(0, 0, 1).clone() + (poses == &sunk.rotations ? torch::zeros({3}) : there));
  }
  inhabit::write_clip_npz(folder / "sunk.npz", sunk);
  const auto in = scored("penetration --motion " + folder / "sunk.npz" + " --scene " + kSitRoom);
  EXPECT_GT(in["collision_frame_ratio"].get<double>(), clean["collision_frame_ratio"].get<double>() + 0.5);
  EXPECT_GT(in["penetration_max_mm"].get<double>(), 50);
  EXPECT_GE(in["files"][0]["deepest_frame"].get<int>(), 20);
  EXPECT_LT(in["files"][0]["deepest_frame"].get<int>(), 60);
}

TEST(Score, FidAndDiversityOfFoldersSkipWhatIsBadAndCountIt) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "real");
  const inhabit::Clip sit = inhabit::read_clip(kSit), walk = inhabit::read_clip(kWalk);
  ASSERT_GE(sit.frames(), 2 * 121);
  for (int64_t i = 0; i < 2; ++i)
    inhabit::write_clip_npz(folder / "real/" + std::to_string(i) + ".npz", inhabit::slice(sit, i * 121, (i + 1) * 121));
  const auto fid = scored("fid --motion " + folder / "real" + " --reference " + kSit);
  EXPECT_NEAR(fid["fid"].get<double>(), 0, 0.1) << "the same windows, over a floor of their own";
  EXPECT_EQ(fid["windows"], 2);
  inhabit::write_atomically(folder / "real/bad.npz", "no archive");
  inhabit::write_clip_npz(folder / "real/short.npz", walk);
  const auto skipped = scored("diversity --motion '" + folder / "real/*.npz'" + " --reference " + kSit, 1);
  EXPECT_EQ(skipped["windows"], 2);
  EXPECT_EQ(skipped["skipped"].size(), 2U);
  EXPECT_GT(skipped["diversity"].get<double>(), 0.1);
  const CommandResult r = run_command("score diversity --motion " + folder / "real");
  EXPECT_NE(r.err.find("bad.npz"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("4.03 s are needed"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("2 of 4 files were skipped"), std::string::npos) << r.err;
}

TEST(Score, DoubtsOfManyFilesComeFirstAndAreNeverCut) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "many");
  inhabit::Clip giant = inhabit::slice(inhabit::read_clip(kWalk), 0, 20);
  giant.joints = giant.joints * 100;
  giant.rotations = torch::Tensor();
  giant.trans = torch::Tensor();
  for (int i = 0; i < 12; ++i) inhabit::write_clip_npz(folder / "many/" + std::to_string(i) + ".npz", giant);
  const CommandResult r = run_command("score jerk --quiet --motion " + folder / "many");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  for (int i = 0; i < 12; ++i)
    EXPECT_NE(r.err.find("warning: " + folder / "many/" + std::to_string(i) + ".npz: implausible: the legs"),
              std::string::npos)
        << r.err;
}

TEST(Score, RefusesWhatCannotBeScored) {
  const TempFolder folder;
  const std::string out = folder.path.string(), to = " --json " + folder / "out.json";
  expect_refused("score ndms --motion " + folder / "none.npz" + " --reference " + kWalk + to,
                 {"none.npz", "no such file"}, out);
  expect_refused("score ndms --motion " + kWalk + " --reference " + kWalk + " --kappa 500" + to,
                 {"walk.npz", "20.00 s are needed"}, out);
  expect_refused("score ndms --motion " + kWalk + " --reference " + kSit + " --observed 75" + to,
                 {"walk.npz", "3.04 s are needed"}, out);
  expect_refused("score apd --motion " + kWalk + to, {"--motion", "two futures"}, out);
  expect_refused("score npss --motion " + kWalk + " " + kSit + " --truth " + kWalk + to,
                 {"--truth", "one file for each"}, out);
  expect_refused("score fid --motion " + kWalk + " --reference " + kSit + to, {"walk.npz", "4.03 s are needed"}, out);
  expect_refused("score penetration --motion " + kWalk + to, {"--scene", "is needed"}, out);
  expect_refused("score skating --motion " + folder.path.string() + to, {"without motion files"}, out);
}
