// Protects what an animator gives and gets back: `inbetween`, `forecast`, `anticipate` and `refine` write on the file's
// skeleton, with its names, rate, unit and axes, exact at keys; --standard writes the standard 22 joints. Places are
// worked out from the files alone (plain_kinematics.h).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "animator.h"
#include "cli/command.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/files.h"
#include "io/plain_kinematics.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;

double apart(const Places& a, const Places& b, size_t frame_a, size_t frame_b) {
  double most = 0;
  for (const auto& [name, path] : a) most = std::max(most, (path.at(frame_a) - b.at(name).at(frame_b)).norm());
  return most;
}

/// Millimetres with +Z up; centimetres below a joint_Root that stands.
std::array<AnimatorFile, 2> animators_files() {
  AnimatorFile below, world;
  below.unit = 10, below.z_up = true, below.order = "XZY";
  world.world_root = true, world.unit = 1, world.z_up = false, world.order = "ZXY";
  return {below, world};
}

TEST(OwnSkeleton, InbetweensKeepNamesRateUnitAndAxesAndMeetTheKeys) {
  const TempFolder folder;
  for (const AnimatorFile& file : animators_files()) {
    const std::string text = file.text(), in = folder / "walk.bvh";
    write_atomically(in, text);
    const CommandResult r = run_command("inbetween " + in + " --keyframes 31,60,97 -o " + folder / "own.bvh" + " -o " +
                                        folder / "own.npz -o " + folder / "own.glb -o " + folder / "own.json");
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const std::string own = read_whole_file(folder / "own.bvh");
    EXPECT_EQ(hierarchy_of(own), hierarchy_of(text));
    EXPECT_THAT(own, HasSubstr("Frames: 121\nFrame Time: 0.0166666667"));
    const Places given = places_in_bvh(text), found = places_in_bvh(own);
    double between = 0;
    for (const size_t key : {0, 31, 60, 97, 120}) EXPECT_LT(apart(given, found, key, key), 0.01 * file.unit) << key;
    for (size_t f = 0; f < 121; ++f) between = std::max(between, apart(given, found, f, f));
    EXPECT_GT(between, 1 * file.unit) << "between keys it is another motion";
    const Clip read = read_clip(in), arrays = read_clip(folder / "own.npz"), again = read_clip(folder / "own.bvh");
    EXPECT_EQ(arrays.skeleton.names, read.skeleton.names);
    EXPECT_EQ(arrays.rate, 60);
    for (const int64_t key : {0, 31, 60, 97, 120})
      EXPECT_TRUE(torch::equal(arrays.rotations[key], read.rotations[key])) << "bit by bit, " << key;
    // A root that stands is read as standing below the carrier, as deep as the motion's median height (locomotion.h),
    // which is not that of the other motion.
    const int64_t body = file.world_root ? 1 : 0;
    EXPECT_LT((again.joints - arrays.joints).slice(1, body).norm(2, {2}).max().item<double>(), 1e-3);
    const Places shown = places_in_glb(read_whole_file(folder / "own.glb"));
    EXPECT_NEAR(shown.at("Hips")[60].y(), 0.9, 0.1) << "metres, +Y up";
  }
}

TEST(OwnSkeleton, RefinedMotionKeepsNamesRateUnitAxesAndWhatIsKept) {
  const TempFolder folder;
  for (const AnimatorFile& file : animators_files()) {
    const std::string text = file.text(), in = folder / "walk.bvh";
    write_atomically(in, text);
    const CommandResult r =
        run_command("refine " + in + " --keep 0,60 -o " + folder / "own.bvh" + " -o " + folder / "own.npz");
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const std::string own = read_whole_file(folder / "own.bvh");
    EXPECT_EQ(hierarchy_of(own), hierarchy_of(text));
    EXPECT_THAT(own, HasSubstr("Frames: 121\nFrame Time: 0.0166666667"));
    const Places given = places_in_bvh(text), found = places_in_bvh(own);
    double between = 0;
    for (const size_t kept : {0, 60}) EXPECT_LT(apart(given, found, kept, kept), 0.01 * file.unit) << kept;
    for (size_t f = 0; f < 121; ++f) between = std::max(between, apart(given, found, f, f));
    EXPECT_GT(between, 1 * file.unit) << "other frames are refined";
    const Clip read = read_clip(in), arrays = read_clip(folder / "own.npz");
    EXPECT_EQ(arrays.skeleton.names, read.skeleton.names);
    EXPECT_EQ(arrays.skeleton.parents, read.skeleton.parents);
    EXPECT_LT((arrays.skeleton.offsets - read.skeleton.offsets).abs().max().item<double>(), 1e-5) << "bones";
    EXPECT_EQ(arrays.rate, 60);
    for (const int64_t kept : {0, 60})
      EXPECT_TRUE(torch::equal(arrays.rotations[kept], read.rotations[kept])) << "bit by bit, " << kept;
    for (const char* name : {"Jaw", "LeftArmTwist", "LeftHandIndex1", "RightHandThumb2"}) {
      const int joint = read.skeleton.find(name);
      EXPECT_LT((arrays.rotations - read.rotations).select(1, joint).abs().max().item<double>(), 1e-5)
          << name << " is no standard joint: it is left as it is";
    }
  }
}

TEST(OwnSkeleton, StandardMeansTheStandardJointsAtTheModelsRate) {
  const TempFolder folder;
  write_atomically(folder / "walk.bvh", AnimatorFile().text());
  const std::string in = folder / "walk.bvh", out = folder / "standard.npz";
  for (const std::string& verb : {"inbetween " + in + " --keyframes 31,60,97", "forecast " + in,
                                  "anticipate " + in + " --samples 1 --seconds 2"}) {
    const CommandResult r = run_command(verb + " --standard -o " + out);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const Clip clip = read_clips(out).at(0);
    EXPECT_EQ(clip.skeleton.names, standard_joint_names());
    EXPECT_EQ(clip.rate, verb[0] == 'a' ? 25 : 30);
  }
}

TEST(OwnSkeleton, ForecastsLeaveFromTheLastPose) {
  const TempFolder folder;
  AnimatorFile file;
  file.frames = 150;
  const std::string text = file.text(), in = folder / "walk.bvh";
  write_atomically(in, text);
  const Places given = places_in_bvh(text);
  const auto expect_goes_on = [&](const std::string& path, size_t start, size_t frames) {
    const std::string own = read_whole_file(path);
    EXPECT_EQ(hierarchy_of(own), hierarchy_of(text));
    const Places found = places_in_bvh(own);
    EXPECT_EQ(found.at("Hips").size(), frames);
    // A sixtieth of a second: what the fastest joint does in it, and what a network's first frame may be off.
    EXPECT_LT(apart(given, found, start - 1, 0), 8) << "centimetres";
    for (size_t f = 1; f < frames; ++f) EXPECT_LT(apart(found, found, f, f - 1), 15) << f;
  };
  ASSERT_EQ(run_command("forecast " + in + " --start 121 -o " + folder / "next.bvh").exit_code, 0);
  expect_goes_on(folder / "next.bvh", 121, 120);
  ASSERT_EQ(run_command("anticipate " + in + " --start 140 --samples 2 --seconds 3 --seed 3 -o " +
                        folder / "future.bvh -o " + folder / "futures.npz")
                .exit_code,
            0);
  expect_goes_on(folder / "future_001.bvh", 140, 180);
  const std::vector<Clip> futures = read_clips(folder / "futures.npz");
  ASSERT_EQ(futures.size(), 2U);
  EXPECT_EQ(futures[1].frames(), 180);
  EXPECT_EQ(read_npz(folder / "futures.npz").tensors.at("intention").sizes(), (torch::IntArrayRef{2, 180}));
}

// How high the body hangs on a root that stands is measured in each file, and not at all in one of a single frame.
TEST(OwnSkeleton, PosesOfSeveralFilesAreMetWhereTheirRootsStand) {
  const TempFolder folder;
  AnimatorFile low, high;
  low.world_root = high.world_root = true;
  low.hips = 60;
  const std::string a = folder / "a.bvh", b = folder / "b.bvh", out = folder / "out.bvh";
  for (const int frames : {1, 61}) {
    low.frames = high.frames = frames;
    low.begin = 1;
    write_atomically(a, high.text());
    write_atomically(b, low.text());
    const CommandResult r = run_command("inbetween " + a + " " + b + " --times 0,2 -o " + out);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const std::string own = read_whole_file(out);
    EXPECT_EQ(hierarchy_of(own), hierarchy_of(high.text()));
    const Places found = places_in_bvh(own);
    EXPECT_LT(apart(places_in_bvh(high.text()), found, 0, 0), 0.01) << frames;
    EXPECT_LT(apart(places_in_bvh(low.text()), found, 0, found.at("Hips").size() - 1), 0.01) << frames;
  }
}

TEST(OwnSkeleton, ConvertWritesMetresAndUpwardsUnlessAsked) {
  const TempFolder folder;
  AnimatorFile file;
  file.unit = 10;
  write_atomically(folder / "walk.bvh", file.text());
  const std::string in = folder / "walk.bvh";
  ASSERT_EQ(run_command("convert " + in + " " + folder / "cm.bvh").exit_code, 0);
  EXPECT_NEAR(places_in_bvh(read_whole_file(folder / "cm.bvh")).at("Hips")[0].y(), 90, 3);
  for (const std::string name : {"up.bvh", "up.npz"}) {
    ASSERT_EQ(run_command("convert " + in + " " + folder / name + " --out-up z").exit_code, 0);
    EXPECT_NEAR(read_clip(folder / name).joints[0][0][1].item<double>(), 0.9, 0.03) << "turned back when read";
  }
  EXPECT_NEAR(places_in_bvh(read_whole_file(folder / "up.bvh")).at("Hips")[0].z(), 90, 3);
  EXPECT_NEAR(places_in_npz(read_npz(folder / "up.npz")).at("Hips")[0].z(), 0.9, 0.03);
  EXPECT_EQ(run_command("convert " + in + " " + folder / "up.glb --out-up z").exit_code, 2);
  EXPECT_EQ(run_command("convert " + in + " " + folder / "no.npz --up z").exit_code, 2) << "it has +Y up";
}

}  // namespace
}  // namespace inhabit
