// Protects `inhabit reconstruct` and `inhabit eval reconstruct`: files in, the motion, the room and a page out, nearer
// to the truth than the estimate; whatever does not fit, or is damaged, is one clear line and exit code 2.
#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include "cli/refusal.h"
#include "cli/shards.h"
#include "inhabit/io/files.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/scene_file.h"

namespace inhabit {
namespace {

/// A rendered room of two seconds, made once.
struct RenderedFiles {
  std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("inhabit_rendered_" + std::to_string(::getpid()));
  CommandResult result;
  RenderedFiles() {
    std::filesystem::remove_all(folder);
    result = run_command("eval reconstruct --rooms 1 --seconds 2 --width 200 --seed 3 --keep " + folder.string() +
                         " --json " + folder.string() + ".json");
  }
  ~RenderedFiles() {
    std::filesystem::remove_all(folder);
    std::filesystem::remove(folder.string() + ".json");
  }
  RenderedFiles(const RenderedFiles&) = delete;
  RenderedFiles& operator=(const RenderedFiles&) = delete;
};

const RenderedFiles& rendered_files() {
  static const RenderedFiles files;
  return files;
}

std::string in(const std::string& name) { return (rendered_files().folder / name).string(); }

/// The arguments, with one of them another file.
std::string line_with(const std::string& option = "", const std::string& value = "") {
  std::string out = "reconstruct";
  for (const auto& [name, file] : std::vector<std::pair<std::string, std::string>>{{"--motion", in("estimated.npz")},
                                                                                   {"--camera", in("camera.json")},
                                                                                   {"--depth", in("depth_*.npy")},
                                                                                   {"--masks", in("mask_*.png")}})
    out += " " + name + " '" + (name == option ? value : file) + "'";
  return out;
}

double root_error(const Clip& a, const Clip& truth) {
  return (a.root_path() - truth.root_path()).norm(2, {1}).mean().item<double>();
}

TEST(ReconstructVerb, EvaluationPrintsAndKeeps) {
  const CommandResult& r = rendered_files().result;
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, ::testing::HasSubstr("keys moved"));
  std::ifstream file(rendered_files().folder.string() + ".json");
  EXPECT_TRUE(nlohmann::json::parse(file).is_structured());
}

TEST(ReconstructVerb, ShardsOfAnEvaluationEndInTheSameTable) {
  expect_shards_alike("eval reconstruct --rooms 2 --seconds 2 --width 120 --no-objects --seed 4");
}

TEST(ReconstructVerb, FilesInMotionRoomAndPageOut) {
  const TempFolder folder;
  ASSERT_EQ(rendered_files().result.exit_code, 0) << rendered_files().result.err;
  const CommandResult r =
      run_command(line_with() + " --objects " + in("objects") + " --object-masks " + in("object_masks") + " -o " +
                  folder / "out.npz" + " -o " + folder / "out.html" + " --scene-out " + folder / "room.glb");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, ::testing::ContainsRegex("depth is 0\\.(39|40)"));  // 0.4 raw + 0.6
  const Clip truth = read_clip(in("truth.npz")), estimate = read_clip(in("estimated.npz")),
             out = read_clip(folder / "out.npz");
  ASSERT_EQ(out.frames(), truth.frames());
  EXPECT_LT(root_error(out, truth), 0.7 * root_error(estimate, truth));
  const Scene room = read_scene_file(folder / "room.glb").scene;
  EXPECT_TRUE(std::any_of(room.meshes.begin(), room.meshes.end(), [](const Mesh& m) { return m.name == "floor"; }));
  EXPECT_GT(std::filesystem::file_size(folder / "out.html"), 10000U);
}

TEST(ReconstructVerb, RefusesWhatDoesNotFit) {
  const TempFolder folder;
  ASSERT_EQ(rendered_files().result.exit_code, 0) << rendered_files().result.err;
  std::filesystem::create_directory(folder / "out");
  const std::string out = " -o " + folder / "out/r.npz";
  const auto refused = [&](const std::string& option, const std::string& value, const std::string& reason) {
    expect_refused(line_with(option, value) + out, {reason}, folder / "out");
  };
  refused("--motion", folder / "none.npz", "none.npz");
  refused("--camera", folder / "none.json", "none.json");
  refused("--depth", folder / "none_*.npy", "there is no such file");
  refused("--masks", in("mask_00000*.png"), "there is no mask of frame");
  refused("--masks", in("depth_*.npy"), "no PNG image");
  refused("--depth", in("mask_*.png"), "mask_000000.png");
  expect_refused(line_with() + " --objects " + in("objects") + out, {"meshes and their masks go together"},
                 folder / "out");
  expect_refused(line_with() + " --objects " + in("object_masks") + " --object-masks " + in("object_masks") + out,
                 {"holds no meshes"}, folder / "out");
  expect_refused(line_with() + " --model " INHABIT_SOURCE_DIR "/models/inbetween-compact.safetensors" + out,
                 {"noisy key frames"}, folder / "out");
}

/// The first depth map is another array.
void expect_depth_refused(const TempFolder& folder, const torch::Tensor& map, const std::string& reason) {
  std::filesystem::remove_all(folder / "maps");
  std::filesystem::create_directory(folder / "maps");
  for (int64_t t = 0; t < 60; ++t) {
    const std::string name = "depth_" + std::to_string(t) + ".npy";
    write_npy(folder / ("maps/" + name), map);
  }
  expect_refused(line_with("--depth", folder / "maps/depth_*.npy") + " -o " + folder / "out/r.npz", {reason},
                 folder / "out");
}

TEST(ReconstructVerb, RefusesNumbersThatCannotBe) {
  const TempFolder folder;
  ASSERT_EQ(rendered_files().result.exit_code, 0) << rendered_files().result.err;
  std::filesystem::create_directory(folder / "out");
  const torch::Tensor map = read_npz(in("depth_000000.npy")).at("arr_0", "map");
  torch::Tensor nan = map.clone();
  nan[0][3][4] = NAN;
  expect_depth_refused(folder, nan, "not finite");
  expect_depth_refused(folder, 1 / map, "not disparity");
  expect_depth_refused(folder, map * 1e38, "not finite");
  expect_depth_refused(folder, torch::zeros_like(map), "maps/depth_");
  expect_depth_refused(folder, map.slice(1, 0, 100), "the camera has depth maps");
  // Truncated files of every kind.
  for (const std::string name : {"estimated.npz", "camera.json"}) {
    const std::string cut = folder / name;
    std::filesystem::copy_file(in(name), cut);
    std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
    expect_refused(line_with(name == "camera.json" ? "--camera" : "--motion", cut) + " -o " + folder / "out/r.npz",
                   {name}, folder / "out");
  }
  // The motion in centimetres: the body is not where the masks are.
  Clip far = read_clip(in("estimated.npz"));
  far.trans = far.trans * 100;
  far.joints = far.joints + 0.99 * far.trans.unsqueeze(1);
  write_clip(folder / "centimetres.npz", far);
  expect_refused(line_with("--motion", folder / "centimetres.npz") + " -o " + folder / "out/r.npz", {"one recording"},
                 folder / "out");
}

}  // namespace
}  // namespace inhabit
