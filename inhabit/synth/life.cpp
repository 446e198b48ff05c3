#include "inhabit/synth/life.h"

#include <algorithm>
#include <optional>

#include "inhabit/body/capsules.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/math/random.h"
#include "inhabit/synth/collide.h"
#include "inhabit/synth/person.h"

namespace inhabit {
namespace {

constexpr double kDeepest = 0.008;  // metres of a capsule in a box

/// Radians by which a performance leaves the joint limits, at most.
double beyond_limits(const Figure& figure, const Performance& performance) {
  double worst = 0;
  for (const Posed& pose : performance.pose)
    for (size_t j = 1; j < kStandardJoints; ++j)
      worst = std::max(worst, figure.limits.beyond(j, axis_angle_of(pose.local[j])).cwiseAbs().maxCoeff());
  return worst;
}

void add_objects(Clip& clip, const Room& room, std::vector<int> used) {
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  const int64_t frames = clip.frames();
  clip.object_pose = torch::zeros({frames, static_cast<int64_t>(used.size()), 6});
  for (size_t o = 0; o < used.size(); ++o) {
    const Eigen::Isometry3d& pose = room.furniture[used[o]].pose;
    const Eigen::Vector3d rotation = axis_angle_of(Eigen::Quaterniond(pose.linear()));
    clip.object_names.push_back(room.object_name(used[o]));
    torch::Tensor row = torch::empty({6});
    for (int i = 0; i < 3; ++i) {
      row[i] = pose.translation()[i];
      row[3 + i] = rotation[i];
    }
    clip.object_pose.select(1, static_cast<int64_t>(o)).copy_(row.expand({frames, 6}));
  }
}

}  // namespace

torch::Tensor draw_betas(const BodyModel& body, std::mt19937_64& random) {
  const int64_t count = std::min<int64_t>(body.joint_dirs.size(2), 10);
  torch::Tensor betas = torch::zeros({count});
  auto b = betas.accessor<float, 1>();
  for (int64_t i = 0; i < count; ++i) b[i] = static_cast<float>(std::clamp(normal(random, 0, 0.85), -2.0, 2.0));
  return betas;
}

Performance Life::performed(int first, int last) const {
  std::mt19937_64 random = sway;
  return perform(*figure, plan, from + first / kSynthRate, last - first, kSynthRate, random);
}

int Life::planned() const { return static_cast<int>((plan.steps.now() - from) * kSynthRate); }

double faults_of(const Room& room, const BodyModel& body, const Life& life, const Performance& performance) {
  return std::max(0.0, beyond_limits(*life.figure, performance)) +
         10 * std::max(0.0, deepest_collision(room, shaped_capsules(body, life.betas), performance) - kDeepest);
}

Life draw_faultless(int tries, const std::function<Life()>& draw, const std::function<double(const Life&)>& faults,
                    double* least) {
  std::optional<Life> best;
  double fewest = 1e9;
  for (int attempt = 0; attempt < tries && fewest > 0; ++attempt) {
    Life life = draw();
    if (const double found = faults(life); found < fewest) fewest = found, best = std::move(life);
  }
  if (least != nullptr) *least = fewest;
  return std::move(*best);
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
      const Eigen::Vector3d rotation = axis_angle_of(pose.local[j]);
      for (int i = 0; i < 3; ++i) {
        joints[t][j][i] = static_cast<float>(pose.position[j][i]);
        rotations[t][j][i] = static_cast<float>(rotation[i]);
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

}  // namespace inhabit
