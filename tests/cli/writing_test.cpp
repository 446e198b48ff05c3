// Protects how motion is written by every verb: a part of it, at another rate, along other axes, so that it repeats;
// and many files at once.
#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "cli/examples.h"
#include "cli/refusal.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/io/npz.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

Clip written(const std::string& arguments, const std::string& out) {
  const CommandResult r = run_command(arguments + " -o " + out);
  EXPECT_EQ(r.exit_code, 0) << arguments << "\n" << r.err;
  return read_clip(out);
}

TEST(Writing, APartAtAnotherRateAndUpAxis) {
  const TempFolder folder;
  const Clip walk = read_clip(kWalk);
  const std::string out = folder / "part.npz";
  ASSERT_EQ(run_command("convert " + kWalk + " " + out + " --from 1 --to 2").exit_code, 0);
  const Clip part = read_clip(out);
  ASSERT_EQ(part.frames(), 31);
  EXPECT_TRUE(torch::equal(part.joints, walk.joints.slice(0, 30, 61)));
  EXPECT_TRUE(torch::equal(part.contact, walk.contact.slice(0, 30, 61)));
  ASSERT_EQ(run_command("convert " + kWalk + " " + out + " --from 1 --to 2 --rate 60 --out-up z").exit_code, 0);
  const Clip fast = read_clip(out);
  EXPECT_EQ(fast.frames(), 61);
  EXPECT_EQ(fast.rate, 60);
  EXPECT_LT((fast.joints[60] - walk.joints[60]).abs().max().item<double>(), 1e-4);
  EXPECT_THAT(read_whole_file(out), HasSubstr("up.npy"));
}

TEST(Writing, WhatCannotBeWrittenIsRefusedBeforeAnythingIs) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "out");
  const std::string out = folder / "out/";
  const std::string base = "refine " + kWalk + " ";
  expect_refused(base + "--from 2 --to 1 -o " + out + "a.html -o " + out + "a.npz", {"--from 2 --to 1"},
                 folder / "out");
  expect_refused(base + "--out-up z -o " + out + "a.npz -o " + out + "a.glb", {"a.glb", "+Y up"}, folder / "out");
  const CommandResult r = run_command(base + "--from 500 -o " + out + "a.html -o " + out + "a.npz");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_THAT(r.err, HasSubstr("--from 500: is beyond the end"));
  EXPECT_TRUE(std::filesystem::is_empty(folder / "out"));
}

TEST(Writing, ManyFilesAreNeverWrittenOverAnother) {
  const TempFolder folder;
  const std::string in = folder / "in";
  std::filesystem::create_directories(in);
  const Clip walk = read_clip(kWalk);
  write_clip(in + "/a.bvh", walk);
  write_clip(in + "/a.npz", slice(walk, 0, 40));
  write_clip(in + "/b.bvh", walk);
  const CommandResult r = run_command("convert " + in + " " + in + " --format npz");
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.err, HasSubstr("a.bvh: would be written over " + in + "/a.npz"));
  EXPECT_EQ(read_clip(in + "/a.npz").frames(), 40);
  EXPECT_EQ(read_clip(in + "/b.npz").frames(), walk.frames());
  // Of several motions names are made that an input may have.
  std::filesystem::create_directories(folder / "many");
  write_clips(folder / "many/w.npz", {walk, walk});
  write_clip(folder / "many/w_000.bvh", slice(walk, 0, 40));
  const CommandResult many = run_command("convert " + folder / "many" + " " + folder / "many" + " --format bvh");
  EXPECT_EQ(many.exit_code, 2) << "none of them can be";
  EXPECT_THAT(many.err, HasSubstr("would be written over"));
  EXPECT_EQ(read_clip(folder / "many/w_000.bvh").frames(), 40);
  // The same file under two names becomes two.
  std::filesystem::create_directories(folder / "linked");
  write_clip(folder / "linked/a.bvh", walk);
  std::filesystem::create_symlink("a.bvh", folder / "linked/b.bvh");
  ASSERT_EQ(run_command("convert " + folder / "linked" + " " + folder / "links").exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "links/b.npz"));
  ASSERT_EQ(run_command("convert " + in + "/b.bvh " + folder / "new/").exit_code, 0);
  EXPECT_EQ(read_clip(folder / "new/b.npz").frames(), walk.frames()) << "one file into a folder";
}

TEST(Writing, ABvhHasOneHierarchyAlongAnyAxes) {
  const TempFolder folder;
  const auto hierarchy = [&](const std::string& arguments) {
    const std::string out = folder / "x.bvh";
    EXPECT_EQ(run_command("convert " + arguments + " " + out).exit_code, 0) << arguments;
    std::string text = read_whole_file(out), words;
    text.resize(text.find("MOTION"));
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)  // offsets are along the axes
      if (line.find("OFFSET") == std::string::npos) words += line + "\n";
    return words;
  };
  const std::string plain = hierarchy(kWalk);
  EXPECT_EQ(hierarchy(kWalk + " --out-up z"), plain);
  size_t ends = 0;
  for (size_t at = plain.find("End Site"); at != std::string::npos; at = plain.find("End Site", at + 1)) ++ends;
  EXPECT_EQ(ends, 5U);
  // Of a .bvh too, whose own names and channels convert leaves behind.
  write_clip(folder / "in.bvh", read_clip(kWalk));
  EXPECT_EQ(hierarchy(folder / "in.bvh --out-up z"), hierarchy(folder / "in.bvh"));
}

TEST(Writing, IsTheSameForVerbsThatMakeMotion) {
  const TempFolder folder;
  const std::string forecast = "forecast " + kWalk + " --scene " + kRoom;
  const Clip all = written(forecast, folder / "all.npz"), second = written(forecast + " --to 1", folder / "second.npz");
  EXPECT_EQ(all.frames(), 60);
  ASSERT_EQ(second.frames(), 31);
  EXPECT_TRUE(torch::equal(second.joints, all.joints.slice(0, 0, 31)));
  EXPECT_EQ(written(forecast + " --rate 60 --from 0.5", folder / "fast.bvh").rate, 60);
  const Clip refined = written("refine " + kWalk + " --from 1 --rate 15", folder / "clean.npz");
  EXPECT_EQ(refined.frames(), 30);
  // Labels go with the frames.
  const std::string futures = folder / "futures.npz";
  ASSERT_EQ(run_command("anticipate " + kWalk + " --samples 2 --seconds 3 --from 1 --rate 10 -o " + futures).exit_code,
            0);
  const Npz npz = read_npz(futures);
  EXPECT_EQ(npz.tensors.at("intention").size(1), npz.tensors.at("joints").size(1));
  EXPECT_EQ(npz.tensors.at("mocap_framerate").item<double>(), 10);
}

TEST(Writing, ALoopRepeatsWithoutAJump) {
  const TempFolder folder;
  const std::string out = folder / "loop.npz";
  ASSERT_EQ(run_command("convert " + kWalk + " " + out + " --loop").exit_code, 0);
  const Clip walk = read_clip(kWalk), loop = read_clip(out);
  ASSERT_EQ(loop.frames(), 90 - 15 + 1);
  EXPECT_LT((loop.rotations[0].slice(0, 1) - loop.rotations[75].slice(0, 1)).abs().max().item<double>(), 1e-4);
  EXPECT_LT((loop.joints[0].select(1, 1) - loop.joints[75].select(1, 1)).abs().max().item<double>(), 1e-3);
  // No joint goes faster over the seam than it does elsewhere.
  const auto speeds = [](const Clip& clip) {
    return (clip.joints.slice(0, 1) - clip.joints.slice(0, 0, -1)).norm(2, 2);
  };
  EXPECT_LT(speeds(loop).max().item<double>(), 1.3 * speeds(walk).max().item<double>());
}

TEST(Writing, RefusesWhatLeavesNothingInTheFilesOwnFrames) {
  const TempFolder folder;
  const std::string out = folder.path.string(), to = folder / "x.npz";
  expect_refused("convert " + kWalk + " " + to + " --from 5", {"--from 5", "90 frames at 30 a second, 3.00 s"}, out);
  expect_refused("convert " + kWalk + " " + to + " --from 2 --to 1", {"--from 2 --to 1", "leave nothing"}, out);
  expect_refused("convert " + kWalk + " " + folder / "x.glb" + " --out-up z", {"x.glb", "+Y up by its format"}, out);
  expect_refused("forecast " + kWalk + " --rate 60 -o " + folder / "x.html", {"--rate", "page"}, out);
  expect_refused("convert " + kRoom + " " + folder / "x.ply" + " --from 1", {"is a scene"}, out);
}

TEST(ManyFiles, AreConvertedOneByOneAndBadOnesCounted) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "in/below");
  write_clip(folder / "in/a.bvh", read_clip(kWalk));
  write_clip(folder / "in/below/b.npz", slice(read_clip(kSit), 0, 40));
  write_atomically(folder / "in/c.bvh", "HIERARCHY nonsense");
  const CommandResult r = run_command("convert " + folder / "in" + " " + folder / "out" + " --format json --to 1");
  EXPECT_EQ(r.exit_code, 1) << "done, but for what was skipped";
  EXPECT_THAT(r.err, HasSubstr("skipped: " + folder / "in/c.bvh"));
  EXPECT_THAT(r.err, HasSubstr("1 of 3 files were skipped"));
  EXPECT_EQ(read_clip(folder / "out/a.json").frames(), 31);
  EXPECT_EQ(read_clip(folder / "out/below/b.json").frames(), 31);
  EXPECT_FALSE(std::filesystem::exists(folder / "out/c.json"));
  const CommandResult glob =
      run_command("convert '" + folder / "in/?.bvh" + "' " + folder / "in/below/b.npz" + " " + folder / "flat");
  EXPECT_EQ(glob.exit_code, 1);
  EXPECT_TRUE(std::filesystem::exists(folder / "flat/a.npz"));
  EXPECT_TRUE(std::filesystem::exists(folder / "flat/b.npz"));
  std::filesystem::remove(folder / "in/c.bvh");
  EXPECT_EQ(run_command("convert " + folder / "in" + " " + folder / "again" + " --quiet").exit_code, 0);
  const TempFolder empty;
  expect_refused("convert " + empty.path.string() + " " + folder / "none", {"without motion files"},
                 empty.path.string());
  expect_refused("train forecast --data " + folder / "in" + " --out " + empty / "m.safetensors",
                 {"is no data set but a folder of motion", "synth fit --mocap"}, empty.path.string());
}

TEST(ManyFiles, NeverOverwriteEachOther) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "in");
  const Clip walk = slice(read_clip(kWalk), 0, 20);
  write_clips(folder / "in/a.npz", {walk, walk});
  write_clip(folder / "in/a_000.npz", walk);
  const std::string two = folder / "in/a.npz" + " " + folder / "in/a_000.npz" + " ";
  std::filesystem::create_directories(folder / "empty");
  expect_refused("convert " + two + folder / "empty/out.bvh",
                 {"out.bvh: is named like a file; many become files of a folder"}, folder / "empty");
  const CommandResult r = run_command("convert " + folder / "in" + " " + folder / "out" + " --format bvh");
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.err, HasSubstr("out/a_000.bvh: would be written of both " + folder / "in/a.npz" + " and "));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/a_001.bvh"));
}

TEST(ManyFiles, OfTwoThatWouldBecomeOneTheSecondIsSkipped) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "in");
  const Clip walk = slice(read_clip(kWalk), 0, 20);
  for (const char* name : {"in/a.bvh", "in/a.json", "in/b.bvh"}) write_clip(folder / name, walk);
  const CommandResult r = run_command("convert " + folder / "in" + " " + folder / "out");
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_THAT(r.err, HasSubstr("skipped: " + folder / "in/a.json: would become " + folder / "out/a.npz, as "));
  EXPECT_THAT(r.err, HasSubstr("1 of 3 files were skipped"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/a.npz"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/b.npz"));
  std::filesystem::create_directory(folder / "empty");
  expect_refused("convert " + folder / "in/b.bvh" + " " + folder / "in" + " --format bvh",
                 {"b.bvh: would be written over what it is made of"}, folder / "empty");
}

TEST(ManyFiles, AFolderOfScenesBecomesScenes) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "in/below");
  std::filesystem::copy_file(kRoom, folder / "in/a.glb");
  write_atomically(folder / "in/below/b.obj", "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 2 4\nf 4 3 2 1\n");
  for (const std::string format : {"ply", "glb"}) {
    const std::string out = folder / format;
    const CommandResult r = run_command("convert " + folder / "in" + " " + out + " --format " + format);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_TRUE(std::filesystem::exists(out + "/a." + format));
    EXPECT_TRUE(std::filesystem::exists(out + "/below/b." + format));
  }
}

TEST(ManyFiles, PatternsOfDataSetsAndMotionAsData) {
  const TempFolder folder;
  const std::string to = " --out " + folder / "out/m.safetensors";
  std::filesystem::create_directory(folder / "out");
  std::filesystem::create_directory(folder / "made");
  expect_refused("train forecast --data '" + folder / "na*'" + to, {"na*: no folder matches"}, folder / "out");
  expect_refused("train forecast --data '" + folder / "ma*'" + to, {folder / "made/dataset.json"}, folder / "out");
  expect_refused("train forecast --data " + kWalk + to,
                 {"walk.npz: is no data set but a motion file", "synth fit --mocap"}, folder / "out");
}

}  // namespace
}  // namespace inhabit
