#include "inhabit/motion/retarget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "inhabit/body/kinematics.h"
#include "inhabit/body/proportions.h"
#include "inhabit/error.h"
#include "inhabit/io/asf_amc.h"
#include "inhabit/io/bvh.h"
#include "inhabit/io/expmap_text.h"
#include "inhabit/motion/pose_track.h"
#include "motion/fit_error.h"
#include "shared.h"

using namespace inhabit;

namespace {

// The built-in body's skeleton moving its joints smoothly within what people do: knees and elbows about their hinges.
Clip standard_motion(int64_t frames = 40) {
  Clip clip;
  clip.skeleton.names = standard_joint_names();
  clip.skeleton.parents = standard_parents();
  clip.skeleton.offsets = torch::empty({22, 3});
  const auto rest = builtin_rest_joints();
  for (int64_t j = 0; j < 22; ++j)
    for (int k = 0; k < 3; ++k)
      clip.skeleton.offsets[j][k] =
          j == 0 ? 0.0 : rest[j][k] - rest[static_cast<size_t>(standard_parents()[static_cast<size_t>(j)])][k];
  clip.rotations = torch::zeros({frames, 22, 3});
  clip.trans = torch::zeros({frames, 3});
  for (int64_t t = 0; t < frames; ++t) {
    const double s = std::sin(0.2 * static_cast<double>(t)), c = std::cos(0.13 * static_cast<double>(t));
    const auto set = [&](int joint, double x, double y, double z) {
      clip.rotations[t][joint] = torch::tensor({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    };
    clip.trans[t] = torch::tensor({static_cast<float>(0.01 * t), 0.95F, static_cast<float>(0.03 * t)});
    set(0, 0.1 * s, 0.02 * static_cast<double>(t), 0.05 * c);
    set(1, -0.4 + 0.4 * s, 0.1 * c, 0.1), set(2, -0.4 - 0.4 * s, -0.1 * c, -0.1);
    set(3, 0.05 * s, 0.05 * c, 0), set(6, 0.05 * c, 0, 0.05 * s), set(9, 0.05, 0.1 * s, 0);
    set(4, 0.5 + 0.4 * c, 0, 0), set(5, 0.5 - 0.4 * c, 0, 0);
    set(7, 0.1 * s, 0.05, 0), set(8, -0.1 * s, 0, 0.05), set(10, 0.2 * c, 0, 0);
    set(12, 0.2 * s, 0.2 * c, 0), set(15, 0, 0.1 * s, 0.1), set(13, 0, 0.1 * c, 0.1 * s), set(14, 0, 0.1 * s, 0.05);
    set(16, 0.2 * s, -0.3, -1.0 + 0.2 * c), set(17, 0.1, 0.3 * s, 1.1);
    set(18, 0, -0.8 - 0.4 * s, 0), set(19, 0, 0.9 + 0.4 * c, 0), set(20, 0.3 * s, 0, 0.2), set(21, 0, 0.2 * c, 0);
  }
  set_pose(clip, pose_track(clip));
  return clip;
}

double degrees_apart(const Clip& a, const Clip& b, int joint) {
  const PoseTrack x = pose_track(a), y = pose_track(b);
  const auto gx = global_rotations(x, a.skeleton.parents), gy = global_rotations(y, b.skeleton.parents);
  double worst = 0;
  for (int64_t t = 0; t < x.frames(); ++t) {
    const auto k = static_cast<size_t>(t * 22 + joint);
    worst = std::max(worst, gx[k].angularDistance(gy[k]));
  }
  return worst * 180 / M_PI;
}

std::vector<std::string> recordings(const std::string& folder, const std::string& extension) {
  std::vector<std::string> out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == extension) out.push_back(entry.path().string());
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

TEST(Retarget, StandardSkeletonsAreCutNotFitted) {
  Clip body = standard_motion();
  body.betas = torch::ones({10});
  body.contact = torch::ones({40, 22});
  Clip longer = body;  // with two joints of a hand
  longer.skeleton.names.insert(longer.skeleton.names.end(), {"left_index1", "left_index2"});
  longer.skeleton.parents.insert(longer.skeleton.parents.end(), {20, 22});
  longer.skeleton.offsets = torch::cat({body.skeleton.offsets, torch::full({2, 3}, 0.02)});
  longer.rotations = torch::cat({body.rotations, torch::zeros({40, 2, 3})}, 1);
  longer.contact = torch::ones({40, 24});
  set_pose(longer, pose_track(longer));
  const Clip found = retarget(longer, "a");
  EXPECT_TRUE(torch::equal(found.rotations, body.rotations));
  EXPECT_TRUE(torch::allclose(found.joints, body.joints, 0, 1e-6));
  EXPECT_EQ(found.contact.size(1), 22);
  EXPECT_TRUE(found.betas.defined());
  EXPECT_NO_THROW(validate(found, "a"));
}

TEST(Retarget, RotationsOfARenamedSkeletonComeBack) {
  // The same person under other names, so that everything is measured anew.
  const Clip body = standard_motion();
  Clip source = body;
  const std::vector<std::string> names = {
      "Hips",      "LeftUpLeg", "RightUpLeg",  "Spine",        "LeftLeg",  "RightLeg",     "Spine1",        "LeftFoot",
      "RightFoot", "Spine2",    "LeftToeBase", "RightToeBase", "Neck",     "LeftShoulder", "RightShoulder", "Head",
      "LeftArm",   "RightArm",  "LeftForeArm", "RightForeArm", "LeftHand", "RightHand"};
  source.skeleton.names = names;
  const Clip found = retarget(source, "a");
  EXPECT_NO_THROW(validate(found, "a"));
  EXPECT_LT(fit_error(found).max, 0.003);
  // Joints with a source joint of their own are where that is.
  for (const int j : {0, 1, 2, 4, 5, 7, 8, 10, 11, 12, 15, 16, 17, 18, 19, 20, 21})
    EXPECT_TRUE(torch::allclose(found.joints.select(1, j), body.joints.select(1, j), 0, 1e-6)) << j;
  for (const int j : {0, 1, 2, 4, 5, 7, 8, 9, 15, 16, 17, 18, 19, 20, 21})
    EXPECT_LT(degrees_apart(found, body, j), 4) << standard_joint_names()[static_cast<size_t>(j)];
}

TEST(Retarget, PositionsAloneGiveTheRotationsOfHingedLimbs) {
  const Clip body = standard_motion();
  Clip source = body;
  source.rotations = torch::Tensor();
  source.trans = torch::Tensor();
  const Clip found = retarget(source, "a");
  // The thorax is told from the shoulders, which the collars move.
  EXPECT_LT(fit_error(found).max, 0.015);
  for (const int j : {0, 1, 2, 4, 5, 16, 17, 18, 19})
    EXPECT_LT(degrees_apart(found, body, j), 15) << standard_joint_names()[static_cast<size_t>(j)];
}

TEST(Retarget, ASourceDrawnAlongOtherAxesGivesTheSameRotations) {
  // The rest pose is turned so that the person lies on the back with the head to +X; the motion itself is the same.
  const Clip body = standard_motion();
  Clip source = body;
  for (std::string& name : source.skeleton.names) name = "x_" + name;
  source.skeleton.names[0] = "Hips";
  for (size_t j = 1; j < source.skeleton.names.size(); ++j)
    source.skeleton.names[j] = "def." + standard_joint_names()[j];
  Eigen::Matrix3d axes;
  axes.col(0) = Eigen::Vector3d::UnitZ(), axes.col(1) = Eigen::Vector3d::UnitX(),
  axes.col(2) = Eigen::Vector3d::UnitY();
  const Eigen::Quaterniond rotation(axes);
  torch::Tensor matrix = torch::empty({3, 3});
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) matrix[r][c] = axes(r, c);
  source.skeleton.offsets = torch::matmul(body.skeleton.offsets, matrix.t());
  // G' = G axes^-1, so local L'_j = axes L_j axes^-1, and the root's L_0 axes^-1.
  PoseTrack track = pose_track(body);
  for (size_t k = 0; k < track.local.size(); ++k)
    track.local[k] = (k % 22 == 0 ? Eigen::Quaterniond::Identity() : rotation) * track.local[k] * rotation.conjugate();
  set_pose(source, track);
  ASSERT_TRUE(torch::allclose(source.joints, body.joints, 0, 1e-5));
  const Clip found = retarget(source, "a");
  for (const int j : {0, 9, 15, 16, 17, 18, 19, 20, 1, 4, 7})
    EXPECT_LT(degrees_apart(found, body, j), 4) << standard_joint_names()[static_cast<size_t>(j)];
}

TEST(Retarget, AnnotationsFollow) {
  Clip source = standard_motion(6);
  source.skeleton.names[0] = "Hips";
  source.rate = 60;
  source.action_names = {"walk"};
  source.action = torch::zeros({6}, torch::kLong);
  source.contact = torch::zeros({6, 22});
  source.contact.select(1, 10) = 1;
  source.hand_targets = torch::ones({6, 2, 4});
  source.object_names = {"chair"};
  source.object_pose = torch::ones({6, 1, 6});
  const Clip found = retarget(source, "a");
  EXPECT_NO_THROW(validate(found, "a"));
  EXPECT_EQ(found.rate, 60);
  EXPECT_TRUE(torch::equal(found.contact, source.contact));
  EXPECT_TRUE(torch::equal(found.object_pose, source.object_pose));
  EXPECT_TRUE(found.action.defined() && found.hand_targets.defined());
}

TEST(Retarget, OneFrameWillDoAndNoFrameWillNot) {
  Clip source = standard_motion(1);
  source.skeleton.names[0] = "Hips";
  EXPECT_LT(fit_error(retarget(source, "a")).max, 1e-3);
  source.joints = source.joints.slice(0, 0, 0);
  EXPECT_THROW(retarget(source, "a"), Error);
}

TEST(Retarget, RefusesBonesWithoutLengthAndForeignSkeletons) {
  Clip source = standard_motion(3);
  source.skeleton.names[0] = "Hips";
  source.skeleton.offsets[4] = 0;
  set_pose(source, pose_track(source));
  EXPECT_THAT([&] { retarget(source, "flat.bvh"); },
              testing::ThrowsMessage<Error>("flat.bvh: the bone to left_knee has no length"));
  source.skeleton.names[4] = "LeftWheel";
  EXPECT_THROW(retarget(source, "car.bvh"), Error);
}

TEST(Retarget, IfKnownLeavesForeignSkeletonsAsTheyAre) {
  const Clip person = standard_motion();
  EXPECT_TRUE(retarget_if_known(person, "person").joints.equal(retarget(person, "person").joints));
  Clip chain;
  chain.skeleton.names = {"a", "b", "c"};
  chain.skeleton.parents = {-1, 0, 1};
  chain.skeleton.offsets = torch::ones({3, 3});
  chain.joints = torch::rand({4, 3, 3});
  const Clip same = retarget_if_known(chain, "chain");
  EXPECT_EQ(same.skeleton.names, chain.skeleton.names);
  EXPECT_TRUE(same.joints.equal(chain.joints));
}

TEST(Retarget, EveryCmuClipIsMetWithinTwoCentimetres) {
  const std::string folder = shared_folder();
  if (folder.empty()) GTEST_SKIP() << "no recordings beside the project";
  double mean = 0;
  int64_t frames = 0;
  for (const std::string& path : recordings(folder + "/data/cmu", ".txt")) {
    const Clip clip = retarget(read_expmap_text(path).clip, path);
    const FitError error = fit_error(clip);
    EXPECT_LT(error.max, 0.02) << path;
    EXPECT_LT(error.mean, 0.005) << path;
    mean += error.mean * static_cast<double>(clip.frames());
    frames += clip.frames();
  }
  std::printf("mean over %lld frames: %.2f mm\n", static_cast<long long>(frames),
              1e3 * mean / static_cast<double>(frames));
  EXPECT_GT(frames, 40000);
}

TEST(Retarget, RecordingsBendKneesAndElbowsAsPeopleDo) {
  const std::string folder = shared_folder();
  if (folder.empty()) GTEST_SKIP() << "no recordings beside the project";
  std::vector<std::pair<std::string, Clip>> sources;
  for (const std::string& path : recordings(folder + "/data/asf_amc", ".amc"))
    sources.emplace_back(path, read_asf_amc(path).clip);
  sources.emplace_back("sample.bvh", read_bvh(folder + "/data/bvh/sample.bvh").clip);
  sources.emplace_back("walking", read_expmap_text(folder + "/data/cmu/train/walking/walking_1.txt").clip);
  for (const auto& [name, source] : sources) {
    SCOPED_TRACE(name);
    const Clip clip = retarget(source, name);
    EXPECT_LT(fit_error(clip).max, 0.02);
    EXPECT_LT(fit_error(clip).mean, 0.002);
    const torch::Tensor r = clip.rotations * (180 / M_PI);
    for (const int knee : {4, 5}) {  // about +x
      EXPECT_GT(r.select(1, knee).select(1, 0).min().item<double>(), -30);
      EXPECT_GT(r.select(1, knee).select(1, 0).max().item<double>(), 30);
    }
    // The left elbow bends about -y, the right about +y, on the whole.
    EXPECT_LT(r.select(1, 18).select(1, 1).mean().item<double>(), 0);
    EXPECT_GT(r.select(1, 19).select(1, 1).mean().item<double>(), 0);
    // Nothing flips from one frame to the next, but where the recording does.
    const auto jump = [](const Clip& c) {
      const PoseTrack track = pose_track(c);
      double worst = 0;
      for (int64_t t = 1; t < track.frames(); ++t)
        for (int k = 0; k < track.joints; ++k)
          worst = std::max(worst, track.at(t, k).angularDistance(track.at(t - 1, k)));
      return worst * 180 / M_PI;
    };
    EXPECT_LT(jump(clip), jump(source) + 20);
  }
}
