#include "inhabit/data/native.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/synth/room.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;

// A clip on the standard skeleton with every annotation, different for each seed.
Clip small_clip(int64_t seed, int64_t frames = 8) {
  torch::manual_seed(seed);
  Clip clip;
  clip.skeleton = {standard_joint_names(), standard_parents(), torch::randn({kStandardJoints, 3}) * 0.2};
  clip.rotations = torch::randn({frames, kStandardJoints, 3}) * 0.3;
  clip.trans = torch::randn({frames, 3});
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  clip.betas = torch::randn({4});
  clip.action_names = {"stand", "walk"};
  clip.action = torch::randint(0, 2, {frames}, torch::kInt64);
  clip.contact = torch::randint(0, 2, {frames, kStandardJoints}).to(torch::kFloat);
  clip.hand_targets = torch::rand({frames, 2, 4});
  clip.object_names = {"chair_0"};
  clip.object_pose = torch::randn({frames, 1, 6});
  return clip;
}

// A data set of two rooms with two clips each.
Dataset write_small(const std::string& folder) {
  Dataset d = create_dataset(folder, {"stand", "walk"});
  d.provenance = {{"command", "test"}};
  for (int r = 0; r < 2; ++r) {
    std::mt19937_64 random(static_cast<uint64_t>(r));
    const std::string scene = "scenes/room_" + std::to_string(r) + ".glb";
    write_scene(d, scene, make_room(random).scene());
    for (int c = 0; c < 2; ++c) {
      DatasetClip entry{"clips/" + std::to_string(2 * r + c) + ".npz", scene, r == 0 ? "train" : "test", 0, ""};
      write_clip(d, entry, small_clip(2 * r + c, 8 + c));
      d.clips.push_back(entry);
    }
  }
  write_index(d);
  return d;
}

TEST(Dataset, ComesBackAsItWasWritten) {
  const TempFolder folder;
  write_small(folder / "d");
  const Dataset d = open_dataset(folder / "d");
  ASSERT_EQ(d.clips.size(), 4U);
  EXPECT_EQ(d.rate, 30.0);
  EXPECT_EQ(d.joint_names, standard_joint_names());
  EXPECT_EQ(d.parents, standard_parents());
  EXPECT_EQ(d.actions, (std::vector<std::string>{"stand", "walk"}));
  EXPECT_EQ(d.provenance.at("command"), "test");
  EXPECT_EQ(d.split("train").size(), 2U);
  EXPECT_EQ(d.split("val").size(), 0U);
  EXPECT_EQ(d.split("all").size(), 4U);
  for (int i = 0; i < 4; ++i) {
    const Clip want = small_clip(i, 8 + i % 2), got = load_clip(d, d.clips[static_cast<size_t>(i)]);
    EXPECT_EQ(d.clips[static_cast<size_t>(i)].frames, want.frames());
    EXPECT_TRUE(torch::equal(got.joints, want.joints));
    EXPECT_TRUE(torch::equal(got.rotations, want.rotations));
    EXPECT_TRUE(torch::equal(got.trans, want.trans));
    EXPECT_TRUE(torch::equal(got.action, want.action));
    EXPECT_TRUE(torch::equal(got.contact, want.contact));
    EXPECT_TRUE(torch::equal(got.hand_targets, want.hand_targets));
    EXPECT_TRUE(torch::equal(got.object_pose, want.object_pose));
    EXPECT_EQ(got.object_names, want.object_names);
    EXPECT_EQ(got.action_names, want.action_names);
  }
}

TEST(Dataset, IsSummedUpInALine) {
  Dataset d;
  d.folder = "rooms";
  d.rate = 30;
  d.clips = {{"clips/0.npz", "", "train", 900, ""}, {"clips/1.npz", "", "test", 2250, ""}};
  EXPECT_EQ(summary(d), "rooms: 2 clips, 1.8 minutes; train 1, val 0, test 1");
  d.shard = {2, 8};
  d.whole = false;
  EXPECT_EQ(summary(d), "rooms: shard 2-of-8, 2 clips; the others are still to come");
}

TEST(Dataset, ScenesKeepNamesAndPlaces) {
  const TempFolder folder;
  write_small(folder / "d");
  const Dataset d = open_dataset(folder / "d");
  std::mt19937_64 random(0);
  const Scene want = make_room(random).scene(), got = load_scene(d, d.clips[0].scene);
  ASSERT_EQ(got.meshes.size(), want.meshes.size());
  for (const Mesh& mesh : want.meshes) {
    const auto same =
        std::find_if(got.meshes.begin(), got.meshes.end(), [&](const Mesh& m) { return m.name == mesh.name; });
    ASSERT_NE(same, got.meshes.end()) << mesh.name;
    const auto low = [](const Mesh& m) { return std::get<0>(m.vertices.min(0)); };
    const auto high = [](const Mesh& m) { return std::get<0>(m.vertices.max(0)); };
    EXPECT_TRUE(torch::allclose(low(*same), low(mesh), 1e-4, 1e-4)) << mesh.name;
    EXPECT_TRUE(torch::allclose(high(*same), high(mesh), 1e-4, 1e-4)) << mesh.name;
  }
}

TEST(Dataset, AFolderIsNotWrittenOver) {
  const TempFolder folder;
  write_small(folder / "d");
  EXPECT_THAT(refusal_of([&] { create_dataset(folder / "d", {}); }), HasSubstr("already"));
}

TEST(Dataset, TwoRunsDoNotMakeOneFolder) {
  const TempFolder folder;
  {
    const Dataset first = create_dataset(folder / "d", {});
    EXPECT_THAT(refusal_of([&] { create_dataset(folder / "d", {}); }), HasSubstr("d: another run is writing it"));
  }
  create_dataset(folder / "d", {});  // one that stopped before it was done
}

TEST(Dataset, MissingFilesAreNamed) {
  const TempFolder folder;
  EXPECT_THAT(refusal_of([&] { open_dataset(folder / "nowhere"); }), HasSubstr("nowhere/dataset.json"));
  write_small(folder / "d");
  const Dataset d = open_dataset(folder / "d");
  std::filesystem::remove(folder / "d/clips/1.npz");
  std::filesystem::remove(folder / "d/scenes/room_1.glb");
  EXPECT_THAT(refusal_of([&] { clips_at_hand(d, "test"); }), HasSubstr("scenes/room_1.glb: there is no such file"));
  EXPECT_THAT(refusal_of([&] { load_clip(d, d.clips[1]); }), HasSubstr("clips/1.npz"));
  EXPECT_THAT(refusal_of([&] { load_scene(d, "scenes/room_1.glb"); }), HasSubstr("scenes/room_1.glb"));
}

TEST(Dataset, OfTheTrainingSplitWhatIsMissingOrTornIsLeftOut) {
  const TempFolder folder;
  write_small(folder / "d");
  const Dataset d = open_dataset(folder / "d");
  EXPECT_EQ(clips_at_hand(d, "train"), (std::vector<size_t>{0, 1}));
  EXPECT_EQ(clips_at_hand(d, "all"), (std::vector<size_t>{0, 1, 2, 3}));
  std::filesystem::resize_file(folder / "d/clips/0.npz", 100);
  EXPECT_EQ(clips_at_hand(d, "train"), (std::vector<size_t>{1}));
  std::filesystem::remove(folder / "d/clips/1.npz");
  EXPECT_TRUE(clips_at_hand(d, "train").empty());
  EXPECT_EQ(clips_at_hand(d, "test"), (std::vector<size_t>{2, 3}));
  std::filesystem::resize_file(folder / "d/clips/3.npz", 100);
  EXPECT_THAT(refusal_of([&] { clips_at_hand(d, "test"); }), HasSubstr("clips/3.npz: "));
  EXPECT_THAT(refusal_of([&] { clips_at_hand(d, "most"); }), HasSubstr("split"));
}

// Read as AMASS's, a clip without its skeleton would stand 0.22 m too low: trans is measured from elsewhere there.
TEST(Dataset, AClipMustSayItsSkeleton) {
  const TempFolder folder;
  const Dataset d = write_small(folder / "d");
  for (const char* name : {"parents", "offsets", "joint_names"}) {
    Npz arrays = npz_from_clip(small_clip(0), "clip");
    arrays.tensors.erase(name);
    arrays.strings.erase(name);
    write_npz(folder / "d/clips/0.npz", arrays);
    const std::string why = refusal_of([&] { load_clip(d, d.clips[0]); });
    EXPECT_THAT(why, HasSubstr("clips/0.npz: has no "));
    EXPECT_THAT(why, HasSubstr(name));
  }
}

TEST(Dataset, ClipsThatDisagreeWithTheIndexAreRefused) {
  const TempFolder folder;
  Dataset d = write_small(folder / "d");
  DatasetClip wrong = d.clips[0];
  wrong.frames = 7;
  EXPECT_THAT(refusal_of([&] { load_clip(d, wrong); }), HasSubstr("frames"));
  d.rate = 25;
  EXPECT_THAT(refusal_of([&] { load_clip(d, d.clips[0]); }), HasSubstr("rate"));
  d.rate = 30;
  d.actions = {};
  EXPECT_THAT(refusal_of([&] { load_clip(d, d.clips[0]); }), HasSubstr("action"));
  d = open_dataset(folder / "d");
  d.parents[5] = 0;
  EXPECT_THAT(refusal_of([&] { load_clip(d, d.clips[0]); }), HasSubstr("skeleton"));
}

TEST(Dataset, HostileIndicesAreRefusedInOneLineThatNamesTheEntry) {
  const TempFolder folder;
  write_small(folder / "d");
  const std::string path = folder / "d/dataset.json";
  nlohmann::json good;
  std::ifstream(path) >> good;
  auto refused = [&](const std::function<void(nlohmann::json&)>& spoil, const std::string& says) {
    nlohmann::json bad = good;
    spoil(bad);
    std::ofstream(path) << bad.dump();
    const std::string why = refusal_of([&] { open_dataset(folder / "d"); });
    EXPECT_THAT(why, HasSubstr("dataset.json: "));
    EXPECT_THAT(why, HasSubstr(says));
    EXPECT_EQ(why.find('\n'), std::string::npos);
  };
  refused([](auto& j) { j = nlohmann::json::array(); }, "format");
  refused([](auto& j) { j["format"] = 3; }, "format");
  refused([](auto& j) { j["version"] = 2; }, "version");
  refused([](auto& j) { j.erase("rate"); }, "rate");
  refused([](auto& j) { j["rate"] = "fast"; }, "rate");
  refused([](auto& j) { j["rate"] = -30; }, "rate");
  refused([](auto& j) { j["rate"] = 1e9; }, "rate");
  refused([](auto& j) { j["skeleton"] = 1; }, "skeleton");
  refused([](auto& j) { j["skeleton"]["parents"][3] = 30; }, "parent");
  refused([](auto& j) { j["skeleton"]["parents"][3] = 5; }, "parent");
  refused([](auto& j) { j["skeleton"]["parents"][3] = 0.5; }, "skeleton.parents");
  refused([](auto& j) { j["skeleton"]["names"].erase(0); }, "names and parents");
  refused([](auto& j) { j["actions"] = "walk"; }, "actions");
  refused([](auto& j) { j["actions"][0] = 7; }, "actions[0]");
  refused([](auto& j) { j["clips"] = {{"a", 1}}; }, "clips");
  refused([](auto& j) { j["clips"][1] = "x"; }, "clips[1]");
  refused([](auto& j) { j["clips"][1].erase("file"); }, "clips[1]");
  refused([](auto& j) { j["clips"][1]["file"] = "../../secret.npz"; }, "clips[1].file");
  refused([](auto& j) { j["clips"][1]["file"] = "/etc/secret.npz"; }, "clips[1].file");
  refused([](auto& j) { j["clips"][1]["file"] = "clips/../../secret.npz"; }, "clips[1].file");
  refused([](auto& j) { j["clips"][1]["file"] = "clips\\..\\secret.npz"; }, "clips[1].file");
  refused([](auto& j) { j["clips"][1]["file"] = ""; }, "clips[1].file");
  refused([](auto& j) { j["clips"][1]["file"] = "clips/a\nb.npz"; }, "clips[1].file");
  refused([](auto& j) { j["clips"][1]["file"] = "clips/1.exe"; }, ".npz");
  refused([](auto& j) { j["clips"][1]["scene"] = "../room.glb"; }, "clips[1].scene");
  refused([](auto& j) { j["clips"][1]["scene"] = "scenes/room.txt"; }, "scene");
  refused([](auto& j) { j["clips"][1]["frames"] = -4; }, "clips[1].frames");
  refused([](auto& j) { j["clips"][1]["frames"] = 18446744073709551615ULL; }, "clips[1].frames");
  refused([](auto& j) { j["clips"][1]["frames"] = 2.5; }, "clips[1].frames");
  refused([](auto& j) { j["clips"][1]["split"] = "training"; }, "split");
  refused([](auto& j) { j["clips"][1]["split"] = "test"; }, "in both");
  std::ofstream(path) << "{\"format\": ";
  EXPECT_THAT(refusal_of([&] { open_dataset(folder / "d"); }), HasSubstr("JSON"));
  std::ofstream(path) << "";
  EXPECT_THAT(refusal_of([&] { open_dataset(folder / "d"); }), HasSubstr("JSON"));
  std::ofstream(path) << std::string(200000, '[');
  EXPECT_THAT(refusal_of([&] { open_dataset(folder / "d"); }), HasSubstr("JSON"));
}

}  // namespace
}  // namespace inhabit
