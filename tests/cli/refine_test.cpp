// Protects `inhabit refine`: a recording in, a motion in every format out, and one clear line with nothing written for
// what cannot be.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/examples.h"
#include "cli/refusal.h"
#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/body/palm.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/scene/shapes.h"

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

TEST(RefineVerb, HandsRestOnWhatTheyTouch) {
  const TempFolder folder;
  Clip still;  // stands with both arms straight out
  still.skeleton = builtin_body().skeleton;
  still.rate = 30;
  still.rotations = torch::zeros({40, kStandardJoints, 3});
  still.trans = torch::tensor({0.F, 1.F, 0.F}).repeat({40, 1});
  still.joints = joint_positions(still.skeleton, still.rotations, still.trans);
  still.trans.select(1, 1).sub_(still.joints.select(2, 1).min() - 0.02);
  still.joints = joint_positions(still.skeleton, still.rotations, still.trans);
  write_clip(folder / "still.npz", still);
  const Eigen::Vector3f palm = palm_offset(0);
  const auto at = [&](int axis) { return still.joints[0][20][axis].item<double>() + palm[axis]; };
  MeshBuilder box;
  box.box({at(0), at(1) - 0.1, at(2)}, {0.1, 0.1, 0.1});
  Scene scene = floor_scene();
  scene.meshes.push_back(box.mesh("box", {1, 1, 1}));
  write_scene(folder / "box.glb", scene);
  const std::string line = "refine " + folder / "still.npz" + " --standard -o " + folder / "r.json" + " -o " +
                           folder / "r.html" + " --scene " + folder / "box.glb";
  const CommandResult r = run_command(line);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find(" 1 of hands"), std::string::npos) << r.out;
  const nlohmann::json motion = nlohmann::json::parse(read_whole_file(folder / "r.json"));
  EXPECT_EQ(motion.at("hand_targets")[20][0][3], 1);
  EXPECT_NE(run_command(line + " --contacts feet").out.find(" 0 of hands"), std::string::npos);
  EXPECT_NE(run_command("refine " + folder / "still.npz" + " -o " + folder / "r.npz").out.find(" 0 of hands"),
            std::string::npos)
      << "nothing to rest on";
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
