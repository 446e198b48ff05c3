// Protects `inhabit refine`: a recording in, a motion in every format out, and one clear line with nothing written for
// what cannot be.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/examples.h"
#include "cli/refusal.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"

namespace inhabit {
namespace {

TEST(RefineVerb, WritesEveryFormatAndSaysWhatItFound) {
  const TempFolder folder;
  std::string line = "refine " + kWalk + " --scene " + kRoom + " --keep 0,every:45";
  for (const char* name : {"r.npz", "r.bvh", "r.glb", "r.html", "r.json"}) line += " -o " + folder / name;
  const CommandResult r = run_command(line);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("contacts"), std::string::npos) << r.out;
  const Clip before = read_clip(kWalk), after = read_clip(folder / "r.npz");
  ASSERT_EQ(after.frames(), before.frames());
  EXPECT_TRUE(torch::equal(after.rotations[45], before.rotations[45]));
  EXPECT_FALSE(torch::equal(after.rotations[20], before.rotations[20]));
  EXPECT_EQ(read_clip(folder / "r.bvh").frames(), before.frames());
}

TEST(RefineVerb, NothingToDoChangesNothing) {
  const TempFolder folder;
  const CommandResult r = run_command("refine " + kWalk + " --keep every:1 -o " + folder / "same.npz");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_TRUE(torch::equal(read_clip(folder / "same.npz").rotations, read_clip(kWalk).rotations));
}

/// Fraction of frames in which a file's feet slide.
double skating(const std::string& motion, const TempFolder& folder) {
  const CommandResult r = run_command("score skating --motion " + motion + " --json " + folder / "s.json");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  return nlohmann::json::parse(read_whole_file(folder / "s.json"))["foot_skating"].get<double>();
}

TEST(RefineVerb, FeetOfFuturesStand) {
  const TempFolder folder;
  const std::string raw = folder / "raw.npz", clean = folder / "clean.npz", own = folder / "own.npz",
                    futures = "anticipate " + kWalk + " --samples 3 --seconds 8 --standard -o ";
  ASSERT_EQ(run_command(futures + raw).exit_code, 0);
  const CommandResult r =
      run_command("refine " + raw + " --generated --standard -o " + clean + " -o " + folder / "r.html");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(read_clips(clean).size(), 3U);
  ASSERT_EQ(run_command(futures + own + " --refine").exit_code, 0);
  const double before = skating(raw, folder);
  EXPECT_GT(before, 0.1) << "else this test says nothing";
  EXPECT_LT(skating(clean, folder), 0.75 * before);
  EXPECT_LT(skating(own, folder), 0.8 * before);
}

TEST(RefineVerb, RefusesWhatIsNotThere) {
  const TempFolder folder;
  const std::string out = " -o " + folder / "r.npz";
  expect_refused("refine " + kWalk + " --keep 90" + out, {"frame 90"}, folder / "");
  expect_refused("refine " + kWalk + " --keep shin" + out, {"shin"}, folder / "");
  expect_refused("refine " + kWalk + " --contacts some" + out, {"contacts"}, folder / "");
  expect_refused("refine nothing.bvh" + out, {"nothing.bvh"}, folder / "");
}

}  // namespace
}  // namespace inhabit
