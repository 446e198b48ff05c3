#include "inhabit/synth/person.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "inhabit/body/capsules.h"
#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/collide.h"
#include "inhabit/synth/perform.h"

namespace inhabit {
namespace {

constexpr int kTries = 48, kNextTries = 10;
constexpr double kChapter = 12;     // seconds
constexpr double kDeepest = 0.008;  // metres of a capsule in a box

/// Radians by which a performance leaves the joint limits, at most.
double beyond_limits(const Figure& figure, const Performance& performance) {
  double worst = 0;
  for (const Posed& pose : performance.pose)
    for (size_t j = 1; j < kStandardJoints; ++j)
      worst = std::max(worst, figure.limits.beyond(j, axis_angle_of(pose.local[j])).cwiseAbs().maxCoeff());
  return worst;
}

torch::Tensor draw_betas(const BodyModel& body, std::mt19937_64& random) {
  const int64_t count = std::min<int64_t>(body.joint_dirs.size(2), 10);
  torch::Tensor betas = torch::zeros({count});
  auto b = betas.accessor<float, 1>();
  for (int64_t i = 0; i < count; ++i) b[i] = static_cast<float>(std::clamp(normal(random, 0, 0.85), -2.0, 2.0));
  return betas;
}

Clip clip_of(const Room& room, const BodyModel& body, const torch::Tensor& betas, const Performance& performance,
             std::vector<int> used) {
  const auto frames = static_cast<int64_t>(performance.pose.size());
  Clip clip;
  clip.skeleton = shaped_skeleton(body, betas);
  if (clip.skeleton.size() > kStandardJoints) {
    clip.skeleton.names.resize(kStandardJoints);
    clip.skeleton.parents.resize(kStandardJoints);
    clip.skeleton.offsets = clip.skeleton.offsets.narrow(0, 0, kStandardJoints).clone();
  }
  clip.rate = kSynthRate;
  clip.betas = betas;
  clip.action_names = action_names();
  clip.joints = torch::empty({frames, kStandardJoints, 3});
  clip.rotations = torch::empty({frames, kStandardJoints, 3});
  clip.trans = torch::empty({frames, 3});
  clip.action = torch::empty({frames}, torch::kInt64);
  clip.contact = torch::zeros({frames, kStandardJoints});
  clip.hand_targets = torch::zeros({frames, 2, 4});
  auto joints = clip.joints.accessor<float, 3>(), rotations = clip.rotations.accessor<float, 3>();
  auto trans = clip.trans.accessor<float, 2>(), contact = clip.contact.accessor<float, 2>();
  auto action = clip.action.accessor<int64_t, 1>();
  auto targets = clip.hand_targets.accessor<float, 3>();
  const auto rest = clip.skeleton.offsets[0].to(torch::kCPU, torch::kFloat).contiguous();
  for (int64_t t = 0; t < frames; ++t) {
    const Posed& pose = performance.pose[t];
    for (int j = 0; j < kStandardJoints; ++j) {
      const Eigen::Vector3d turn = axis_angle_of(pose.local[j]);
      for (int i = 0; i < 3; ++i) {
        joints[t][j][i] = static_cast<float>(pose.position[j][i]);
        rotations[t][j][i] = static_cast<float>(turn[i]);
      }
      contact[t][j] = performance.contact[t][j] ? 1.0F : 0.0F;
    }
    for (int i = 0; i < 3; ++i) trans[t][i] = static_cast<float>(pose.position[0][i]) - rest.data_ptr<float>()[i];
    action[t] = static_cast<int64_t>(performance.action[t]);
    for (int side = 0; side < 2; ++side)
      for (int i = 0; i < 4; ++i) targets[t][side][i] = static_cast<float>(performance.hand_target[t][side][i]);
  }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  clip.object_pose = torch::zeros({frames, static_cast<int64_t>(used.size()), 6});
  for (size_t o = 0; o < used.size(); ++o) {
    const Eigen::Isometry3d& pose = room.furniture[used[o]].pose;
    const Eigen::Vector3d turn = axis_angle_of(Eigen::Quaterniond(pose.linear()));
    clip.object_names.push_back(room.object_name(used[o]));
    torch::Tensor row = torch::empty({6});
    for (int i = 0; i < 3; ++i) {
      row[i] = pose.translation()[i];
      row[3 + i] = turn[i];
    }
    clip.object_pose.select(1, static_cast<int64_t>(o)).copy_(row.expand({frames, 6}));
  }
  return clip;
}

}  // namespace

Clip live(const Room& room, const BodyModel& body, std::mt19937_64& random, const LifeOptions& options) {
  if (!(options.seconds > 0) || options.seconds > 3600) throw Error("seconds", "a clip lasts between 0 and 3600 s");
  const torch::NoGradGuard no_gradient;
  const FreeSpace floor = free_space(room);
  const int frames = std::max(1, static_cast<int>(std::lround(options.seconds * kSynthRate)));
  constexpr int chapter = static_cast<int>(kChapter * kSynthRate);
  struct Life {
    torch::Tensor betas;
    std::shared_ptr<const Figure> figure;
    LifePlan plan;
    double from;           // second of the plan that is the clip's first
    std::mt19937_64 sway;  // what the plan is performed with
  };
  const auto performed = [](const Life& life, int first, int last) {
    std::mt19937_64 sway = life.sway;
    return perform(*life.figure, life.plan, life.from + first / kSynthRate, last - first, kSynthRate, sway);
  };
  const auto wrong = [&](const Life& life, const Performance& performance) {
    return std::max(0.0, beyond_limits(*life.figure, performance)) +
           10 * std::max(0.0, deepest_collision(room, shaped_capsules(body, life.betas), performance) - kDeepest);
  };
  // All that is planned, to the end of what is going on when the clip ends or its next chapter begins: that cannot be
  // drawn again then.
  const auto planned = [&](const Life& life) {
    return static_cast<int>((life.plan.steps.now() - life.from) * kSynthRate);
  };
  const auto first_chapter = [&] {
    std::optional<Life> best;
    double least = 1e9;
    for (int attempt = 0; attempt < kTries && least > 0; ++attempt) {
      const torch::Tensor betas = draw_betas(body, random);
      const auto figure = std::make_shared<const Figure>(make_figure(body, betas));
      const double from = uniform(random, 0.0, 3.0);
      LifePlan plan = plan_life(room, floor, *figure, from + std::min(options.seconds, kChapter), random);
      Life life{betas, figure, std::move(plan), from, random};
      const int last = frames > chapter ? planned(life) : frames;
      const Performance performance = perform(*figure, life.plan, from, last, kSynthRate, random);  // moves `random` on
      if (const double found = wrong(life, performance); found < least) least = found, best = std::move(life);
    }
    return *best;
  };
  // A long life goes on chapter by chapter: the longer it is, the less likely is one without a fault at once. Where the
  // next cannot be without one (somebody stands too close to a shelf to walk away), the one before is drawn again.
  std::vector<Life> chapters{first_chapter()};
  for (int back = 0; static_cast<int>(chapters.size()) * chapter < frames;) {
    const int done = static_cast<int>(chapters.size()) * chapter;
    std::optional<Life> next;
    double least = 1e9;
    for (int attempt = 0; attempt < kNextTries && least > 0; ++attempt) {
      Life life = chapters.back();
      extend_life(life.plan, room, floor, *life.figure, life.from + (done + chapter) / kSynthRate, random);
      if (const double found = wrong(life, performed(life, done - chapter / 4, planned(life))); found < least)
        least = found, next = std::move(life);
    }
    if (least == 0 || ++back > kTries) {
      chapters.push_back(std::move(*next));
    } else {
      chapters.pop_back();
      if (chapters.empty()) chapters.push_back(first_chapter());
    }
  }
  const Life& life = chapters.back();
  return clip_of(room, body, life.betas, performed(life, 0, frames), life.plan.used);
}

}  // namespace inhabit
