// Protects `inhabit forecast`: a recording and a room in, every output format out and readable again, and one clear
// line with nothing written for whatever cannot be forecast.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "cli/examples.h"
#include "cli/refusal.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/files.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/metrics/foot_skating.h"

namespace inhabit {
namespace {

const std::string kModel = INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors";

/// Two seconds at 30 Hz that begin where `last` (22, 3) left off.
void expect_goes_on_from(const Clip& prediction, const torch::Tensor& last) {
  EXPECT_EQ(prediction.frames(), 60);
  EXPECT_EQ(prediction.rate, 30);
  EXPECT_TRUE(torch::isfinite(prediction.joints).all().item<bool>());
  EXPECT_LT((prediction.joints[0] - last).norm(2, {1}).mean().item<float>(), 0.15F);
  const torch::Tensor steps = (prediction.joints.slice(0, 1) - prediction.joints.slice(0, 0, -1)).norm(2, {2});
  EXPECT_LT(steps.max().item<float>(), 0.3F);  // 9 m/s
}

TEST(Forecast, WritesEveryFormatAtOnceAndEachReadsBack) {
  const TempFolder folder;
  std::string line = "forecast " + kWalk + " --scene " + kRoom + " --start 60";
  for (const char* name : {"f.npz", "f.bvh", "f.glb", "f.html", "f.json"}) line += " -o " + folder / name;
  const CommandResult r = run_command(line);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.err, "");

  const Clip walk = read_clip(kWalk);
  const torch::Tensor last = walk.joints[59];
  const Clip npz = read_clip(folder / "f.npz"), written = read_clip(folder / "f.json"),
             bvh = read_clip(folder / "f.bvh");
  expect_goes_on_from(npz, last);
  ASSERT_TRUE(npz.rotations.defined());
  EXPECT_LT((written.joints - npz.joints).abs().max().item<float>(), 1e-3F);
  EXPECT_EQ(bvh.frames(), 60);
  EXPECT_NEAR(bvh.rate, 30, 1e-3);
  const torch::Tensor fitted = joint_positions(npz.skeleton, npz.rotations, npz.trans);  // bones keep their lengths
  EXPECT_LT((fitted - npz.joints).norm(2, {2}).mean().item<float>(), 0.2F);
  for (int j = 0; j < 22; ++j) {
    const int there = bvh.skeleton.find(npz.skeleton.names[static_cast<size_t>(j)]);
    ASSERT_GE(there, 0);
    EXPECT_LT((bvh.joints.select(1, there) - fitted.select(1, j)).abs().max().item<float>(), 2e-3F) << j;
  }

  const std::string glb = read_whole_file(folder / "f.glb");
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const nlohmann::json gltf = nlohmann::json::parse(glb.substr(20, length));
  const size_t times = gltf["animations"][0]["samplers"][0]["input"];
  EXPECT_EQ(gltf["accessors"][times]["count"], 60);
  EXPECT_NEAR(gltf["accessors"][times]["max"][0].get<double>(), 59 / 30.0, 1e-4);
  const Scene scene = read_scene_file(folder / "f.glb").scene;  // the room; the person in it is no part of it
  EXPECT_EQ(scene.meshes.size(), read_scene_file(kRoom).scene.meshes.size());
  EXPECT_EQ(gltf.at("skins").size(), 1U);
  EXPECT_EQ(gltf.at("meshes").size(), scene.meshes.size() + 1);

  const std::string page = read_whole_file(folder / "f.html"),
                    mark = "<script id=\"header\" type=\"application/json\">";
  const size_t begin = page.find(mark);
  ASSERT_NE(begin, std::string::npos);
  const auto header =
      nlohmann::json::parse(page.substr(begin + mark.size(), page.find("</script>", begin) - begin - mark.size()));
  EXPECT_EQ(header["people"].size(), 3U);  // observed, truth, prediction
  EXPECT_TRUE(header.contains("contacts"));
}

TEST(Forecast, StartIsTheFirstPredictedFrameAndTheEndWhereNoneIsGiven) {
  const TempFolder folder;
  const auto forecast = [&](const std::string& options) {
    const CommandResult r =
        run_command("forecast " + kWalk + " --scene " + kRoom + " --points 800" + options + " -o " + folder / "f.npz");
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return read_clip(folder / "f.npz");
  };
  const torch::Tensor walk = read_clip(kWalk).joints;
  expect_goes_on_from(forecast(" --start 30"), walk[29]);
  const Clip end = forecast(" --start 90");
  expect_goes_on_from(end, walk[89]);
  EXPECT_LT((forecast("").joints - end.joints).abs().max().item<float>(), 1e-4F);  // and a seed gives one forecast
}

TEST(Forecast, FeetThatAreWrittenStand) {
  const TempFolder folder;
  double worst = 0;
  for (const auto& [clip, room] : {std::pair(kWalk, kRoom), {kSit, kSitRoom}}) {
    const auto skating = [&,
                          line = "forecast " + clip + " --scene " + room + " --start 45"](const std::string& options) {
      const CommandResult r = run_command(line + options + " -o " + folder / "f.npz");
      EXPECT_EQ(r.exit_code, 0) << r.err;
      return foot_skating(read_clip(folder / "f.npz")).skating;
    };
    const double raw = skating(" --standard --no-refine"), refined = skating(" --standard");
    EXPECT_LE(refined, raw);
    EXPECT_LT(refined, 3);
    EXPECT_LT(skating(""), 3);
    worst = std::max<double>(worst, raw);
  }
  EXPECT_GT(worst, 4) << "as the network moves them: without it this test compares nothing";
}

TEST(Forecast, SaysWhatWasDetectedAndTakesWhatIsGiven) {
  const TempFolder folder;
  SceneFile room = read_scene_file(kRoom);
  for (Mesh& mesh : room.scene.meshes) mesh.vertices = mesh.vertices * 100;
  write_scene(folder / "room.ply", room.scene);
  const std::string line = "forecast " + kWalk + " --scene " + folder / "room.ply" + " -o " + folder / "f.npz";
  const CommandResult detected = run_command(line);
  EXPECT_EQ(detected.exit_code, 0) << detected.err;
  EXPECT_THAT(detected.out, ::testing::HasSubstr("0.01 m per unit"));
  const Clip walk = read_clip(folder / "f.npz");
  ASSERT_EQ(run_command(line + " --scene-scale 0.01 --scene-up y").exit_code, 0);
  EXPECT_TRUE(torch::equal(read_clip(folder / "f.npz").joints, walk.joints));
  ASSERT_EQ(run_command(line + " --scene-scale 1").exit_code, 0);
  EXPECT_FALSE(torch::equal(read_clip(folder / "f.npz").joints, walk.joints)) << "a room a hundred times as large";
}

TEST(Forecast, WithoutASceneSaysThatAFloorIsAssumed) {
  const TempFolder folder;
  const CommandResult r = run_command("forecast " + kWalk + " -o " + folder / "f.npz");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, ::testing::HasSubstr("flat floor under the feet is assumed"));
  expect_goes_on_from(read_clip(folder / "f.npz"), read_clip(kWalk).joints[89]);
}

/// Bad files in one folder, another that must stay empty.
struct BadInput : TempFolder {
  std::string out = *this / "out";
  BadInput() { std::filesystem::create_directory(out); }
  std::string write(const std::string& name, std::string_view bytes) const {
    write_atomically(*this / name, bytes);
    return *this / name;
  }
  void expect_motion_refused(const std::string& motion, const std::string& reason,
                             const std::string& options = "") const {
    expect_refused("forecast " + motion + " --scene " + kRoom + options + " -o " + out + "/f.npz -o " + out + "/f.html",
                   {motion, reason}, out);
  }
  void expect_scene_refused(const std::string& scene, const std::string& reason) const {
    expect_refused("forecast " + kWalk + " --scene " + scene + " -o " + out + "/f.npz -o " + out + "/f.html",
                   {scene, reason}, out);
  }
  void expect_model_refused(const std::string& model, const std::string& reason) const {
    expect_refused("forecast " + kWalk + " --scene " + kRoom + " --model " + model + " -o " + out + "/f.glb",
                   {model, reason}, out);
  }
};

TEST(Forecast, RefusesMotionThatCannotBeObserved) {
  const BadInput bad;
  bad.expect_motion_refused(bad / "none.npz", "no such file");
  bad.expect_motion_refused(bad.write("empty.npz", ""), "is empty");
  bad.expect_motion_refused(kRoom, "holds no skeleton of a person that an animation moves");
  bad.expect_motion_refused(bad.write("room.obj", "v 0 0 0\n"), "no motion format");
  bad.expect_motion_refused(bad.write("cut.npz", read_whole_file(kWalk).substr(0, 5000)), "");

  const Clip walk = read_clip(kWalk);
  write_clip(bad / "one.npz", slice(walk, 0, 1));
  bad.expect_motion_refused(bad / "one.npz", "30 are needed");
  write_clip(bad / "short.npz", slice(walk, 0, 29));
  bad.expect_motion_refused(bad / "short.npz", "has 29 frames");

  const auto broken = [&](const std::string& name, const auto& change) {
    Npz arrays = npz_from_clip(walk, name);
    for (auto& entry : arrays.tensors) entry.second = entry.second.clone();
    change(arrays.tensors);
    write_npz(bad / name, arrays);
    return bad / name;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  bad.expect_motion_refused(broken("nan.npz", [&](auto& t) { t["joints"][5][3][1] = nan; }), "not finite");
  bad.expect_motion_refused(broken("rate.npz", [](auto& t) { t["mocap_framerate"].fill_(-30); }), "");
  bad.expect_motion_refused(broken("cyclic.npz", [](auto& t) { t["parents"][3] = 6; }), "");
  bad.expect_motion_refused(broken("few.npz", [](auto& t) { t["joints"] = t["joints"].slice(1, 0, 20); }), "");
}

TEST(Forecast, RefusesAStartWithoutASecondBeforeItOrBeyondTheEnd) {
  const BadInput bad;
  bad.expect_motion_refused(kWalk, "30 are needed", " --start 29");
  bad.expect_motion_refused(kWalk, "30 are needed", " --start 0");
  bad.expect_motion_refused(kWalk, "beyond the end (90 frames)", " --start 91");
  bad.expect_motion_refused(kWalk, "beyond the end", " --start 1000000000000");
  for (const char* start : {"-1", "x"})
    expect_refused("forecast " + kWalk + " --start " + start + " -o " + bad.out + "/f.npz", {"--start"}, bad.out);
}

TEST(Forecast, RefusesScenesThatHoldNothingNear) {
  const BadInput bad;
  bad.expect_scene_refused(bad / "none.obj", "no such file");
  bad.expect_scene_refused(bad.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\n"), "no faces");
  bad.expect_scene_refused(bad.write("none.xyz", "\n\n"), "");
  bad.expect_scene_refused(bad.write("far.obj", "v 90 0 0\nv 91 0 0\nv 90 0 1\nf 1 2 3\n"), "lies within 2.50 m");
  bad.expect_scene_refused(bad.write("far.xyz", "90 0 0\n91 0 0\n90 0 1\n"), "lies within 2.50 m");
}

TEST(Forecast, RefusesOutputsBeforeAnythingIsWritten) {
  const BadInput bad;
  const std::string file = bad.write("file", "x"), good = "forecast " + kWalk + " -o " + bad.out + "/f.npz";
  expect_refused(good + " -o " + bad.out + "/f.fbx", {"f.fbx", "is no output of a forecast"}, bad.out);
  expect_refused(good + " -o " + bad / "none/f.npz", {"none/f.npz", "there is no folder"}, bad.out);
  expect_refused(good + " -o " + file + "/f.bvh", {"file/f.bvh", "there is no folder"}, bad.out);
  std::filesystem::create_directory(bad / "folder.npz");
  expect_refused(good + " -o " + bad / "folder.npz", {"folder.npz", "it is a folder"}, bad.out);
  expect_refused(good + " -o /proc/f.glb", {"/proc/f.glb", "cannot be written"}, bad.out);
}

TEST(Forecast, RefusesModelFilesOfAnotherSystemOrDamaged) {
  const BadInput bad;
  bad.expect_model_refused(bad / "none.safetensors", "no such file");
  bad.expect_model_refused(bad.write("cut.safetensors", read_whole_file(kModel).substr(0, 200000)), "truncated");

  SafeTensors other;
  other.tensors["layer.weight"] = torch::ones({2, 3});
  write_safetensors(bad / "plain.safetensors", other);
  bad.expect_model_refused(bad / "plain.safetensors", "is not a model of contact-forecast");
  other.metadata = {{"system", "in-betweening"}};
  write_safetensors(bad / "foreign.safetensors", other);
  bad.expect_model_refused(bad / "foreign.safetensors", "but of 'in-betweening'");

  const SafeTensors shipped = read_safetensors(kModel);
  for (const char* network : {"contact_net.", "articulated_net."}) {
    SafeTensors lacking{{}, shipped.metadata};
    for (const auto& [name, tensor] : shipped.tensors)
      if (name.rfind(network, 0) != 0) lacking.tensors[name] = tensor;
    const std::string file = bad / (std::string("no_") + network + "safetensors");
    write_safetensors(file, lacking);
    bad.expect_model_refused(file, "lacks the contact or the motion network");
  }
  SafeTensors poisoned = shipped;
  poisoned.tensors.begin()->second.view({-1})[0] = std::numeric_limits<float>::infinity();
  write_safetensors(bad / "inf.safetensors", poisoned);
  bad.expect_model_refused(bad / "inf.safetensors", "not finite");
}

TEST(Forecast, RefusesANumberOfPointsThatMakesNoSense) {
  const BadInput bad;
  for (const char* points : {"0", "100000000"})
    expect_refused("forecast " + kWalk + " --points " + points + " -o " + bad.out + "/f.npz", {"--points"}, bad.out);
}

}  // namespace
}  // namespace inhabit
