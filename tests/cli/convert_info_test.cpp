#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/refusal.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/files.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/scene_file.h"
#include "shared.h"

namespace inhabit {
namespace {

/// A second of a person who strides and swings the arms.
Clip striding() {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  const torch::Tensor t = torch::arange(30) / 30.0;
  clip.rotations = torch::zeros({30, 22, 3});
  for (const auto& [joint, axis, size] :
       {std::tuple(1, 0, 0.4), std::tuple(2, 0, -0.4), std::tuple(4, 0, 0.3), std::tuple(5, 0, 0.3),
        std::tuple(16, 2, -1.2), std::tuple(17, 2, 1.2), std::tuple(18, 1, -0.3), std::tuple(19, 1, 0.3)})
    clip.rotations.select(1, joint).select(1, axis).copy_(size * (1 + 0.3 * torch::sin(6.28 * t)));
  clip.trans = torch::stack({0 * t, 0.95 + 0 * t, 1.2 * t}, 1).to(torch::kFloat32);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  clip.action_names = {"walk"};
  clip.action = torch::zeros({30}, torch::kInt64);
  return clip;
}

TEST(Convert, GoesRoundThroughEveryMotionFormat) {
  const TempFolder folder;
  const Clip clip = striding();
  write_clip_npz(folder / "walk.npz", clip);
  for (const char* step : {"walk.npz walk.json", "walk.json walk.bvh", "walk.bvh back.npz", "walk.npz walk.glb"}) {
    const std::string line(step);
    const size_t space = line.find(' ');
    const CommandResult r =
        run_command("convert " + folder / line.substr(0, space) + " " + folder / line.substr(space + 1));
    ASSERT_EQ(r.exit_code, 0) << r.err;
    EXPECT_NE(r.out.find("30 frames at 30"), std::string::npos) << r.out;
  }
  const Clip back = read_clip(folder / "back.npz");
  ASSERT_EQ(back.frames(), 30);
  for (int j = 0; j < 22; ++j) {
    const int there = back.skeleton.find(clip.skeleton.names[static_cast<size_t>(j)]);
    ASSERT_GE(there, 0);
    EXPECT_LT((back.joints.select(1, there) - clip.joints.select(1, j)).abs().max().item<float>(), 1e-3F) << j;
  }
}

TEST(Convert, ReadsWhatAnimatorsExport) {
  const TempFolder folder;
  const std::string fbx = INHABIT_SOURCE_DIR "/tests/io/data/blender.fbx";
  const CommandResult r = run_command("convert " + fbx + " " + folder / "walk.bvh");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("10 frames at 30 a second"), std::string::npos) << r.out;
  EXPECT_NE(read_clip(folder / "walk.bvh").skeleton.find("left_ankle"), -1);
  const CommandResult told = run_command("info " + fbx);
  EXPECT_NE(told.out.find("kind: motion"), std::string::npos) << told.out;
  write_atomically(folder / "torn.fbx", read_whole_file(fbx).substr(0, 20000));
  std::filesystem::create_directories(folder / "out");
  expect_refused("convert " + folder / "torn.fbx" + " " + folder / "out/x.npz", {"torn.fbx"}, folder / "out");
}

TEST(Convert, ResamplesAndRetargets) {
  const TempFolder folder;
  write_clip_npz(folder / "walk.npz", striding());
  CommandResult r = run_command("convert " + folder / "walk.npz" + " " + folder / "slow.npz" + " --rate 15");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(read_clip(folder / "slow.npz").frames(), 15);
  ASSERT_EQ(run_command("convert " + folder / "walk.npz" + " " + folder / "walk.bvh").exit_code, 0);
  r = run_command("convert " + folder / "walk.bvh" + " " + folder / "standard.npz --retarget");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const Clip standard = read_clip(folder / "standard.npz");
  EXPECT_EQ(standard.skeleton.names, standard_joint_names());
  EXPECT_LT((standard.joints - striding().joints).norm(2, {2}).max().item<float>(), 0.02F);
}

TEST(Convert, PositionsAloneAreFittedForBvhAndGltf) {
  const TempFolder folder;
  Clip clip = striding();
  clip.rotations = clip.trans = torch::Tensor();
  write_clip_npz(folder / "joints.npz", clip);
  for (const char* name : {"fitted.bvh", "fitted.glb"}) {
    const CommandResult r = run_command("convert " + folder / "joints.npz" + " " + folder / name);
    EXPECT_EQ(r.exit_code, 0) << r.err;
  }
  const Clip fitted = read_clip(folder / "fitted.bvh");
  const int wrist = fitted.skeleton.find("left_wrist");
  EXPECT_LT((fitted.joints.select(1, wrist) - clip.joints.select(1, 20)).norm(2, {1}).max().item<float>(), 0.02F);
}

TEST(Convert, ScenesBecomeGltfAndPly) {
  const TempFolder folder;
  write_atomically(
      folder / "room.obj",
      "o floor\nv 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nf 4 3 2 1\no wall\nv 0 0 0\nv 0 2 0\nv 4 2 0\nf 5 6 7\n");
  write_clip_npz(folder / "walk.npz", striding());
  ASSERT_EQ(run_command("convert " + folder / "room.obj" + " " + folder / "room.glb").exit_code, 0);
  ASSERT_EQ(run_command("convert " + folder / "room.glb" + " " + folder / "room.ply").exit_code, 0);
  const Scene glb = read_scene_file(folder / "room.glb").scene;
  ASSERT_EQ(glb.meshes.size(), 2U);
  EXPECT_EQ(glb.meshes[0].name, "floor");
  EXPECT_EQ(glb.meshes[1].name, "wall");
  SceneReadOptions options;
  options.up = UpAxis::y;
  EXPECT_EQ(read_scene_file(folder / "room.ply", options).report.triangles, 3);
  EXPECT_EQ(run_command("convert " + folder / "walk.npz" + " " + folder / "both.glb --scene " + folder / "room.obj")
                .exit_code,
            0);
  EXPECT_GT(std::filesystem::file_size(folder / "both.glb"), std::filesystem::file_size(folder / "room.glb"));
  // Of a file that holds motion and a scene, .ply is the scene.
  ASSERT_EQ(run_command("convert " + folder / "both.glb" + " " + folder / "again.ply").exit_code, 0);
  EXPECT_EQ(read_scene_file(folder / "again.ply", options).report.triangles, 3);
}

TEST(Convert, BadInputIsOneLineAndLeavesNothing) {
  const TempFolder folder;
  const std::filesystem::path out = folder.path / "out";
  std::filesystem::create_directory(out);
  write_clip_npz(folder / "walk.npz", striding());
  const std::string whole = read_whole_file(folder / "walk.npz");
  write_atomically(folder / "empty.npz", "");
  write_atomically(folder / "cut.npz", whole.substr(0, whole.size() / 2));
  write_atomically(folder / "garbage.npz", std::string("\x01\x02\xFF garbage \n more"));
  write_atomically(folder / "garbage.bvh", "HIERARCHY\nROOT a\n{\n");
  write_atomically(folder / "garbage.json", "{\"format\": 3}");
  write_atomically(folder / "garbage.amc", ":FULLY-SPECIFIED\n");
  write_atomically(folder / "commas.xyz", "1,2,x\n");
  write_atomically(folder / "picture.png", "not one");
  std::filesystem::copy_file(folder / "walk.npz", folder / "wrong.bvh");
  for (const char* name : {"missing.npz", "missing.obj", "empty.npz", "cut.npz", "garbage.npz", "garbage.bvh",
                           "garbage.json", "garbage.amc", "commas.xyz", "picture.png", "wrong.bvh"}) {
    expect_refused("convert " + folder / name + " " + (out / "out.npz").string(), {name}, out);
  }
  write_atomically(folder / "skeleton.asf", ":version 1.10\n");
  write_atomically(folder / "garbage.glb", "glTF, but not one");
  write_atomically(folder / "garbage.gltf", "{\"asset\": nonsense");
  write_atomically(folder / "garbage.pcd", std::string("\x9f\x88 \x01\x02\n"));
  for (const char* name : {"missing", "empty.npz", "garbage.bvh", "picture.png", "skeleton.asf", "garbage.glb",
                           "garbage.gltf", "garbage.pcd"})
    expect_refused("info " + folder / name, {name}, out);
  expect_refused("convert " + folder / "walk.npz" + " " + (out / "out.xyz").string(), {"out.xyz"}, out);
  expect_refused("convert " + folder / "walk.npz" + " " + (out / "none/out.npz").string(), {"folder"}, out);
  expect_refused("convert " + folder / "cut.npz" + " " + out.string() + "/", {"cut.npz"}, out);
  expect_refused("convert " + folder / "walk.npz" + " " + (out / "out.npz --rate -3").string(), {"--rate"}, out);
  expect_refused("convert " + folder / "walk.npz" + " " + (out / "out.npz --rate nan").string(), {"--rate"}, out);
  expect_refused("convert " + folder / "walk.npz" + " " + (out / "out.npz --up x").string(), {"--up"}, out);
  expect_refused("convert " + folder / "walk.npz" + " " + (out / "out.npz --body ").string() + folder / "walk.npz",
                 {"model"}, out);
  expect_refused("convert " + folder / "walk.npz" + " " + (out / "out.npz --scene ").string() + folder / "walk.npz",
                 {"out.npz"}, out);
  expect_refused("convert " + folder / "walk.npz", {"OUT"}, out);
  expect_refused("info", {"FILE"}, out);
  expect_refused("info " + folder.path.string(), {"dataset.json"}, out);
}

TEST(Info, NumPyCloudsAreScenes) {
  const TempFolder folder;
  write_npy(folder / "cloud.npy", torch::rand({40, 3}));
  Npz nameless;
  nameless.tensors["arr_0"] = torch::rand({40, 3});
  write_npz(folder / "cloud.npz", nameless);
  for (const std::string name : {"cloud.npy", "cloud.npz"}) {
    const CommandResult r = run_command("info --json " + folder / name);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const auto info = nlohmann::json::parse(r.out);
    EXPECT_EQ(info["kind"], "scene");
    EXPECT_EQ(info["points"], 40);
    ASSERT_EQ(run_command("convert " + folder / name + " " + folder / name + ".glb").exit_code, 0);
    EXPECT_EQ(read_scene_file(folder / name + ".glb").report.points, 40);
  }
}

TEST(Info, SaysWhatAMotionHolds) {
  const TempFolder folder;
  write_clip_npz(folder / "walk.npz", striding());
  const CommandResult text = run_command("info " + folder / "walk.npz");
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_NE(text.out.find("frames: 30\n"), std::string::npos) << text.out;
  const auto info = nlohmann::json::parse(run_command("info --json " + folder / "walk.npz").out);
  EXPECT_EQ(info["kind"], "motion");
  EXPECT_EQ(info["seconds"], 1.0);
  EXPECT_EQ(info["actions"]["walk"], 30);
  EXPECT_NEAR(info["mean_speed"].get<double>(), 1.2, 0.01);
}

TEST(Info, KnowsScenesAndWeights) {
  const TempFolder folder;
  write_atomically(folder / "a.xyz", "0 0 0\n1 2 3\n");
  const auto cloud = nlohmann::json::parse(run_command("info --json --up y " + folder / "a.xyz").out);
  EXPECT_EQ(cloud["kind"], "scene");
  EXPECT_EQ(cloud["points"], 2);
  const auto weights = nlohmann::json::parse(
      run_command("info --json " INHABIT_SOURCE_DIR "/tests/data/parity/cmu_forward_kinematics.safetensors").out);
  EXPECT_EQ(weights["kind"], "weights");
  EXPECT_GT(weights["parameters"].get<int>(), 100);
}

TEST(Info, ReadsTheRecordingsAtHand) {
  if (shared_folder().empty()) GTEST_SKIP() << "no recordings beside the project";
  for (const char* name : {"/data/trumans/2023-02-12_22-16-01.npz", "/data/bvh/sample.bvh", "/data/asf_amc/02_01.amc",
                           "/data/cmu/test/walking/walking_1.txt", "/data/trumans/room.glb"}) {
    const CommandResult r = run_command("info --json " + shared_folder() + name);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const auto info = nlohmann::json::parse(r.out);
    const double height = info["box"]["upper"][1].get<double>() - info["box"]["lower"][1].get<double>();
    EXPECT_GT(height, 1.3) << name;  // a person, or a room, in metres
    EXPECT_LT(height, 4.5) << name;
  }
}

}  // namespace
}  // namespace inhabit
