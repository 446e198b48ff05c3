#include "inhabit/io/smpl_model.h"

#include <gtest/gtest.h>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/clip_npz.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

/// A model file of SMPL's layout: four vertices around each joint of a tree of `joints`.
Npz generated_model(int64_t joints, int64_t betas) {
  torch::manual_seed(joints);
  Npz npz;
  const int64_t V = 4 * joints;
  std::vector<int64_t> parents(static_cast<size_t>(joints), 0);
  for (int64_t j = 0; j < joints; ++j)
    parents[static_cast<size_t>(j)] = j < 22 ? standard_parents()[static_cast<size_t>(j)] : 20;
  parents[0] = 4294967295;
  npz.tensors["v_template"] = torch::rand({V, 3}, torch::kFloat64) * 2 - 1;
  npz.tensors["shapedirs"] = torch::randn({V, 3, betas}, torch::kFloat64) * 0.01;
  npz.tensors["posedirs"] = torch::randn({V, 3, 9 * (joints - 1)}, torch::kFloat64) * 0.001;
  npz.tensors["J_regressor"] = torch::eye(joints, torch::kFloat64).repeat_interleave(4, 1) / 4;
  npz.tensors["weights"] = torch::eye(joints, torch::kFloat64).repeat_interleave(4, 0);
  npz.tensors["kintree_table"] = torch::stack({torch::tensor(parents, torch::kInt64), torch::arange(joints)});
  npz.tensors["f"] = torch::arange(V - V % 3).view({-1, 3}).to(torch::kInt32);
  return npz;
}

std::string model_error(const std::function<void(Npz&)>& change) {
  Npz npz = generated_model(24, 10);
  change(npz);
  return refusal_of([&] { return smpl_model_from_npz(npz, "model"); });
}

TEST(SmplModel, AllThreeOfTheFamilyLoad) {
  for (const auto& [joints, betas, kept, name] :
       {std::tuple(24, 10, 10, "smpl"), std::tuple(52, 16, 16, "smplh"), std::tuple(55, 400, 300, "smplx")}) {
    const TempFolder folder;
    const Npz npz = generated_model(joints, betas);
    write_npz(folder / "model.npz", npz);
    const BodyModel body = read_smpl_model(folder / "model.npz");
    EXPECT_EQ(body.name, name);
    EXPECT_EQ(body.joints(), joints);
    EXPECT_EQ(body.betas(), kept);
    EXPECT_EQ(body.skeleton.names.size(), static_cast<size_t>(joints));
    EXPECT_EQ(body.anchors.size(0), 64);
    const torch::Tensor joint5 = npz.tensors.at("v_template").slice(0, 20, 24).mean(0).to(torch::kFloat32);
    EXPECT_TRUE(torch::allclose(body.joint_template[5], joint5, 1e-5, 1e-6));
    EXPECT_TRUE(torch::allclose(body.skeleton.rest_joints(), body.joint_template, 1e-5, 1e-5));
    const torch::Tensor shape = torch::randn({5});
    const torch::Tensor shaped = body.template_vertices + body.shape_dirs.narrow(2, 0, 5).matmul(shape);
    EXPECT_TRUE(
        torch::allclose(shaped_skeleton(body, shape).rest_joints()[3], shaped.slice(0, 12, 16).mean(0), 1e-4, 1e-5));
    const torch::Tensor still = torch::eye(3).repeat({joints, 1, 1});
    EXPECT_TRUE(torch::allclose(skin(body, shape, still, torch::zeros({3})), shaped, 1e-4, 1e-5));
  }
}

TEST(SmplModel, GivesAMotionFileItsSkeleton) {
  const BodyModel body = smpl_model_from_npz(generated_model(52, 16), "model");
  Npz motion;
  motion.tensors["poses"] = torch::randn({3, 165}) * 0.2;
  motion.tensors["trans"] = torch::randn({3, 3});
  motion.tensors["betas"] = torch::randn({10});
  motion.tensors["mocap_framerate"] = torch::tensor(60);
  ClipReadOptions options;
  options.body = &body;
  options.up = UpAxis::y;
  const Clip clip = clip_from_npz(motion, "motion", options);
  EXPECT_EQ(clip.skeleton.size(), 52);
  EXPECT_TRUE(torch::equal(clip.betas, motion.tensors["betas"]));
  EXPECT_TRUE(torch::allclose(clip.skeleton.offsets, shaped_skeleton(body, clip.betas).offsets));
  const torch::Tensor pose = motion.tensors["poses"].view({3, 55, 3});  // jaw and eyes have no place in SMPL-H
  EXPECT_TRUE(torch::equal(clip.rotations, torch::cat({pose.narrow(1, 0, 22), pose.narrow(1, 25, 30)}, 1)));
}

TEST(SmplModel, BadModelsAreNamedWithTheirFault) {
  auto expect = [](const std::string& message, const char* part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(model_error([](Npz& n) {
           n.tensors.erase("J_regressor");
           n.skipped["J_regressor"] = "a pickled Python object";
         }),
         "pickled");
  expect(model_error([](Npz& n) { n.tensors.erase("weights"); }), "no array weights");
  expect(model_error([](Npz& n) { n.tensors["weights"] *= 2; }), "sum to 1");
  expect(model_error([](Npz& n) { n.tensors["f"][0][0] = 1000; }), "face");
  expect(model_error([](Npz& n) { n.tensors["kintree_table"][0][5] = 9; }), "tree");
  expect(model_error([](Npz& n) { n.tensors["posedirs"] = torch::zeros({96, 3, 5}); }), "posedirs");
  expect(model_error([](Npz& n) { n.tensors["v_template"][0][0] = NAN; }), "not finite");
  EXPECT_THROW(read_smpl_model("model.pkl"), Error);
}

}  // namespace
}  // namespace inhabit
