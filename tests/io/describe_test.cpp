// Protects what `inhabit info` says of a person's size, however their skeleton lies at rest.
#include "inhabit/io/describe.h"

#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/math/rotation.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

/// Somebody who stands for a second, on a skeleton whose rest pose is rotated by `at_rest` (axis and angle).
Clip somebody(const torch::Tensor& at_rest) {
  Clip clip;
  clip.rate = 30;
  clip.skeleton = builtin_body().skeleton;
  clip.skeleton.offsets = torch::matmul(clip.skeleton.offsets, axis_angle_to_matrix(at_rest).t());
  clip.rotations = torch::zeros({30, kStandardJoints, 3});
  clip.rotations.select(1, 0).copy_(-at_rest);
  clip.trans = torch::tensor({0.F, 1.F, 0.F}).expand({30, 3}).contiguous();
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

TEST(DescribeMotion, RestHeightIsThatOfAStandingPersonHoweverTheSkeletonLies) {
  const TempFolder folder;
  const auto height = [&](const std::string& name, const torch::Tensor& at_rest) {
    write_clip_npz(folder / name, somebody(at_rest));
    return describe_file(folder / name)["rest_height"].get<double>();
  };
  const double upright = height("upright.npz", torch::zeros({3}));
  EXPECT_GT(upright, 1.3);
  EXPECT_LT(upright, 1.9);
  EXPECT_NEAR(height("on_the_back.npz", torch::tensor({static_cast<float>(-M_PI / 2), 0.F, 0.F})), upright, 2e-3);
  EXPECT_NEAR(height("on_the_side.npz", torch::tensor({0.F, 0.F, static_cast<float>(M_PI / 2)})), upright, 2e-3);
  EXPECT_NEAR(height("turned.npz", torch::tensor({0.F, 1.F, 0.F})), upright, 2e-3);
}

TEST(DescribeMotion, RestHeightOfAFoldedSkeletonIsThatOfThePersonInItsFrames) {
  const TempFolder folder;
  Clip clip = somebody(torch::zeros({3}));
  write_clip_npz(folder / "upright.npz", clip);
  // Knees at the chin: the thighs rest forward, and the frames put them back. Arms are up, and no part of the height.
  const torch::Tensor fold = axis_angle_to_matrix(torch::tensor({static_cast<float>(-M_PI / 2), 0.F, 0.F}));
  for (const int64_t joint : {4, 5, 7, 8, 10, 11})
    clip.skeleton.offsets[joint] = fold.matmul(clip.skeleton.offsets[joint]);
  for (const int64_t hip : {1, 2})
    clip.rotations.select(1, hip).copy_(torch::tensor({static_cast<float>(M_PI / 2), 0.F, 0.F}));
  clip.rotations.select(1, 16).copy_(torch::tensor({0.F, 0.F, static_cast<float>(M_PI / 2)}));
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  write_clip_npz(folder / "folded.npz", clip);
  const auto height = [&](const char* name) { return describe_file(folder / name)["rest_height"].get<double>(); };
  EXPECT_NEAR(height("folded.npz"), height("upright.npz"), 2e-3);
}

}  // namespace
}  // namespace inhabit
