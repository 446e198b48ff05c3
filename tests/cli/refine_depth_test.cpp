// Protects `inhabit refine --depth`: a jittered motion and what a depth camera saw in, a motion nearer to the truth
// out; clouds in a folder and in one file, a body model from a file, and one clear line with nothing written for what
// cannot be.
#include <gtest/gtest.h>

#include "cli/examples.h"
#include "cli/refusal.h"
#include "depth_camera.h"
#include "inhabit/io/files.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/smpl_model.h"

namespace inhabit {
namespace {

using torch::Tensor;

constexpr int64_t kSeen = 24;  // frames

/// The walk on the built-in body's bones.
Clip seen_walk() {
  Clip clip = slice(read_clip(kWalk), 0, kSeen);
  clip.skeleton = shaped_skeleton(builtin_body(), clip.betas);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

void write_clouds(const std::string& path, const std::vector<Tensor>& clouds) {
  std::vector<int64_t> counts;
  for (const Tensor& cloud : clouds) counts.push_back(cloud.size(0));
  Npz npz;
  npz.tensors["points"] = torch::cat(clouds);
  npz.tensors["counts"] = torch::tensor(counts);
  write_npz(path, npz);
}

double apart(const Clip& a, const Clip& b) { return (a.joints - b.joints).norm(2, {2}).mean().item<double>(); }

const Eigen::Vector3d kBeside(2.2, 0.6, 2.2);  // of the motion's middle, metres

TEST(RefineDepthVerb, AFolderOrAFileOfCloudsBringsTheMotionBack) {
  const TempFolder folder;
  const Clip truth = seen_walk(), input = jittered(truth, 1);
  const Rendered scene = rendered(truth, kBeside, 0.005);
  write_clip(folder / "in.npz", input);
  write_clouds(folder / "clouds.npz", scene.clouds);
  std::filesystem::create_directory(folder / "clouds");
  for (size_t t = 0; t < scene.clouds.size(); ++t)
    write_npy(folder / ("clouds/" + std::to_string(t) + ".npy"), scene.clouds[t] * 1000);
  const std::string line = "refine " + folder / "in.npz";
  const CommandResult file = run_command(line + " --depth " + folder / "clouds.npz" + " -o " + folder / "a.npz" +
                                         " -o " + folder / "a.html"),
                      many = run_command(line + " --depth " + folder / "clouds" + " --depth-scale 0.001 -o " +
                                         folder / "b.npz");
  ASSERT_EQ(file.exit_code, 0) << file.err;
  ASSERT_EQ(many.exit_code, 0) << many.err;
  EXPECT_NE(file.out.find("from the skin before"), std::string::npos) << file.out;
  const Clip a = read_clip(folder / "a.npz"), b = read_clip(folder / "b.npz");
  ASSERT_EQ(a.frames(), kSeen);
  EXPECT_LT(apart(a, truth), 0.5 * apart(input, truth));
  EXPECT_LT(apart(a, b), 1e-3);
  const Eigen::Vector3d& c = scene.camera;
  const std::string camera = std::to_string(c.x()) + "," + std::to_string(c.y()) + "," + std::to_string(c.z());
  const CommandResult both =
      run_command(line + " --depth " + folder / "clouds.npz" + " --camera " + camera + " -o " + folder / "c.npz");
  ASSERT_EQ(both.exit_code, 0) << both.err;
  EXPECT_LT(apart(read_clip(folder / "c.npz"), truth), 0.6 * apart(input, truth));
}

TEST(RefineDepthVerb, ABodyModelFromAFile) {
  const TempFolder folder;
  // A model file of SMPL's layout with the built-in body's skin; joints are told from vertices by the least regressor.
  const BodyModel& body = builtin_body();
  torch::manual_seed(1);
  const int64_t V = body.template_vertices.size(0);
  const Tensor skin = torch::cat({body.template_vertices, torch::ones({V, 1})}, 1).to(torch::kFloat64);
  Tensor joints = torch::cat({body.joint_template, body.joint_template.slice(0, 20, 22)}).to(torch::kFloat64);
  joints[22][0] += 0.08, joints[23][0] -= 0.08;
  Npz model;
  model.tensors["v_template"] = body.template_vertices;
  model.tensors["shapedirs"] = torch::randn({V, 3, 10}) * 1e-4;
  model.tensors["posedirs"] = body.template_vertices.matmul(torch::randn({3, 3 * 207})).view({V, 3, 207}) * 0.001;
  const Tensor normal = torch::inverse(skin.t().matmul(skin));
  model.tensors["J_regressor"] =
      torch::cat({joints, torch::ones({24, 1}, torch::kFloat64)}, 1).matmul(normal).matmul(skin.t());
  model.tensors["weights"] = torch::cat({body.skin_weights, torch::zeros({V, 2})}, 1);
  model.tensors["f"] = body.faces.to(torch::kInt32);
  std::vector<int64_t> parents(standard_parents().begin(), standard_parents().end());
  parents.insert(parents.end(), {20, 21});
  model.tensors["kintree_table"] = torch::stack({torch::tensor(parents), torch::arange(24)});
  write_npz(folder / "model.npz", model);

  const BodyModel read = read_smpl_model(folder / "model.npz");
  const Clip walk = seen_walk();
  Clip truth = walk;
  truth.skeleton = read.skeleton;
  truth.betas = Tensor();
  truth.rotations = torch::cat({walk.rotations, torch::zeros({kSeen, 2, 3})}, 1);
  truth.joints = joint_positions(truth.skeleton, truth.rotations, truth.trans);
  const Clip input = jittered(truth, 1);
  Rendered scene{truth, {}, {}};
  const Tensor skins = skin_points(truth, read);
  const Eigen::Vector3d middle(truth.joints[kSeen / 2][0][0].item<double>(), 1,
                               truth.joints[kSeen / 2][0][2].item<double>());
  for (int64_t t = 0; t < kSeen; ++t)
    scene.clouds.push_back(seen_points(skins[t], read, middle + kBeside, middle, 120, 0.005));
  write_clouds(folder / "clouds.npz", scene.clouds);
  Npz motion;  // as AMASS and SMPL's own files have it
  motion.tensors["poses"] = input.rotations.flatten(1);
  motion.tensors["trans"] = input.trans;
  motion.tensors["betas"] = torch::zeros({10});
  motion.tensors["mocap_framerate"] = torch::tensor(30.0);
  write_npz(folder / "in.npz", motion);

  const CommandResult r =
      run_command("refine " + folder / "in.npz" + " --up y --depth " + folder / "clouds.npz" + " --body " +
                  folder / "model.npz" + " -o " + folder / "out.npz -o " + folder / "out.html");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const Clip out = read_clip(folder / "out.npz");
  ASSERT_EQ(out.skeleton.size(), 24);
  EXPECT_LT(apart(out, truth), 0.5 * apart(input, truth)) << r.out;
}

TEST(RefineDepthVerb, RefusesWhatDoesNotFit) {
  const TempFolder folder;
  const Clip truth = slice(seen_walk(), 0, 6);
  const Rendered scene = rendered(truth, kBeside, 0);
  write_clip(folder / "in.npz", truth);
  std::filesystem::create_directory(folder / "out");
  const std::string line = "refine " + folder / "in.npz", out = " -o " + folder / "out/r.npz";
  const auto refused = [&](const std::string& more, const std::vector<std::string>& parts) {
    expect_refused(line + more + out, parts, folder / "out");
  };
  std::vector<Tensor> clouds = scene.clouds;
  write_clouds(folder / "good.npz", clouds);
  refused(" --depth " + folder / "none.npz", {"none.npz"});
  refused(" --depth " + folder / "out", {"no point clouds"});
  refused(" --depth " + folder / "good.npz" + " --keep 0", {"--keep"});
  refused(" --depth " + folder / "good.npz" + " --camera 1,2", {"--camera"});
  refused(" --depth " + folder / "good.npz" + " --depth-scale 0", {"--depth-scale"});
  refused(" --depth " + folder / "good.npz" + " --body " + folder / "in.npz", {"in.npz", "no SMPL"});
  refused(" --body " + folder / "in.npz", {"--depth"});
  refused(" --depth " + kRoom, {"walk_room.glb"});
  clouds.pop_back();
  write_clouds(folder / "few.npz", clouds);
  refused(" --depth " + folder / "few.npz", {"few.npz", "5 clouds", "6 frames"});
  clouds = scene.clouds;
  clouds[2] = clouds[2] * 1000;
  write_clouds(folder / "mm.npz", clouds);
  refused(" --depth " + folder / "mm.npz", {"mm.npz, frame 2", "other units"});
  clouds[2] = scene.clouds[2].clone();
  clouds[2][1][1] = NAN;
  write_clouds(folder / "nan.npz", clouds);
  refused(" --depth " + folder / "nan.npz", {"nan.npz, frame 2", "not finite"});
  std::filesystem::create_directory(folder / "gap");
  for (const int64_t t : {0, 1, 2, 3, 5, 6})
    write_npy(folder / ("gap/frame_" + std::to_string(t) + ".npy"), scene.clouds[0]);
  refused(" --depth " + folder / "gap", {"after frame_3 comes frame_5"});
}

}  // namespace
}  // namespace inhabit
