// Protects motion and scenes of .fbx, .dae and .glb: what assimp writes of a known motion is read back as that motion,
// and a damaged file ends in one line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <assimp/scene.h>
#include <Eigen/Geometry>
#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/assimp_motion.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/io/gltf.h"
#include "inhabit/io/many_files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/motion/retarget.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

const std::string kWalk = INHABIT_SOURCE_DIR "/examples/data/walk.npz",
                  kRoom = INHABIT_SOURCE_DIR "/examples/data/walk_room.glb",
                  kFiles = INHABIT_SOURCE_DIR "/tests/io/data/";

/// A .glb in another format, by assimp's own exporter ("fbx", "collada").
void export_as(const std::string& glb, const std::string& format, const std::string& to) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(glb, 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  Assimp::Exporter exporter;
  ASSERT_EQ(exporter.Export(scene, format, to), aiReturn_SUCCESS) << exporter.GetErrorString();
}

double farthest(const torch::Tensor& a, const torch::Tensor& b) {
  if (a.sizes() != b.sizes()) return 1e9;
  return (a - b).norm(2, -1).max().item<double>();
}

/// The walk, its joints where its rotations have them (the recording's own are up to 1.6 mm off).
Clip the_walk() {
  Clip walk = read_clip(kWalk);
  walk.joints = joint_positions(walk.skeleton, walk.rotations, walk.trans);
  return walk;
}

TEST(AssimpMotion, AGlbComesBackAsItWasWritten) {
  const TempFolder folder;
  const Clip walk = the_walk();
  write_clip(folder / "walk.glb", walk);
  const Clip back = read_clip(folder / "walk.glb");
  EXPECT_TRUE(is_clip_file(folder / "walk.glb"));
  EXPECT_EQ(back.skeleton.names, walk.skeleton.names);
  EXPECT_EQ(back.skeleton.parents, walk.skeleton.parents);
  EXPECT_EQ(back.rate, walk.rate);
  EXPECT_LT(farthest(back.joints, walk.joints), 1e-5);
  EXPECT_FALSE(back.translations.defined());
}

TEST(AssimpMotion, AHeldPoseIsAMotion) {
  const TempFolder folder;
  const Clip walk = the_walk();
  for (const std::vector<int64_t>& held : {std::vector<int64_t>{40}, std::vector<int64_t>(20, 40)}) {
    const Clip pose = frames_at(walk, held);
    write_clip(folder / "pose.glb", pose);
    ASSERT_TRUE(is_clip_file(folder / "pose.glb")) << held.size();
    const Clip back = read_clip(folder / "pose.glb");
    EXPECT_EQ(back.frames(), pose.frames());
    EXPECT_LT(farthest(back.joints, pose.joints), 1e-5);
  }
}

TEST(AssimpMotion, SeveralPeopleOfAGlbAreReadOneByOne) {
  const TempFolder folder;
  const Clip walk = the_walk();
  Clip apart = walk;
  apart.trans = walk.trans + 1;
  apart.joints = walk.joints + 1;
  Clip named = apart;
  for (std::string& name : named.skeleton.names) name += "_b";
  write_glb(folder / "two.glb", {{&walk, &builtin_body(), "a"}, {&named, nullptr, "b"}});
  const std::vector<Clip> both = read_clips(folder / "two.glb");
  ASSERT_EQ(both.size(), 2U);
  const bool first = both[0].skeleton.names[0] == "pelvis";
  EXPECT_LT(farthest(both[first ? 0 : 1].joints.select(1, 0), walk.joints.select(1, 0)), 1e-5);
  EXPECT_LT(farthest(both[first ? 1 : 0].joints.select(1, 0), apart.joints.select(1, 0)), 1e-5);
  const std::vector<Clip> alone = read_samples(folder / "two.glb");
  ASSERT_EQ(alone.size(), 1U) << "people of other skeletons are no samples of one motion";
  EXPECT_TRUE(alone[0].joints.equal(both[0].joints));
  Notes notes;
  read_clip(folder / "two.glb", {}, &notes);
  EXPECT_THAT(notes, testing::Contains(HasSubstr("one of 2 motions")));
  // Nodes are told apart by their names alone.
  write_glb(folder / "alike.glb", {{&walk, &builtin_body(), "a"}, {&apart, &builtin_body(), "b"}});
  notes.clear();
  EXPECT_LT(farthest(read_clip(folder / "alike.glb", {}, &notes).joints, walk.joints), 1e-5);
  EXPECT_THAT(notes, testing::Contains(HasSubstr("1 more, whose joints have the same names")));
}

class OtherFormats : public testing::TestWithParam<std::pair<const char*, const char*>> {};

// The walk from 0.5 to 0.8 s as Blender exports it (data/make_node_files.py): an armature scaled and rotated, with
// bones that have axes of their own.
TEST_P(OtherFormats, HoldTheSameMotion) {
  const Clip walk = slice(the_walk(), 15, 25);
  const std::string file = kFiles + "blender." + GetParam().second;
  ASSERT_TRUE(is_clip_file(file));
  const Clip back = read_clip(file);
  ASSERT_EQ(back.frames(), walk.frames());
  EXPECT_NEAR(back.rate, walk.rate, 1e-3);
  EXPECT_FALSE(back.translations.defined());
  for (int j = 0; j < walk.skeleton.size(); ++j) {
    const int found = back.skeleton.find(walk.skeleton.names[static_cast<size_t>(j)]);
    ASSERT_GE(found, 0) << walk.skeleton.names[static_cast<size_t>(j)];
    EXPECT_LT(farthest(back.joints.select(1, found), walk.joints.select(1, j)), 1e-4);
  }
  // The pose that the skin was bound in is the one without rotations.
  const Clip standard = retarget(back, file);
  EXPECT_LT(farthest(standard.joints, walk.joints), 5e-3);
}

TEST_P(OtherFormats, HoldTheSameScene) {
  const TempFolder folder;
  const std::string file = folder / (std::string("room.") + GetParam().second);
  export_as(kRoom, GetParam().first, file);
  EXPECT_FALSE(is_clip_file(file));
  const SceneFile room = read_scene_file(kRoom), back = read_scene_file(file);
  EXPECT_EQ(back.report.triangles, room.report.triangles);
  EXPECT_EQ(back.scene.meshes.size(), room.scene.meshes.size());
  for (size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(back.report.lower[axis], room.report.lower[axis], 1e-3);
    EXPECT_NEAR(back.report.upper[axis], room.report.upper[axis], 1e-3);
  }
  const auto has = [&](const std::string& name) {
    for (const Mesh& mesh : back.scene.meshes)
      if (mesh.name == name) return true;
    return false;
  };
  for (const Mesh& mesh : room.scene.meshes) EXPECT_TRUE(has(mesh.name)) << mesh.name;
}

// In text: what this assimp writes as binary .fbx it cannot read itself.
INSTANTIATE_TEST_SUITE_P(Assimp, OtherFormats, testing::Values(std::pair("fbxa", "fbx"), std::pair("collada", "dae")),
                         [](const auto& named) { return named.param.second; });

TEST(AssimpMotion, AFolderListsThoseWithMotionOnly) {
  const TempFolder folder;
  write_clip(folder / "walk.glb", read_clip(kWalk));
  std::filesystem::copy_file(kRoom, folder / "room.glb");
  EXPECT_THAT(motion_files({folder.path.string()}), testing::ElementsAre(folder / "walk.glb"));
}

TEST(AssimpMotion, SaysWhatIsWrong) {
  const TempFolder folder;
  EXPECT_THAT(refusal_of([&] { read_clip(folder / "missing.fbx"); }), HasSubstr("missing.fbx"));
  EXPECT_THAT(refusal_of([&] { read_clip(kRoom); }), HasSubstr("no skeleton of a person that an animation moves"));
  write_atomically(folder / "empty.fbx", "");
  EXPECT_THAT(refusal_of([&] { read_clip(folder / "empty.fbx"); }), HasSubstr("empty.fbx"));
  write_atomically(folder / "text.fbx", "this is no FBX file");
  EXPECT_THAT(refusal_of([&] { read_clip(folder / "text.fbx"); }), HasSubstr("text.fbx"));
}

TEST(AssimpMotion, DamagedFilesEndInALineOrAValue) {
  const TempFolder folder;
  write_clip(folder / "walk.glb", slice(read_clip(kWalk), 0, 10));
  std::mt19937 random(1);
  int refused = 0;
  for (const std::string& whole : {kFiles + "blender.fbx", kFiles + "blender.dae", folder / "walk.glb"}) {
    const std::string bytes = read_whole_file(whole);
    const std::string file = folder / ("damaged" + std::filesystem::path(whole).extension().string());
    for (int trial = 0; trial < 16; ++trial) {
      std::string damaged = bytes;
      if (trial % 3 == 0) damaged.resize(std::uniform_int_distribution<size_t>(0, bytes.size() - 1)(random));
      for (int k = 0; k < 8 && !damaged.empty(); ++k)
        damaged[std::uniform_int_distribution<size_t>(0, damaged.size() - 1)(random)] = static_cast<char>(random());
      write_atomically(file, damaged);
      refused += refusal_of([&] { read_clip(file); }).empty() ? 0 : 1;
      refusal_of([&] { read_scene_file(file); });
    }
  }
  EXPECT_GT(refused, 12);
}

}  // namespace
}  // namespace inhabit
