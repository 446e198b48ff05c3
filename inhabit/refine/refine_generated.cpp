#include "inhabit/refine/refine_generated.h"

#include <algorithm>

#include "inhabit/body/skeleton.h"
#include "inhabit/error.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/refine/weights.h"

namespace inhabit::refine {
namespace {

void check(const Clip& motion, const KeyPoses& keys) {
  const auto require = [](bool good, const char* what) {
    if (!good) throw Error("refine", what);
  };
  require(motion.skeleton.size() == kStandardJoints && motion.rotations.defined() && motion.trans.defined(),
          "needs rotations on the standard skeleton");
  require(keys.exact.size() == keys.frames.size(), "exact: not one number a key");
  require(keys.frames.empty() || keys.poses.frames() == static_cast<int64_t>(keys.frames.size()), "not one pose a key");
  for (const int64_t frame : keys.frames) require(frame >= 0 && frame < motion.frames(), "a key is of no frame");
  for (const JointTarget& target : keys.targets) {
    require(target.joint >= 0 && target.joint < kStandardJoints, "a target is of no joint");
    require(target.frame >= 0 && target.frame < motion.frames(), "a target is of no frame");
  }
}

/// Nearness to the motion and smoothness; hard keys in place.
Problem base(const Clip& motion, const KeyPoses& keys, const GeneratedOptions& options) {
  Problem problem;
  problem.bones = bones_of(motion.skeleton);
  problem.rate = motion.rate;
  problem.start = problem.initial = trajectory_of(motion);
  problem.points = joint_points(kStandardJoints);
  const size_t frames = problem.start.size();
  const double per_frame = 30 / motion.rate;  // sums over frames stand for integrals over time
  problem.stay_near.rotations.assign(frames * kStandardJoints, per_frame * weight_of(options.rotation));
  problem.stay_near.root.assign(frames, per_frame * weight_of(options.root));
  std::vector<double> root_alone(kStandardJoints, 0);  // other joints' places would tie all rotations together
  root_alone[0] = 1;
  if (options.smooth) {
    problem.smoothness.push_back({3, per_frame * weight_of(kPlaceJerk), 0, {}, false, root_alone});
    problem.smoothness.push_back({3, 0, per_frame * weight_of(kRotationJerk), {}, false, {}});
  } else {
    problem.smoothness.push_back({2, per_frame * weight_of(options.root_curve), 0, {}, true, root_alone});
    problem.smoothness.push_back({2, 0, per_frame * weight_of(options.rotation_curve), {}, true, {}});
  }
  problem.fixed.assign(frames, 0);
  if (keys.frames.empty()) return problem;
  const Trajectory poses = trajectory_of(keys.poses);
  for (size_t k = 0; k < poses.size(); ++k) {
    if (keys.exact[k] == 0) continue;
    const auto t = static_cast<size_t>(keys.frames[k]);
    problem.fixed[t] = 1;
    problem.initial[t] = poses[k];
  }
  return problem;
}

/// Whole keys that are not exact are what is stayed near to in their frames.
void add_noisy_keys(const KeyPoses& keys, double noise, Problem& problem) {
  const Trajectory poses = trajectory_of(keys.poses);
  StayNear& near = problem.stay_near;
  near.to = problem.start;
  for (size_t k = 0; k < poses.size(); ++k) {
    if (keys.exact[k] != 0) continue;
    const auto t = static_cast<size_t>(keys.frames[k]);
    near.to[t] = poses[k];
    near.root[t] = weight_of(noise * 0.01);
    std::fill_n(near.rotations.begin() + static_cast<std::ptrdiff_t>(t * kStandardJoints), kStandardJoints,
                weight_of(noise * kDegree));
  }
}

void add_targets(const std::vector<JointTarget>& targets, Problem& problem) {
  for (const JointTarget& target : targets) {
    int point = target.joint;
    if (!target.offset.isZero()) {
      point = static_cast<int>(problem.points.size());
      problem.points.push_back({{target.joint, 1, target.offset}});
    }
    problem.places.push_back({target.frame, point, target.place, target.sigma.cwiseAbs2().cwiseInverse(), {}});
  }
}

/// `motion` with the exact keys' frames.
Clip with_exact(const Clip& motion, const KeyPoses& keys) {
  Clip out = motion;
  out.rotations = motion.rotations.clone();
  out.trans = motion.trans.clone();
  out.joints = motion.joints.clone();
  for (size_t k = 0; k < keys.frames.size(); ++k) {
    if (keys.exact[k] == 0) continue;
    const auto row = static_cast<int64_t>(k);
    out.rotations[keys.frames[k]] = keys.poses.rotations[row];
    out.trans[keys.frames[k]] = keys.poses.trans[row];
    out.joints[keys.frames[k]] = keys.poses.joints[row];
  }
  return out;
}

}  // namespace

std::vector<JointTarget> joint_targets(const Clip& poses, int64_t pose, int64_t frame,
                                       const std::vector<int64_t>& joints) {
  std::vector<JointTarget> out;
  for (const int64_t joint : joints) {
    const torch::Tensor place = poses.joints[pose][joint].to(torch::kFloat64).contiguous();
    JointTarget target;
    target.frame = frame;
    target.joint = static_cast<int>(joint);
    target.place = Eigen::Map<const Eigen::Vector3d>(place.data_ptr<double>());
    out.push_back(target);
  }
  return out;
}

Clip refine_generated(const Clip& motion, const KeyPoses& keys, const GeneratedOptions& options) {
  check(motion, keys);
  Problem problem = base(motion, keys, options);
  const bool noisy = std::count(keys.exact.begin(), keys.exact.end(), 0) > 0;
  if (noisy) add_noisy_keys(keys, options.noise, problem);
  problem.initial = solve(problem, {3, 1e-3}).trajectory;
  if (!keys.targets.empty()) {
    // The pelvis would carry the legs along: its orientation stays.
    add_targets(keys.targets, problem);
    problem.rotates.assign(kStandardJoints, 1);
    problem.rotates[0] = 0;
    problem.initial = solve(problem, {12, 1e-3}).trajectory;
  }
  return clip_of(problem.initial, with_exact(motion, keys));
}

}  // namespace inhabit::refine
