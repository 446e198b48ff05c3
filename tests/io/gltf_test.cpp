#include "inhabit/io/gltf.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/math/rotation.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

Clip waving(int64_t frames, const Skeleton& skeleton) {
  Clip clip;
  clip.skeleton = skeleton;
  clip.rotations = torch::randn({frames, skeleton.size(), 3}) * 0.4;
  clip.rotations[frames - 1].zero_();
  clip.trans = torch::randn({frames, 3}) + torch::tensor({0.F, 1.F, 0.F});
  clip.joints = joint_positions(skeleton, clip.rotations, clip.trans);
  return clip;
}

Scene room() {
  Scene scene = floor_scene();
  Mesh chair;
  chair.name = "chair \"0\" \xC3\xA4";
  chair.vertices = torch::tensor({0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F}).view({4, 3});
  chair.faces = torch::tensor({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, torch::kInt64).view({4, 3});
  chair.color = {0.6F, 0.1F, 0.2F};
  scene.meshes.push_back(chair);
  return scene;
}

/// The JSON chunk of a .glb.
nlohmann::json json_of(const std::string& glb) {
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  return nlohmann::json::parse(glb.substr(20, length));
}

/// Rows of an accessor as floats (F, components).
torch::Tensor floats_of(const std::string& glb, const nlohmann::json& gltf, int accessor, int64_t components) {
  uint32_t json_length = 0;
  std::memcpy(&json_length, glb.data() + 12, 4);
  const auto& a = gltf["accessors"][static_cast<size_t>(accessor)];
  const auto& view = gltf["bufferViews"][a["bufferView"].get<size_t>()];
  const char* begin = glb.data() + 20 + json_length + 8 + view.value("byteOffset", 0);
  torch::Tensor out = torch::empty({a["count"].get<int64_t>(), components});
  std::memcpy(out.data_ptr(), begin, out.nbytes());
  return out;
}

/// Skinned vertices at `frame`, evaluated as a glTF viewer does: nodes, tracks, inverse bind matrices, weights.
torch::Tensor evaluate(const std::string& glb, int64_t frame) {
  const nlohmann::json gltf = json_of(glb);
  const auto& skin = gltf["skins"][0];
  const auto nodes = skin["joints"].get<std::vector<int>>();
  std::map<int, torch::Tensor> rotation, translation;
  for (const auto& channel : gltf["animations"][0]["channels"]) {
    const int output = gltf["animations"][0]["samplers"][channel["sampler"].get<size_t>()]["output"].get<int>();
    const int node = channel["target"]["node"].get<int>();
    if (channel["target"]["path"] == "rotation")
      rotation[node] = floats_of(glb, gltf, output, 4)[frame];
    else
      translation[node] = floats_of(glb, gltf, output, 3)[frame];
  }
  std::map<int, torch::Tensor> global;
  const std::function<void(int, const torch::Tensor&)> descend = [&](int index, const torch::Tensor& parent) {
    const auto& node = gltf["nodes"][static_cast<size_t>(index)];
    torch::Tensor local = torch::eye(4);
    torch::Tensor shift = translation.count(index) != 0 ? translation[index] : torch::zeros({3});
    if (translation.count(index) == 0 && node.contains("translation"))
      for (int k = 0; k < 3; ++k) shift[k] = node["translation"][static_cast<size_t>(k)].get<float>();
    const torch::Tensor q = rotation.at(index);
    local.slice(0, 0, 3).slice(1, 0, 3).copy_(quaternion_to_matrix(torch::stack({q[3], q[0], q[1], q[2]})));
    local.slice(0, 0, 3).select(1, 3).copy_(shift);
    global[index] = parent.matmul(local);
    if (node.contains("children"))
      for (const int child : node["children"].get<std::vector<int>>()) descend(child, global[index]);
  };
  descend(nodes[0], torch::eye(4));
  const torch::Tensor bind = floats_of(glb, gltf, skin["inverseBindMatrices"].get<int>(), 16).view({-1, 4, 4});
  std::vector<torch::Tensor> matrices;
  for (size_t j = 0; j < nodes.size(); ++j)
    matrices.push_back(global[nodes[j]].matmul(bind[static_cast<int64_t>(j)].t()));
  const auto& attributes = gltf["meshes"][0]["primitives"][0]["attributes"];
  const torch::Tensor vertices = floats_of(glb, gltf, attributes["POSITION"].get<int>(), 3);
  const torch::Tensor weights = floats_of(glb, gltf, attributes["WEIGHTS_0"].get<int>(), 4);
  const torch::Tensor packed = floats_of(glb, gltf, attributes["JOINTS_0"].get<int>(), 2);  // four 16-bit numbers
  torch::Tensor joints = torch::empty({vertices.size(0), 4}, torch::kInt16);
  std::memcpy(joints.data_ptr(), packed.data_ptr(), joints.nbytes());
  const torch::Tensor per_vertex =
      torch::stack(matrices).index_select(0, joints.to(torch::kInt64).reshape({-1})).view({-1, 4, 4, 4});
  const torch::Tensor blended = (weights.unsqueeze(2).unsqueeze(3) * per_vertex).sum(1);
  const torch::Tensor homogeneous = torch::cat({vertices, torch::ones({vertices.size(0), 1})}, 1);
  return blended.matmul(homogeneous.unsqueeze(2)).squeeze(2).narrow(1, 0, 3);
}

/// Runs Khronos' validator (npm ci in tests/gltf_validator); empty where it is not installed.
std::optional<CommandResult> validator(const std::string& file) {
  const std::string folder = INHABIT_SOURCE_DIR "/tests/gltf_validator";
  if (!std::filesystem::exists(folder + "/node_modules/gltf-validator")) return std::nullopt;
  return run_program("node " + folder + "/validate.mjs " + file);
}

TEST(Gltf, TheValidatorFindsNothingWrong) {
  torch::manual_seed(1);
  const TempFolder folder;
  const Clip standing = waving(7, builtin_body().skeleton);
  Clip shaped = waving(1, builtin_body().skeleton);
  shaped.betas = torch::tensor({1.5F, -1.F});
  shaped.skeleton = shaped_skeleton(builtin_body(), shaped.betas);
  const Clip strange = waving(4, {{"a", "b", "c", "d"}, {-1, 0, 1, 0}, torch::randn({4, 3})});
  Scene scene = room();
  scene.points = torch::randn({50, 3});
  write_glb(folder / "people.glb",
            {{&standing, &builtin_body(), "first"}, {&shaped, &builtin_body(), "second"}, {&strange, nullptr, "third"}},
            &scene);
  write_glb(folder / "scene.glb", {}, &scene);
  write_glb(folder / "person.glb", {{&standing, &builtin_body()}});
  for (const char* name : {"people.glb", "scene.glb", "person.glb"}) {
    const auto result = validator(folder / name);
    if (!result) GTEST_SKIP() << "npm ci --prefix tests/gltf_validator installs the validator";
    EXPECT_EQ(result->exit_code, 0) << result->out << result->err;
  }
}

TEST(Gltf, AViewerSeesTheSamePoseAsSkinning) {
  torch::manual_seed(2);
  Clip clip = waving(3, builtin_body().skeleton);
  clip.betas = torch::tensor({1.0F, 0.5F, -0.5F, 0.F, 1.F});
  clip.skeleton = shaped_skeleton(builtin_body(), clip.betas);
  const std::string glb = glb_bytes({{&clip, &builtin_body()}}, nullptr, "memory");
  for (int64_t frame = 0; frame < 3; ++frame) {
    const torch::Tensor expected =
        skin(builtin_body(), clip.betas, axis_angle_to_matrix(clip.rotations[frame]), clip.trans[frame]);
    // glTF keeps the four largest weights of a vertex; the built-in body may have a few more.
    EXPECT_LT((evaluate(glb, frame) - expected).norm(2, {1}).max().item<float>(), 0.01F) << frame;
  }
}

TEST(Gltf, BonesOfAnySkeletonFollowItsJoints) {
  torch::manual_seed(3);
  const Clip clip = waving(2, {{"a", "b", "c"}, {-1, 0, 1}, torch::randn({3, 3})});
  const std::string glb = glb_bytes({{&clip}}, nullptr, "memory");
  for (int64_t frame = 0; frame < 2; ++frame) {
    const torch::Tensor vertices = evaluate(glb, frame);
    for (int64_t j = 0; j < 3; ++j)  // each spindle begins exactly in its joint
      EXPECT_LT((vertices - clip.joints[frame][j]).norm(2, {1}).min().item<float>(), 1e-4F);
  }
}

TEST(Gltf, SceneNamesAndColoursAreReadBack) {
  const TempFolder folder;
  const Scene scene = room();
  write_glb(folder / "room.glb", {}, &scene);
  const Scene back = read_scene_file(folder / "room.glb").scene;
  ASSERT_EQ(back.meshes.size(), 2U);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back.meshes[i].name, scene.meshes[i].name);
    EXPECT_EQ(back.meshes[i].faces.size(0), scene.meshes[i].faces.size(0));
    EXPECT_TRUE(
        torch::equal(std::get<0>(back.meshes[i].vertices.max(0)), std::get<0>(scene.meshes[i].vertices.max(0))));
    for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(back.meshes[i].color[k], scene.meshes[i].color[k], 1e-6);
  }
}

TEST(Gltf, WhatCannotBeWrittenIsSaid) {
  const TempFolder folder;
  Clip clip = waving(2, builtin_body().skeleton);
  clip.rotations = torch::Tensor();
  EXPECT_THROW(write_glb(folder / "a.glb", {{&clip}}), Error);
  const Scene nothing;
  EXPECT_THROW(write_glb(folder / "a.glb", {}, &nothing), Error);
  Scene broken = room();
  broken.meshes[0].faces[0][0] = 99;
  EXPECT_THROW(write_glb(folder / "a.glb", {}, &broken), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
}

}  // namespace
}  // namespace inhabit
