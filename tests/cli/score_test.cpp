#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/examples.h"
#include "cli/refusal.h"
#include "inhabit/io/atomic_file.h"

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
