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
constexpr double kChapter = 12;  // seconds
constexpr int kChapterFrames = static_cast<int>(kChapter * kSynthRate);
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

void add_objects(Clip& clip, const Room& room, std::vector<int> used) {
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  const int64_t frames = clip.frames();
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
}

Clip clip_of(const Room& room, const BodyModel& body, const torch::Tensor& betas, const Performance& performance,
             const std::vector<int>& used) {
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
  add_objects(clip, room, used);
  return clip;
}

/// A person with a plan of what to do, and what it is performed with.
struct Life {
  torch::Tensor betas;
  std::shared_ptr<const Figure> figure;
  LifePlan plan;
  double from;           // second of the plan that is the clip's first
  std::mt19937_64 sway;  // of the small motions

  /// Frames [first, last) of the clip.
  Performance performed(int first, int last) const {
    std::mt19937_64 random = sway;
    return perform(*figure, plan, from + first / kSynthRate, last - first, kSynthRate, random);
  }
  /// All frames that are planned, to the end of what is going on when the clip ends or its next chapter begins: that
  /// cannot be drawn again then.
  int planned() const { return static_cast<int>((plan.steps.now() - from) * kSynthRate); }
};

/// Draws lives in one room until one is without a fault.
class LifeSampler {
 public:
  LifeSampler(const Room& room, const BodyModel& body, std::mt19937_64& random)
      : room_(room), body_(body), floor_(free_space(room)), random_(random) {}

  /// The first chapter of a clip of `frames`. @param seconds of the clip.
  Life first_chapter(double seconds, int frames) {
    std::optional<Life> best;
    double least = 1e9;
    for (int attempt = 0; attempt < kTries && least > 0; ++attempt) {
      const torch::Tensor betas = draw_betas(body_, random_);
      const auto figure = std::make_shared<const Figure>(make_figure(body_, betas));
      const double from = uniform(random_, 0.0, 3.0);
      LifePlan plan = plan_life(room_, floor_, *figure, from + std::min(seconds, kChapter), random_);
      Life life{betas, figure, std::move(plan), from, random_};
      const int last = frames > kChapterFrames ? life.planned() : frames;
      const Performance performance = perform(*figure, life.plan, from, last, kSynthRate, random_);  // moves it on
      if (const double found = faults(life, performance); found < least) least = found, best = std::move(life);
    }
    return *best;
  }

  /// A life with one chapter more than its first `done` frames. @param least its faults.
  Life next_chapter(const Life& before, int done, double& least) {
    std::optional<Life> next;
    least = 1e9;
    for (int attempt = 0; attempt < kNextTries && least > 0; ++attempt) {
      Life life = before;
      extend_life(life.plan, room_, floor_, *life.figure, life.from + (done + kChapterFrames) / kSynthRate, random_);
      if (const double found = faults(life, life.performed(done - kChapterFrames / 4, life.planned())); found < least)
        least = found, next = std::move(life);
    }
    return std::move(*next);
  }

 private:
  double faults(const Life& life, const Performance& performance) const {
    return std::max(0.0, beyond_limits(*life.figure, performance)) +
           10 * std::max(0.0, deepest_collision(room_, shaped_capsules(body_, life.betas), performance) - kDeepest);
  }

  const Room& room_;
  const BodyModel& body_;
  const FreeSpace floor_;
  std::mt19937_64& random_;
};

}  // namespace

Clip live(const Room& room, const BodyModel& body, std::mt19937_64& random, const LifeOptions& options) {
  if (!(options.seconds > 0) || options.seconds > 3600) throw Error("seconds", "a clip lasts between 0 and 3600 s");
  const torch::NoGradGuard no_gradient;
  const int frames = std::max(1, static_cast<int>(std::lround(options.seconds * kSynthRate)));
  LifeSampler lives(room, body, random);
  // A long life goes on chapter by chapter: the longer it is, the less likely is one without a fault at once. Where the
  // next cannot be without one (somebody stands too close to a shelf to walk away), the one before is drawn again.
  std::vector<Life> chapters{lives.first_chapter(options.seconds, frames)};
  for (int back = 0; static_cast<int>(chapters.size()) * kChapterFrames < frames;) {
    double least = 0;
    Life next = lives.next_chapter(chapters.back(), static_cast<int>(chapters.size()) * kChapterFrames, least);
    if (least == 0 || ++back > kTries) {
      chapters.push_back(std::move(next));
    } else {
      chapters.pop_back();
      if (chapters.empty()) chapters.push_back(lives.first_chapter(options.seconds, frames));
    }
  }
  const Life& life = chapters.back();
  return clip_of(room, body, life.betas, life.performed(0, frames), life.plan.used);
}

}  // namespace inhabit
