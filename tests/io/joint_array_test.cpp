// Protects the reading of joint positions under other names and shapes than ours, and that clouds of points stay
// clouds.
#include "inhabit/io/joint_array.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/motion/retarget.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

torch::Tensor standing(int64_t frames) {
  return joint_positions(builtin_body().skeleton, torch::zeros({frames, 22, 3}),
                         torch::tensor({0.F, 1.F, 0.F}).expand({frames, 3}));
}

TEST(JointArray, HasAnyUsualNameAndShape) {
  const torch::Tensor joints = standing(7);
  for (const char* name : {"joints", "keypoints", "positions", "poses_3d", "joint_positions", "joints3d", "pred_joints",
                           "jointPositions", "arr_0"})
    for (const torch::Tensor& as : {joints, joints.view({7, 66})}) {
      Npz npz;
      npz.tensors[name] = as;
      ASSERT_TRUE(holds_clip(npz)) << name << as.sizes();
      EXPECT_TRUE(torch::equal(clip_from_npz(npz, name).joints, joints)) << name << as.sizes();
    }
}

TEST(JointArray, HasNamesInAnyCaseAndVagueOnesWhereTheShapeSaysJoints) {
  const torch::Tensor joints = standing(7);
  for (const char* name : {"Joints", "KEYPOINTS", "xyz", "motion", "pred", "Predictions"}) {
    Npz npz;
    npz.tensors[name] = joints;
    ASSERT_TRUE(holds_clip(npz)) << name;
    EXPECT_TRUE(torch::equal(clip_from_npz(npz, name).joints, joints)) << name;
  }
  for (const char* name : {"xyz", "motion", "pred"}) {
    Npz features;  // 6D rotations of 22 joints and a root: as many as those of 45 joints
    features.tensors[name] = torch::rand({7, 135});
    EXPECT_FALSE(holds_clip(features)) << name;
  }
  Npz both;
  both.tensors["motion"] = standing(7) + 1;
  both.tensors["joints"] = joints;
  EXPECT_TRUE(torch::equal(clip_from_npz(both, "both").joints, joints)) << "joints go first";
}

TEST(JointArray, PositionsCalledPosesAreToldFromRotations) {
  torch::manual_seed(1);
  const torch::Tensor swing = 0.8 * torch::sin(torch::arange(40) * 0.2).view({40, 1, 1}) * torch::randn({1, 22, 3}),
                      path = torch::stack({torch::arange(40) * 0.03, torch::ones({40}), torch::zeros({40})}, 1),
                      joints = joint_positions(builtin_body().skeleton, swing, path);
  const torch::Tensor noisy = joints + 0.004 * torch::randn_like(joints);
  for (const torch::Tensor& as : {joints, joints.view({40, 66}), noisy, 100 * joints})
    for (const char* name : {"poses", "pose"}) {
      Npz npz;
      npz.tensors[name] = as;
      EXPECT_EQ(positions_called_poses(npz), name) << as.sizes();
      Notes notes;
      const Clip clip = clip_from_npz(npz, name, {}, &notes);
      EXPECT_FALSE(clip.rotations.defined());
      EXPECT_LT((clip.joints - joints).abs().max().item<double>(), 0.03);
      EXPECT_THAT(notes, testing::Contains(testing::HasSubstr("joint positions without rotations")));
    }
  Npz rotations;
  for (const torch::Tensor& as :
       {swing, swing.view({40, 66}), swing[9].expand({40, 22, 3}), torch::zeros({40, 22, 3})}) {
    rotations.tensors["poses"] = as.contiguous();
    EXPECT_EQ(positions_called_poses(rotations), "") << as.sizes();
  }
  Npz of_a_body;  // whatever its poses look like
  of_a_body.tensors["poses"] = joints;
  of_a_body.tensors["trans"] = path;
  EXPECT_EQ(positions_called_poses(of_a_body), "");
}

TEST(JointArray, SeveralMotionsLead) {
  Npz npz;
  npz.tensors["keypoints"] = torch::stack({standing(7), standing(7) + 1, standing(7) + 2});
  const std::vector<Clip> clips = clips_from_npz(npz, "three");
  ASSERT_EQ(clips.size(), 3U);
  EXPECT_TRUE(torch::equal(clips[2].joints, standing(7) + 2));
}

TEST(JointArray, IsNoCloudAndACloudIsNone) {
  for (const int64_t columns : {3, 6, 7, 9}) {
    Npz cloud;
    cloud.tensors["positions"] = torch::rand({500, columns});
    EXPECT_FALSE(holds_clip(cloud)) << columns;
    Npz nameless;
    nameless.tensors["arr_0"] = torch::rand({500, columns});
    EXPECT_FALSE(holds_clip(nameless)) << columns;
  }
  Npz clouds;  // of a depth camera
  clouds.tensors["positions"] = torch::rand({5, 4000, 3});
  EXPECT_FALSE(holds_clip(clouds));
}

TEST(JointArray, IsLeftAloneBesideAPose) {
  Npz npz;
  npz.tensors["poses"] = torch::zeros({5, 66});
  npz.tensors["trans"] = torch::zeros({5, 3});
  npz.tensors["keypoints"] = torch::rand({2, 5, 25, 3});
  EXPECT_TRUE(clips_from_npz(npz, "pose").front().rotations.defined());
}

TEST(JointArray, UnitsAreToldFromThePerson) {
  for (const auto& [scale, unit] : {std::pair(1000, "millimetres"), std::pair(100, "centimetres")}) {
    Npz npz;
    npz.tensors["keypoints"] = standing(7) * scale;
    Notes notes;
    const Clip clip = clip_from_npz(npz, "far.npz", {}, &notes);
    EXPECT_LT((clip.joints - standing(7)).abs().max().item<float>(), 1e-5) << unit;
    EXPECT_NEAR(clip.skeleton.offsets[4].norm().item<double>(),
                builtin_body().skeleton.offsets[4].norm().item<double>(), 1e-4);
    EXPECT_THAT(notes, testing::Contains(testing::HasSubstr(unit)));
  }
}

TEST(JointArray, Human36mOrderIsKnown) {
  // Which of the standard joints is where, in the order of the 17.
  const std::vector<int64_t> of = {0, 2, 5, 8, 1, 4, 7, 6, 9, 12, 15, 16, 18, 20, 17, 19, 21};
  const torch::Tensor joints = standing(7);
  Npz npz;
  npz.tensors["poses_3d"] = joints.index_select(1, torch::tensor(of)) * 1000;
  Notes notes;
  const Clip clip = clip_from_npz(npz, "lifted.npz", {}, &notes);
  EXPECT_EQ(clip.skeleton.size(), 17);
  EXPECT_THAT(notes, testing::Contains(testing::HasSubstr("Human3.6M's 17 joints")));
  const Clip standard = retarget(clip, "lifted.npz");
  for (const int64_t j : {4, 5, 7, 8, 18, 19, 20, 21})
    EXPECT_LT((standard.joints.select(1, j) - joints.select(1, j)).norm(2, {1}).max().item<double>(), 0.02) << j;
  torch::Tensor coco = npz.tensors["poses_3d"].clone();  // nose and eyes where pelvis and hip are
  coco.select(1, 1).copy_(coco.select(1, 0) + 20);
  coco.select(1, 4).copy_(coco.select(1, 0) - 20);
  npz.tensors["poses_3d"] = coco;
  EXPECT_THAT(refusal_of([&] { clip_from_npz(npz, "coco.npz"); }), testing::HasSubstr("Human3.6M's 17 in their order"));
}

TEST(JointArray, OfTooFewJointsIsSaid) {
  Npz npz;
  npz.tensors["poses_3d"] = torch::rand({9, 17, 3});
  EXPECT_NE(refusal_of([&] { clip_from_npz(npz, "h36m.npz"); }).find("of 17 joints"), std::string::npos);
}

}  // namespace
}  // namespace inhabit
