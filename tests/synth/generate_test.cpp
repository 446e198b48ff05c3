#include "inhabit/synth/generate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>

#include "cli/command.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/synth/check.h"
#include "inhabit/version.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

// Every file under a folder and its bytes.
std::map<std::string, std::string> contents(const std::string& folder) {
  std::map<std::string, std::string> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      out[std::filesystem::relative(entry.path(), folder).string()] = read_whole_file(entry.path().string());
  return out;
}

/// Clips of three seconds, two in each room.
GenerateOptions short_lives(int64_t clips) {
  GenerateOptions out;
  out.clips = clips;
  out.clips_per_room = 2;
  out.seconds = 3;
  return out;
}

TEST(GenerateRooms, BytesDependOnTheSeedAndNotOnThreads) {
  const TempFolder folder;
  GenerateOptions options = short_lives(5);
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  generate_rooms(folder / "one", options);
  omp_set_num_threads(3);
  generate_rooms(folder / "three", options);
  options.seed = 2;
  generate_rooms(folder / "other", options);
  omp_set_num_threads(threads);
  const auto one = contents(folder / "one"), three = contents(folder / "three"), other = contents(folder / "other");
  EXPECT_EQ(one.size(), 1U + 3U + 5U);
  ASSERT_EQ(one.size(), three.size());
  for (const auto& [name, bytes] : one) EXPECT_TRUE(three.at(name) == bytes) << name;
  EXPECT_FALSE(one.at("clips/000000.npz") == other.at("clips/000000.npz"));
}

TEST(GenerateRooms, PassagesGiveClipsRoomsOfTheirOwnAndChangeNoMotion) {
  const TempFolder folder;
  GenerateOptions options = short_lives(4);
  options.seconds = 8;
  generate_rooms(folder / "without", options);
  options.passages = 1;
  generate_rooms(folder / "with", options);
  const auto without = contents(folder / "without"), with = contents(folder / "with");
  EXPECT_GT(with.size(), without.size());
  for (const auto& [name, bytes] : without)
    if (name.starts_with("clips/")) {
      EXPECT_TRUE(with.at(name) == bytes) << name;
    }
  EXPECT_EQ(without.at("dataset.json").find("passages"), std::string::npos) << "such a set is as it was before";
}

TEST(GenerateRooms, ARunThatWasEndedGoesOnToTheSameBytes) {
  const TempFolder folder;
  GenerateOptions options = short_lives(7);
  generate_rooms(folder / "whole", options);
  const std::string kept = folder / "ended/unfinished.jsonl";
  const int threads = omp_get_max_threads();
  omp_set_num_threads(2);  // more might begin all seven before the third ends
  options.progress = [](int64_t done, int64_t) {
    if (done == 3) throw std::runtime_error("ended");
  };
  EXPECT_THROW(generate_rooms(folder / "ended", options), std::runtime_error);
  std::ofstream(kept, std::ios::app) << R"({"clips": [["cl)";  // a line that was not written to its end
  options.progress = {};
  options.seed = 2;
  EXPECT_THAT(refusal_of([&] { generate_rooms(folder / "ended", options); }),
              testing::AllOf(testing::HasSubstr(kept), testing::HasSubstr("other settings")));
  options.seed = 1;
  const std::string lines = read_whole_file(kept);
  std::string older = lines;
  older.replace(older.find(INHABIT_VERSION), std::strlen(INHABIT_VERSION), "0.0.9");
  write_atomically(kept, older);
  EXPECT_THAT(refusal_of([&] { generate_rooms(folder / "ended", options); }), testing::HasSubstr("another version"));
  write_atomically(kept, lines);
  int64_t left = 0;
  options.progress = [&](int64_t, int64_t all) { left = all; };
  generate_rooms(folder / "ended", options);
  EXPECT_GT(left, 0);
  EXPECT_LE(left, 4) << "the clips that were made are not made again";
  omp_set_num_threads(threads);
  EXPECT_TRUE(contents(folder / "ended") == contents(folder / "whole"));
}

TEST(GenerateRooms, ShardsMakeTheSameBytesInAnyOrder) {
  const TempFolder folder;
  GenerateOptions options = short_lives(7);
  generate_rooms(folder / "whole", options);
  for (const int64_t number : {3, 1, 2}) {
    options.shard = {number, 3};
    const Dataset part = generate_rooms(folder / "parts", options);
    EXPECT_EQ(part.whole, number == 2);
    EXPECT_EQ(std::filesystem::exists(folder / "parts/dataset.json"), part.whole);
  }
  std::filesystem::remove_all(folder / "parts/shards");
  EXPECT_EQ(contents(folder / "parts"), contents(folder / "whole"));
  options.shard = {1, 3};
  EXPECT_THAT(refusal_of([&] { generate_rooms(folder / "parts", options); }), testing::HasSubstr("already"));
}

TEST(GenerateRooms, AShardMayBeMadeAgain) {
  const TempFolder folder;
  GenerateOptions options;
  options.clips = 4;
  options.clips_per_room = 1;
  options.seconds = 3;
  options.shard = {1, 2};
  generate_rooms(folder / "d", options);
  generate_rooms(folder / "d", options);
  EXPECT_FALSE(std::filesystem::exists(folder / "d/dataset.json"));
  {
    const Dataset other = create_dataset(folder / "d", {}, {1, 2});  // at work on the same shard
    EXPECT_THAT(refusal_of([&] { generate_rooms(folder / "d", options); }), testing::HasSubstr("another run"));
  }
  options.shard = {2, 2};
  EXPECT_TRUE(generate_rooms(folder / "d", options).whole);
  EXPECT_EQ(open_dataset(folder / "d").clips.size(), 4U);
}

TEST(GenerateRooms, ClipsOfOneRoomDifferAndShareItsSplit) {
  const TempFolder folder;
  GenerateOptions options;
  options.clips = 6;
  options.clips_per_room = 2;
  options.seconds = 3;
  const Dataset d = generate_rooms(folder / "d", options);
  EXPECT_EQ(d.clips[0].scene, d.clips[1].scene);
  EXPECT_NE(d.clips[1].scene, d.clips[2].scene);
  EXPECT_EQ(d.split("train").size(), 2U);
  EXPECT_EQ(d.split("val").size(), 2U);
  EXPECT_EQ(d.split("test").size(), 2U);
  const Dataset read = open_dataset(folder / "d");
  const Clip a = load_clip(read, read.clips[0]), b = load_clip(read, read.clips[1]);
  EXPECT_EQ(a.frames(), 90);
  EXPECT_FALSE(torch::equal(a.joints, b.joints));
  EXPECT_EQ(a.action_names, read.actions);
}

TEST(GenerateRooms, OfTenRoomsEightAreForTraining) {
  std::map<std::string, int> count;
  for (int64_t i = 0; i < 100; ++i) ++count[split_of_room(i, 100)];
  EXPECT_EQ(count["train"], 80);
  EXPECT_EQ(count["val"], 10);
  EXPECT_EQ(count["test"], 10);
  EXPECT_EQ(split_of_room(0, 2), "train");
}

TEST(GenerateRooms, NonsenseIsRefused) {
  const TempFolder folder;
  GenerateOptions options;
  options.clips = 0;
  EXPECT_THROW(generate_rooms(folder / "d", options), Error);
  options.clips = 1;
  options.seconds = std::nan("");
  EXPECT_THROW(generate_rooms(folder / "d", options), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "d"));
}

// The bars of generated motion, on a small sample.
TEST(CheckMotion, GeneratedLifeMeetsEveryBar) {
  const TempFolder folder;
  GenerateOptions options;
  options.clips = 10;
  options.seed = 11;
  options.clips_per_room = 1;
  const Dataset d = generate_rooms(folder / "d", options);
  int64_t told = 0;
  const auto count = [&](int64_t done, int64_t all) {
    EXPECT_EQ(done, ++told);
    EXPECT_EQ(all, 10);
  };
  for (const Bar& bar : check_motion(d, "all", count))
    EXPECT_TRUE(bar.pass()) << bar.name << " " << bar.value << " " << bar.unit << " in " << bar.worst_clip << " ("
                            << bar.worst << ")";
  EXPECT_EQ(told, 10) << "clips";
}

// A long life goes on chapter by chapter; at once, five minutes would hardly ever be without a fault.
TEST(CheckMotion, LongLivesMeetEveryBarToo) {
  const TempFolder folder;
  GenerateOptions options;
  options.clips = 3;
  options.seconds = 100;
  options.seed = 5;
  for (const Bar& bar : check_motion(generate_rooms(folder / "d", options), "all"))
    EXPECT_TRUE(bar.pass()) << bar.name << ": " << bar.value << " in [" << bar.low << ", " << bar.high << "], "
                            << bar.worst_clip << " " << bar.where;
}

TEST(CheckMotion, SlidingAndSinkingMissTheirBars) {
  const TempFolder folder;
  GenerateOptions options;
  options.clips = 1;
  options.seconds = 6;
  const Dataset made = generate_rooms(folder / "good", options);
  Clip clip = load_clip(made, made.clips[0]);
  const Scene scene = load_scene(made, made.clips[0].scene);
  Dataset bad = create_dataset(folder / "bad", made.actions);
  write_scene(bad, "scenes/a.glb", scene);
  torch::Tensor slide = torch::zeros({clip.frames(), 3});
  slide.select(1, 0).copy_(torch::arange(clip.frames()) * 0.05F);  // 1.5 m/s, out through a wall
  clip.trans = clip.trans + slide;
  clip.joints = clip.joints + slide.unsqueeze(1);
  clip.rotations = clip.rotations.clone();
  clip.rotations.select(1, 4).select(1, 0).fill_(-2.0);  // knees the wrong way
  DatasetClip entry{"clips/a.npz", "scenes/a.glb", "train", 0, ""};
  write_clip(bad, entry, clip);
  bad.clips.push_back(entry);
  write_index(bad);
  std::map<std::string, bool> pass;
  for (const Bar& bar : check_motion(bad)) pass[bar.name] = bar.pass();
  EXPECT_FALSE(pass.at("foot skating"));
  EXPECT_FALSE(pass.at("beyond joint limits"));
  EXPECT_FALSE(pass.at("depth in walls and furniture"));
  EXPECT_EQ(run_command("synth check " + (folder / "bad")).exit_code, 1);
}

TEST(SynthCommand, MakesChecksAndRefuses) {
  const TempFolder folder;
  const CommandResult made = run_command("synth rooms --out " + (folder / "d") + " --clips 2 --seed 4 --seconds 4");
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(made.out, ::testing::HasSubstr("2 clips"));
  const CommandResult again = run_command("synth rooms --out " + (folder / "d") + " --clips 2");
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, ::testing::HasSubstr("already"));
  const CommandResult check = run_command("synth check --json " + (folder / "d"));
  EXPECT_THAT(check.exit_code, ::testing::AnyOf(0, 1)) << check.err;
  EXPECT_EQ(nlohmann::json::parse(check.out).size(), 8U);
  const CommandResult activity = run_command("synth activity " + (folder / "d"));
  EXPECT_EQ(activity.exit_code, 0) << activity.err;
  EXPECT_THAT(activity.out, ::testing::HasSubstr("low m/s^3\n")) << activity.out;
  const CommandResult missing = run_command("synth check " + (folder / "nowhere"));
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_EQ(std::count(missing.err.begin(), missing.err.end(), '\n'), 1) << missing.err;
}

}  // namespace
}  // namespace inhabit
