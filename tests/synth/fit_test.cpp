#include "inhabit/synth/fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>

#include "cli/command.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/metrics/penetration.h"
#include "inhabit/motion/floor.h"
#include "inhabit/synth/blocked.h"
#include "inhabit/synth/person.h"
#include "refusal_of.h"
#include "shared.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

// A generated life as a recording: motion alone, on a floor that is not at 0.
Clip recording(uint64_t seed, double floor) {
  std::mt19937_64 random(seed);
  const Room room = make_room(random);
  const Clip life = live(room, builtin_body(), random, {16});
  Clip out;
  out.skeleton = life.skeleton;
  out.rate = life.rate;
  out.rotations = life.rotations;
  out.trans = life.trans + torch::tensor({3.F, static_cast<float>(floor), -2.F});
  out.joints = life.joints + torch::tensor({3.F, static_cast<float>(floor), -2.F});
  return out;
}

TEST(FitRecordings, TheFloorIsFoundUnderTheFeet) {
  for (uint64_t seed = 1; seed <= 4; ++seed)
    for (const double floor : {0.0, -0.35, 0.8}) EXPECT_NEAR(floor_under(recording(seed, floor)), floor, 0.02) << seed;
}

TEST(FitRoom, PutsRoomsAroundMotionWithoutTouchingIt) {
  int rooms = 0, seats = 0;
  for (uint64_t seed = 1; seed <= 12; ++seed)
    for (const Clip& piece : prepare_recording(recording(seed, 0.4), "life", 8)) {
      std::mt19937_64 random(seed);
      const auto fitted = fit_room(piece, builtin_body(), random);
      if (!fitted) continue;
      ++rooms;
      seats += fitted->seats;
      validate(fitted->clip, "fitted");
      const Penetration p = deepest_penetration(fitted->clip, builtin_body(), fitted->room.scene());
      EXPECT_LE(p.depth, 0.021) << "seed " << seed << ": joint " << p.joint << " in " << p.object;
      EXPECT_GE(fitted->room.furniture.size(), 2U);
      // The person is inside the walls, and the motion is the same but for where it is.
      const torch::Tensor p0 = fitted->clip.joints;
      EXPECT_LT(p0.select(2, 0).abs().max().item<double>(), fitted->room.size.x() / 2);
      EXPECT_LT(p0.select(2, 2).abs().max().item<double>(), fitted->room.size.y() / 2);
      const auto span = [](const torch::Tensor& j) { return (j.select(1, 15) - j.select(1, 10)).norm(2, 1); };
      EXPECT_TRUE(torch::allclose(span(p0), span(piece.joints), 1e-3, 1e-3));
      EXPECT_TRUE(torch::allclose(p0.select(2, 1), piece.joints.select(2, 1), 1e-3, 1e-3));
      // Where the pelvis is labelled to sit, the seat is right below.
      if (fitted->seats > 0) {
        EXPECT_GT(fitted->clip.contact.slice(1, 0, 3).sum().item<double>(), 0);
      }
    }
  EXPECT_GE(rooms, 8);
  EXPECT_GE(seats, 3);
}

TEST(FitRoom, DecoysStandAlongThePathAndBesideWhatIsUsedAndNothingElseTellsOfIt) {
  int rooms = 0, seats = 0, decoys = 0;
  for (uint64_t seed = 1; seed <= 12; ++seed)
    for (const Clip& piece : prepare_recording(recording(seed, 0.4), "life", 8)) {
      std::mt19937_64 random(seed);
      const auto fitted = fit_room(piece, builtin_body(), random, {1, 30, 120}, Furnishing::decoys, 1);
      if (!fitted) continue;
      ++rooms;
      seats += fitted->seats;
      decoys += fitted->decoys;
      EXPECT_EQ(fitted->on_chords, 0);
      EXPECT_EQ(fitted->passages, 0);
      EXPECT_LE(deepest_penetration(fitted->clip, builtin_body(), fitted->room.scene()).depth, 0.021) << seed;
      // No wall within a metre of where the body goes, but for the width of the walls' inner side.
      const torch::Tensor p = fitted->clip.joints;
      EXPECT_LT(p.select(2, 0).abs().max().item<double>(), fitted->room.size.x() / 2 - 0.99);
      EXPECT_LT(p.select(2, 2).abs().max().item<double>(), fitted->room.size.y() / 2 - 0.99);
    }
  EXPECT_GE(rooms, 8);
  EXPECT_GE(seats, 3);
  EXPECT_GE(decoys, 2 * rooms);
}

TEST(FitRoom, AnotherDrawIsAnotherRoomAndTheSameDrawTheSame) {
  // Not every draw finds room for its walls: take the first recording that three draws furnish.
  std::optional<FittedRoom> x, y, z;
  for (uint64_t seed = 1; seed <= 8 && !(x && y && z); ++seed) {
    const std::vector<Clip> pieces = prepare_recording(recording(seed, 0), "life", 6);
    ASSERT_FALSE(pieces.empty());
    std::mt19937_64 a(1), b(1), c(2);
    x = fit_room(pieces[0], builtin_body(), a);
    y = fit_room(pieces[0], builtin_body(), b);
    z = fit_room(pieces[0], builtin_body(), c);
    EXPECT_EQ(x.has_value(), y.has_value());
  }
  ASSERT_TRUE(x && y && z);
  EXPECT_EQ(x->room.furniture.size(), y->room.furniture.size());
  EXPECT_TRUE(torch::equal(x->clip.joints, y->clip.joints));
  EXPECT_NE(x->room.size, z->room.size);
}

TEST(PrepareRecording, CutsEvenPiecesAndDropsShortOnes) {
  const Clip life = recording(3, 0.2);
  const std::vector<Clip> pieces = prepare_recording(life, "life", 5);
  int64_t frames = 0;
  for (const Clip& piece : pieces) {
    EXPECT_LE(piece.frames(), 150);
    EXPECT_GE(piece.frames(), 60);
    frames += piece.frames();
  }
  EXPECT_EQ(frames, life.frames());
  EXPECT_TRUE(prepare_recording(slice(life, 0, 40), "life", 5).empty());
  EXPECT_THROW(prepare_recording(slice(life, 0, 1), "life", 5), Error) << "one pose";
}

TEST(PrepareRecording, CutsOutWhatAFlatFloorDoesNotExplain) {
  const Clip life = slice(recording(5, 0.2), 0, 360);
  // Raised by `height` from frame `first` to `last`, over two frames on the way up and down.
  const auto raised = [&](int64_t first, int64_t last, double height) {
    torch::Tensor up = torch::zeros({life.frames()});
    up.slice(0, first, last).fill_(height);
    for (const int64_t t : {first - 1, last}) up[t] = 0.56 * height;
    for (const int64_t t : {first - 2, last + 1}) up[t] = 0.12 * height;
    Clip out = life;
    out.joints = life.joints.clone();
    out.trans = life.trans.clone();
    out.joints.select(2, 1).add_(up.unsqueeze(1));
    out.trans.select(1, 1).add_(up);
    return out;
  };
  const auto frames = [](const Clip& clip) {
    int64_t out = 0;
    for (const Clip& piece : prepare_recording(clip, "life", 12)) out += piece.frames();
    return out;
  };
  EXPECT_EQ(frames(raised(150, 165, 0.5)), frames(life)) << "half a second in the air is a jump";
  EXPECT_EQ(frames(raised(150, 210, 0.5)), frames(life) - 62);
}

TEST(PrepareRecording, CutsOutFramesInWhichALimbLeaps) {
  const Clip life = slice(recording(5, 0.2), 0, 360);
  Clip leaps = life;
  leaps.rotations = life.rotations.clone();
  leaps.rotations[200][1][0] -= 1.2;  // the left hip, for one frame
  leaps.joints = joint_positions(leaps.skeleton, leaps.rotations, leaps.trans);
  const std::vector<Clip> whole = prepare_recording(life, "life", 12), cut = prepare_recording(leaps, "life", 12);
  ASSERT_EQ(whole.size(), 1U);
  ASSERT_EQ(cut.size(), 2U) << "before and after";
  EXPECT_EQ(cut[0].frames(), 198);
  EXPECT_EQ(cut[1].frames(), 360 - 203);
  EXPECT_TRUE(torch::allclose(cut[1].joints, whole[0].joints.slice(0, 203), 1e-3, 1e-3));
}

TEST(FitRecordings, SplitsByThePeopleOfItsFiles) {
  const TempFolder folder;
  std::vector<std::string> files;
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    files.push_back(folder / ("person_" + std::to_string(seed) + ".npz"));
    write_clip(files.back(), recording(seed, 0));
  }
  FittingOptions options;
  options.train = {files[0], files[3], files[4]};
  options.val = {files[1]};
  options.test = {files[2]};
  options.rooms_per_clip = 4;
  options.stretches = 1;
  options.only_on_chords = true;
  const Dataset d = fit_recordings(folder / "d", options);
  for (const DatasetClip& entry : d.clips) {
    const bool val = entry.source == "person_2.npz", test = entry.source == "person_3.npz";
    EXPECT_EQ(entry.split, val ? "val" : test ? "test" : "train") << entry.source;
    if (entry.split == "train") {
      EXPECT_GE(entry.frames, 123);
      EXPECT_LE(entry.frames, 165);
    }
  }
  for (const char* split : {"train", "val", "test"}) EXPECT_FALSE(d.split(split).empty()) << split;
  EXPECT_NEAR(d.provenance.at("recorded_minutes").get<double>(), 80.0 / 60, 0.05);
  const BlockedWindows with = blocked_windows(d, "train");
  EXPECT_GT(with.blocked, 0);
  EXPECT_EQ(with.colliding, 0);
  options.val.push_back(files[0]);
  EXPECT_THROW(fit_recordings(folder / "e", options), Error) << "one file in two splits";
}

TEST(FitRecordings, CmuBvhAmcAndAmassBecomeSceneData) {
  const std::string shared = shared_folder();
  if (shared.empty()) GTEST_SKIP() << "no recordings";
  const TempFolder folder;
  FittingOptions options;
  options.train = {shared + "/data/cmu/train/walking/walking_1.txt", shared + "/data/bvh/sample.bvh",
                   shared + "/data/asf_amc/02_01.amc"};
  options.test = {shared + "/data/cmu/test/walking/walking_1.txt"};
  options.rooms_per_clip = 1;
  fit_recordings(folder / "d", options);
  const Dataset d = open_dataset(folder / "d");
  std::set<std::string> sources;
  for (const DatasetClip& entry : d.clips) {
    sources.insert(entry.source);
    const Clip clip = load_clip(d, entry);
    const Penetration p = deepest_penetration(clip, builtin_body(), load_scene(d, entry.scene));
    EXPECT_LE(p.depth, 0.021) << entry.file << " joint " << p.joint << " in " << p.object;
    const double floor = floor_under(clip);
    EXPECT_NEAR(floor, 0, 0.05) << entry.file;
  }
  EXPECT_EQ(sources.size(), 3U);  // walking_1.txt twice
  for (const DatasetClip& entry : d.split("test")) EXPECT_EQ(entry.source, "walking_1.txt");
  EXPECT_FALSE(d.split("test").empty());
}

TEST(FitRecordings, PutsASeatUnderARecordedPersonWhoSits) {
  const std::string shared = shared_folder();
  if (shared.empty()) GTEST_SKIP() << "no recordings";
  const std::string file = shared + "/data/trumans/2023-02-12_22-16-01.npz";
  int seats = 0, pieces = 0;
  for (const Clip& piece : prepare_recording(read_clip(file), file, 12)) {
    std::mt19937_64 random(static_cast<uint64_t>(pieces));
    const auto fitted = fit_room(piece, builtin_body(), random);
    ++pieces;
    if (fitted) seats += fitted->seats;
  }
  EXPECT_GE(pieces, 6);
  EXPECT_GE(seats, 1);
}

TEST(FitCommand, ItsExitCodeSaysThatARecordingMakesNoClip) {
  const TempFolder folder;
  const std::string good = INHABIT_SOURCE_DIR "/examples/data/walk.npz", brief = folder / "brief.npz";
  write_clip(brief, slice(read_clip(good), 0, 30));
  const CommandResult some = run_command("synth fit --mocap " + good + " " + brief + " --out " + (folder / "some"));
  EXPECT_EQ(some.exit_code, 1) << some.err;
  EXPECT_THAT(some.err, testing::HasSubstr("skipped: " + brief + ": makes no clip: no 2 s of it"));
  EXPECT_THAT(some.err, testing::HasSubstr("1 of 2 files were skipped"));
  EXPECT_FALSE(open_dataset(folder / "some").clips.empty()) << "the data set is whole all the same";
  const CommandResult none = run_command("synth fit --mocap " + brief + " --out " + (folder / "none"));
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, testing::HasSubstr(brief + ": makes no clip"));
  EXPECT_FALSE(std::filesystem::exists(folder / "none"));
}

TEST(FitRecordings, BadInputIsRefused) {
  const TempFolder folder;
  FittingOptions options;
  EXPECT_THROW(fit_recordings(folder / "a", options), Error);
  options.train = {folder / "missing.bvh"};
  EXPECT_THROW(fit_recordings(folder / "b", options), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "b"));
  const std::string good = INHABIT_SOURCE_DIR "/examples/data/walk.npz", bad = folder / "bad.bvh";
  write_atomically(bad, "no motion");
  options.train = {bad, folder / "worse.bvh"};
  write_atomically(options.train[1], "HIERARCHY");
  EXPECT_THROW(fit_recordings(folder / "d", options), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "d")) << "nothing half-written";
  options.train = {good, bad};
  const Dataset of_one = fit_recordings(folder / "e", options);
  EXPECT_EQ(of_one.provenance["recordings"].size(), 1U);
  ASSERT_EQ(of_one.provenance["skipped"].size(), 1U);
  EXPECT_NE(of_one.provenance["skipped"][0].get<std::string>().find("bad.bvh"), std::string::npos);
  // What makes no clip is said with what is doubted of it; that of others is kept.
  Clip small = read_clip(good);
  small.joints = small.joints * 0.1;
  small.rotations = torch::Tensor();
  small.trans = torch::Tensor();
  small.skeleton.offsets = small.skeleton.offsets * 0.1;
  const std::string dwarf = folder / "dwarf.npz", brief = folder / "brief.npz";
  write_clip(dwarf, small);
  write_clip(brief, slice(read_clip(good), 0, 30));
  options.train = {good, dwarf, brief};
  const nlohmann::json said = fit_recordings(folder / "f", options).provenance;
  const std::string all =
      said.value("skipped", nlohmann::json::array()).dump() + said.value("doubts", nlohmann::json::array()).dump();
  EXPECT_NE(all.find("dwarf.npz: "), std::string::npos) << all;
  EXPECT_NE(all.find("implausible: the legs are 0.08"), std::string::npos) << all;
  EXPECT_NE(all.find("brief.npz: makes no clip: no 2 s of it"), std::string::npos) << all;
  options.train = {brief};
  EXPECT_THAT(refusal_of([&] { fit_recordings(folder / "g", options); }),
              testing::HasSubstr("brief.npz: makes no clip"));
  options.train = {folder / "missing.bvh"};
  options.test = options.train;
  EXPECT_THROW(fit_recordings(folder / "c", options), Error);
}

}  // namespace
}  // namespace inhabit
