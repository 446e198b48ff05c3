#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/examples.h"
#include "cli/refusal.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/files.h"

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

TEST(Score, RefusesWhatCannotBeScored) {
  const TempFolder folder;
  const std::string out = folder.path.string(), to = " --json " + folder / "out.json";
  expect_refused("score ndms --motion " + folder / "none.npz" + " --reference " + kWalk + to,
                 {"none.npz", "no such file"}, out);
  expect_refused("score ndms --motion " + kWalk + " --reference " + kWalk + " --kappa 500" + to,
                 {"walk.npz", "no motion word"}, out);
  expect_refused("score ndms --motion " + kWalk + " --reference " + kSit + " --observed 75" + to,
                 {"walk.npz", "no motion word"}, out);
  expect_refused("score apd --motion " + kWalk + to, {"--motion", "two futures"}, out);
  expect_refused("score npss --motion " + kWalk + " " + kSit + " --truth " + kWalk + to,
                 {"--truth", "one file for each"}, out);
}
