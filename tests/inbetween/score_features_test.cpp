// Protects the scores of anybody's motion that `eval inbetween` has too: the same number under the same name.
#include "inhabit/inbetween/score_features.h"

#include <gmock/gmock.h>

#include "inbetween/windows_of.h"
#include "inhabit/scene/shapes.h"
#include "refusal_of.h"

namespace inhabit::inbetween {
namespace {

using testing::HasSubstr;

MotionAutoencoder untrained_features() {
  torch::manual_seed(1);
  MotionAutoencoder features;
  features->deviation.fill_(1e-3);
  return features;
}

std::vector<ScoredClip> clips_of_windows(const std::vector<Window>& windows, double faster = 1) {
  std::vector<ScoredClip> out;
  for (const Window& window : windows) {
    Clip clip = window.truth;
    const torch::Tensor along = torch::linspace(0, faster - 1, clip.frames()).view({-1, 1});
    clip.trans = clip.trans + along * torch::tensor({1.F, 0.F, 1.F});
    clip.joints = clip.joints + along.unsqueeze(1) * torch::tensor({1.F, 0.F, 1.F});
    out.push_back({window.name, clip, clip.rate});
  }
  return out;
}

TEST(ScoreFeatures, AreTheNumbersOfEval) {
  std::vector<Window> windows = walking_windows(24);
  MeshBuilder post;
  post.box({0, 1, 0.5}, {0.2, 1, 0.2});
  const auto scene = std::make_shared<Scene>();
  scene->meshes.push_back(post.mesh("post_0", {1, 1, 1}));
  for (Window& window : windows) window.scene = scene;
  const MotionAutoencoder features = untrained_features();
  const std::vector<ScoredClip> real = clips_of_windows(windows), faster = clips_of_windows(windows, 2.5);
  const Method method = {"faster", [&](const FillTask& task, uint64_t) {
                           for (const ScoredClip& of : faster)
                             if (of.name == task.window.name) return of.clip;
                           throw std::runtime_error("no such window");
                         }};
  const Table table = evaluate(windows, {method}, features, {});
  const Scores& row = table.rows.back();
  ASSERT_EQ(row.method, "faster");
  const torch::NoGradGuard no_gradients;
  // As they stand: the windows of a data set are over the floor y = 0 already. One by one, as eval encodes them: many
  // at once are rounded otherwise on some processors.
  const auto encoded = [&](const std::vector<ScoredClip>& clips) {
    std::vector<torch::Tensor> rows;
    for (const ScoredClip& of : clips) rows.push_back(motion_features(features, of.clip.joints.unsqueeze(0)));
    return torch::cat(rows);
  };
  const FidScore fid = score_fid(encoded(faster), encoded(real));
  EXPECT_GT(fid.fid, 1e-3);
  EXPECT_NEAR(fid.fid, row.fid.mean, 1e-6 * row.fid.mean);
  EXPECT_EQ(fid.dimensions, table.dimensions);
  EXPECT_NEAR(score_skating(faster).foot_skating, row.skating.mean, 1e-9);
  EXPECT_GT(row.skating.mean, 0);
  const JerkScore jerk = score_jerk(faster);
  EXPECT_NEAR(jerk.jerk, row.jerk.mean, 1e-6 * row.jerk.mean);
  EXPECT_NEAR(jerk.acceleration, row.acceleration.mean, 1e-6 * row.acceleration.mean);
  std::vector<int64_t> told;
  const PenetrationScore in = score_penetration(faster, *scene, [&](int64_t done, int64_t all) {
    told.push_back(done);
    EXPECT_EQ(all, static_cast<int64_t>(faster.size()));
  });
  EXPECT_EQ(told.size(), faster.size() + 1);
  EXPECT_EQ(told.back(), static_cast<int64_t>(faster.size()));
  EXPECT_GT(in.frame_ratio, 0);
  EXPECT_GT(in.penetration_max, 0.02);
  EXPECT_NEAR(in.frame_ratio, row.frame_ratio.mean, 0.02);  // eval finds the shape of the truth's bones, too
  EXPECT_NEAR(in.penetration_max * 1000, row.penetration.mean, 0.05 * row.penetration.mean);
}

TEST(ScoreFeatures, MotionIsAtNoDistanceFromItselfAndMoreVariedMotionIsMoreDiverse) {
  const MotionAutoencoder features = untrained_features();
  const torch::NoGradGuard no_gradients;
  const std::vector<ScoredClip> walks = clips_of_windows(walking_windows(12));
  const torch::Tensor all = features_of(walks, features);
  EXPECT_EQ(all.sizes(), torch::IntArrayRef({12, kMotionFeatures}));
  EXPECT_NEAR(score_fid(all, all).fid, 0, 1e-6);
  EXPECT_GT(score_diversity(all), 2 * score_diversity(all.slice(0, 0, 2) * 0.1));
  const torch::Tensor two = torch::tensor({{0.F, 0.F}, {3.F, 4.F}});
  EXPECT_DOUBLE_EQ(score_diversity(two), 5);
  EXPECT_THAT(refusal_of([&] { score_diversity(all.slice(0, 0, 1)); }), HasSubstr("two windows"));
  EXPECT_THAT(refusal_of([&] { score_fid(all, all.slice(0, 0, 1)); }), HasSubstr("two windows"));
  std::vector<ScoredClip> shorter = {walks[0]};
  shorter[0].clip = slice(shorter[0].clip, 0, 100);
  EXPECT_THAT(refusal_of([&] { features_of(shorter, features); }), HasSubstr("walk 0: has no window"));
}

TEST(ScoredClip, WhatIsTooShortIsSaidInItsOwnFrames) {
  Clip clip = slice(walking_windows(1)[0].truth, 0, 60);
  clip.rate = 60;
  EXPECT_THAT(refusal_of([&] { scored_clip(clip, 30, kFeatureFrames, "a.bvh"); }),
              HasSubstr("a.bvh: has 60 frames at 60 a second, 1.00 s; 4.03 s are needed"));
  const ScoredClip of = scored_clip(clip, 30, 10, "a.bvh");
  EXPECT_EQ(of.clip.rate, 30);
  EXPECT_EQ(of.file_rate, 60);
}

}  // namespace
}  // namespace inhabit::inbetween
