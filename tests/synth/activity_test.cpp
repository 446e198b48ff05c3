#include "inhabit/synth/activity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/synth/generate.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

constexpr int64_t kFrames = 90;

// A body at rest whose pelvis stands at `height` of its leg's length and moves by path(seconds).
Clip body_that(double height, const std::function<Eigen::Vector3d(double)>& path, double turns = 0) {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.skeleton.names.resize(kStandardJoints);
  clip.skeleton.parents.resize(kStandardJoints);
  clip.skeleton.offsets = clip.skeleton.offsets.narrow(0, 0, kStandardJoints).clone();
  clip.rotations = torch::zeros({kFrames, kStandardJoints, 3});
  clip.trans = torch::zeros({kFrames, 3});
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  const torch::Tensor rest = clip.joints[0];
  const double leg = ((rest[1] - rest[4]).norm() + (rest[4] - rest[7]).norm()).item<double>();
  clip.trans.select(1, 1).fill_(height * leg - rest[0][1].item<double>());
  for (int64_t t = 0; t < kFrames; ++t) {
    const double s = static_cast<double>(t) / clip.rate;
    const Eigen::Vector3d at = path(s);
    for (int64_t i = 0; i < 3; ++i) clip.trans[t][i] += at[i];
    clip.rotations[t][0][1] = turns * s;
  }
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

Activity in_the_middle(const Clip& clip) {
  return static_cast<Activity>(activities(clip)[kFrames / 2].item<int64_t>());
}

TEST(Activities, AreToldFromTheMotion) {
  const auto rests = [](double) { return Eigen::Vector3d(0, 0, 0); };
  const auto going = [](double speed) { return [speed](double s) { return Eigen::Vector3d(0, 0, speed * s); }; };
  EXPECT_EQ(in_the_middle(body_that(1, rests)), Activity::still);
  EXPECT_EQ(in_the_middle(body_that(1, going(1.2))), Activity::walk);
  EXPECT_EQ(in_the_middle(body_that(1, going(3))), Activity::run);
  EXPECT_EQ(in_the_middle(body_that(1, rests, 1)), Activity::turn);
  EXPECT_EQ(in_the_middle(body_that(0.6, rests)), Activity::sit);
  EXPECT_EQ(in_the_middle(body_that(1.3, [](double s) { return Eigen::Vector3d(0, -0.3 * s, 0); })),
            Activity::sit_down);
  EXPECT_EQ(in_the_middle(body_that(0.4, [](double s) { return Eigen::Vector3d(0, 0.3 * s, 0); })), Activity::stand_up);
  Clip waves = body_that(1, rests);
  for (int64_t t = 0; t < kFrames; ++t)
    waves.joints[t][21][1] += 0.2 * std::sin(2 * M_PI * static_cast<double>(t) / 30);
  EXPECT_EQ(in_the_middle(waves), Activity::gesture);
}

TEST(LowPassed, HalvesThePowerAtItsFrequency) {
  for (const double hz : {1.0, 3.0, 6.0}) {
    const Clip clip = body_that(1, [&](double s) { return Eigen::Vector3d(0.01 * std::sin(2 * M_PI * hz * s), 0, 0); });
    const auto power = [](const torch::Tensor& joints) {
      const torch::Tensor x = joints.slice(0, 15, 75).select(1, 0).select(1, 0).to(torch::kDouble);
      return (x - x.mean()).square().mean().item<double>();
    };
    EXPECT_NEAR(power(low_passed(clip, 3)) / power(clip.joints), std::pow(0.5, hz * hz / 9), 0.01) << hz;
  }
  const Clip clip = body_that(1, [](double) { return Eigen::Vector3d(0, 0, 0); });
  EXPECT_THROW(low_passed(clip, 0), Error);
  EXPECT_THROW(low_passed(clip, 15), Error);
}

// Bounds from what recordings have of it without their noise, some 7 m/s^3 standing still (docs/dataset.md).
TEST(DynamicsByActivity, GeneratedPeopleAreNeverFrozen) {
  const TempFolder folder;
  GenerateOptions options;
  options.clips = 16;
  options.clips_per_room = 1;
  options.seed = 3;
  const auto found = dynamics_by_activity(generate_rooms(folder / "d", options), "all", 6);
  const auto of = [&](Activity activity) { return found.at(static_cast<size_t>(activity)); };
  for (const Activity calm : {Activity::still, Activity::sit}) {
    const ActivityDynamics& one = of(calm);
    ASSERT_GT(one.raw.frames, 30) << kActivityNames.at(static_cast<size_t>(calm));
    EXPECT_GT(one.raw.jerk, 4);
    EXPECT_LT(one.raw.jerk, 14);
    EXPECT_LT(one.smooth.jerk, one.raw.jerk);
    EXPECT_LT(one.raw.speed, 0.05);
  }
  int64_t frames = 0;
  for (const ActivityDynamics& one : found) frames += one.raw.frames;
  EXPECT_GT(frames, 16 * 300) << "of 360 each, less those on which an activity changes";
  EXPECT_GT(of(Activity::walk).raw.jerk, 5 * of(Activity::still).raw.jerk);
}

}  // namespace
}  // namespace inhabit
