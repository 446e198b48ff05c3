// What a visitor does with a page: moves about with keys and fingers, saves pictures and motion, opens files, looks at
// what is in the scene. viewer/test/use_test.mjs does it in headless Chromium.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <random>

#include "cli/command.h"
#include "in_browser.h"
#include "inhabit/io/files.h"
#include "inhabit/io/npz.h"
#include "inhabit/synth/room.h"
#include "inhabit/view/cards_page.h"
#include "refusal_of.h"
#include "view/striding.h"

namespace inhabit {
namespace {

/// A box that slides 1 m along +X while it rotates by 90 degrees about its upright axis, at (1, 0, 2) in the first
/// frame.
void slide(Clip& clip, const std::string& object) {
  const int64_t frames = clip.frames();
  const torch::Tensor part = torch::arange(frames).to(torch::kFloat32) / static_cast<double>(frames - 1);
  clip.object_names = {"lamp", object};
  clip.object_pose = torch::zeros({frames, 2, 6});
  clip.object_pose.select(1, 1).select(1, 0).copy_(1 + part);
  clip.object_pose.select(1, 1).select(1, 2).fill_(2);
  clip.object_pose.select(1, 1).select(1, 4).copy_(part * (M_PI / 2));
}

Mesh box(const std::string& name, double x, double z) {
  Mesh mesh;
  mesh.name = name;
  std::vector<float> corners;
  for (int i = 0; i < 8; ++i)
    for (const double c : {x + ((i & 1) != 0 ? 0.3 : -0.3), (i & 2) != 0 ? 0.5 : 0.0, z + ((i & 4) != 0 ? 0.2 : -0.2)})
      corners.push_back(static_cast<float>(c));
  mesh.vertices = torch::tensor(corners).reshape({8, 3});
  mesh.faces = torch::tensor({0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                              2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5},
                             torch::kInt64)
                   .reshape({12, 3});
  return mesh;
}

/// Three joints, the last of which swings so that no bone is rigid in the world's axes; positions alone.
Clip swinging_chain() {
  Clip clip;
  clip.skeleton.names = {"base", "middle", "end"};
  clip.skeleton.parents = {-1, 0, 1};
  clip.skeleton.offsets = torch::tensor({{0.0F, 0.0F, 0.0F}, {0.0F, 0.6F, 0.0F}, {0.0F, 0.5F, 0.0F}});
  const torch::Tensor angle = torch::arange(20).to(torch::kFloat32) * 0.1;
  const torch::Tensor zero = torch::zeros({20}), middle = torch::stack({0.3 * torch::sin(angle), zero + 0.9, zero}, 1);
  clip.joints = torch::stack({torch::stack({zero, zero + 0.3, 0.2 * angle}, 1), middle,
                              middle + 0.5 * torch::stack({torch::sin(angle), torch::cos(angle), zero}, 1)},
                             1);
  clip.rate = 24;
  return clip;
}

/// Joints of `given`, by name, in what was read back from a .bvh of it: largest distance in metres.
double farthest(const Clip& given, const Clip& read) {
  EXPECT_EQ(given.frames(), read.frames());
  EXPECT_NEAR(given.rate, read.rate, 1e-3);
  double worst = 0;
  for (size_t j = 0; j < given.skeleton.names.size(); ++j) {
    const auto& names = read.skeleton.names;
    const auto found = std::find(names.begin(), names.end(), given.skeleton.names[j]);
    if (found == names.end()) return 1e9;
    const torch::Tensor apart =
        given.joints.select(1, static_cast<int64_t>(j)) - read.joints.select(1, found - names.begin());
    worst = std::max(worst, apart.norm(2, {1}).max().item<double>());
  }
  return worst;
}

TEST(PageInBrowser, IsUsedByVisitors) {
  TempFolder folder;
  Clip walk = striding(60, 0, -1), other = striding(90, 1.2, -1.5);
  slide(walk, "box_0");
  Scene scene = floor_scene();
  scene.meshes.push_back(box("box_0", 1, 2));
  scene.meshes.push_back(box("box_0.1", 1, 2.2));
  scene.meshes.push_back(box("stool_1", -2, 0));
  Page page;
  page.title = "Two in a room";
  page.note = "Somebody walks, somebody else too.";
  page.scene = &scene;
  page.people = {{walk, "first"}, {other, "second"}};
  write_page(folder / "two.html", page);

  // A cabinet between the walker and where the camera stands first where nothing is in between.
  Scene hiding = floor_scene();
  hiding.meshes.push_back(box("cabinet", 0, 0));
  hiding.meshes.back().vertices =
      hiding.meshes.back().vertices * torch::tensor({2.5F, 4.5F, 2.5F}) + torch::tensor({1.4F, 0.0F, 1.4F});
  Page hidden;
  hidden.title = "hidden";
  hidden.scene = &hiding;
  hidden.people = {{striding(60, 0, -1), "walker"}};
  write_page(folder / "hidden.html", hidden);

  Page chain;
  chain.title = "chain";
  chain.people = {{swinging_chain(), "chain"}};
  write_page(folder / "chain.html", chain);

  write_empty_page(folder / "empty.html", "");

  write_clip(folder / "walk.npz", walk);
  Clip z_up = walk;
  z_up.file.format = "npz";
  z_up.file.z_up = true;
  write_clip(folder / "z_up.npz", z_up);
  const std::vector<torch::Tensor> xyz = walk.joints.unbind(2);
  Npz bare;  // as networks write joints: flattened, in millimetres, +Z up, without a rate
  bare.tensors["poses_3d"] = (torch::stack({xyz[0], -xyz[2], xyz[1]}, 2) * 1000).reshape({walk.frames(), -1});
  write_npz(folder / "bare.npz", bare);
  write_clip(folder / "walk.glb", walk, &scene);
  std::mt19937_64 random(3);
  const Scene room = make_room(random).scene();
  write_scene(folder / "room.glb", room);
  std::ofstream(folder / "bad.npz") << "this is no archive";
  const std::string glb = read_whole_file(folder / "room.glb"), npz = read_whole_file(folder / "walk.npz");
  std::ofstream(folder / "cut.glb") << glb.substr(0, glb.size() / 2);
  std::ofstream(folder / "cut.npz") << npz.substr(0, npz.size() / 2);
  std::ofstream(folder / "notes.txt") << "hello";

  nlohmann::json expected;
  const torch::Tensor joints = walk.joints[30].contiguous();
  for (int64_t j = 0; j < joints.size(0); ++j)
    expected["joints"].push_back({joints[j][0].item<float>(), joints[j][1].item<float>(), joints[j][2].item<float>()});
  expected["meshes"] = room.meshes.size();
  std::ofstream(folder / "expected.json") << expected.dump();

  std::string said;
  const int status = in_browser("use_test.mjs", folder, said);
  if (status == kNoBrowser) GTEST_SKIP() << said;
  ASSERT_EQ(status, 0) << said;

  // What the page saved, read back: the same joints within a millimetre.
  EXPECT_LT(farthest(walk, read_clip(folder / "saved/first.bvh")), 0.001);
  EXPECT_LT(farthest(other, read_clip(folder / "saved/second.bvh")), 0.001);
  ClipReadOptions centimetres;
  centimetres.scale = 0.01;  // a chain is no person whose size would tell
  EXPECT_LT(farthest(swinging_chain(), read_clip(folder / "saved/chain.bvh", centimetres)), 0.001);
  const CommandResult info = run_command("info " + (folder / "saved/first.bvh"));
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_NE(info.out.find("frames: 60"), std::string::npos) << info.out;
  EXPECT_NE(info.out.find("left_wrist"), std::string::npos) << info.out;
}

TEST(Page, MovesOnlyObjectsThatMove) {
  TempFolder folder;
  Page page;
  Clip clip = striding(30, 0, 0);
  slide(clip, "box_0");
  page.people = {{clip, "somebody"}};
  write_page(folder / "page.html", page);
  const std::string text = read_whole_file(folder / "page.html");
  EXPECT_NE(text.find("\"name\":\"box_0\""), std::string::npos);
  EXPECT_EQ(text.find("\"name\":\"lamp\""), std::string::npos);
}

TEST(ViewCommand, WritesAnEmptyPage) {
  TempFolder folder;
  const CommandResult result = run_command("view -o " + (folder / "page.html"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("to drop files on"), std::string::npos) << result.out;
  EXPECT_NE(read_whole_file(folder / "page.html").find("\"people\":[]"), std::string::npos);
}

TEST(ViewCommand, ShowsASceneAlone) {
  TempFolder folder;
  write_scene(folder / "floor.glb", floor_scene());
  const CommandResult result = run_command("view --scene " + (folder / "floor.glb") + " -o " + (folder / "page.html"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(read_whole_file(folder / "page.html").find("<title>floor</title>"), std::string::npos);
}

}  // namespace
}  // namespace inhabit
