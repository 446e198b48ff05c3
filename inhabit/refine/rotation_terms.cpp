#include "inhabit/refine/rotation_terms.h"

#include <ATen/Parallel.h>

#include <cmath>

#include "inhabit/math/quaternion.h"
#include "inhabit/refine/terms.h"

namespace inhabit::refine {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// One joint's, as they are added to.
struct JointTerms {
  const Problem& problem;
  const Trajectory& trajectory;
  int joint;
  bool linear;  ///< with equations, not the cost alone
  RotationEquations& out;

  void add_single_frames() {
    const auto joints = static_cast<int64_t>(problem.bones.size());
    for (int64_t t = 0; t < problem.frames(); ++t) {
      const Eigen::Quaterniond& now = trajectory[t].local[joint];
      const double near = problem.stay_near.rotations.empty() ? 0 : problem.stay_near.rotations[t * joints + joint];
      if (near > 0) {
        const Vector3d r = axis_angle_of(problem.near_to()[t].local[joint].conjugate() * now);
        out.cost += 0.5 * near * r.squaredNorm();
        if (linear) {
          const Matrix3d d = log_derivative(r);
          out.blocks[t][0] += near * d.transpose() * d;
          out.gradient[t] += near * d.transpose() * r;
        }
      }
      if (problem.limit_weight > 0 && joint > 0 && !problem.limits.low.empty()) {
        const Vector3d a = axis_angle_of(now);
        const Vector3d over = problem.limits.beyond(joint, a);
        if (over.isZero()) continue;
        out.cost += 0.5 * problem.limit_weight * over.squaredNorm();
        if (linear) {
          const Vector3d active = problem.limit_weight * over.cwiseSign().cwiseAbs();
          const Matrix3d d = log_derivative(a);
          out.blocks[t][0] += d.transpose() * active.asDiagonal() * d;
          out.gradient[t] += problem.limit_weight * d.transpose() * over;
        }
      }
    }
  }

  void add_differences() {
    const int64_t frames = problem.frames();
    bool any = false, changes = false;
    for (const Smoothness& s : problem.smoothness) {
      any = any || s.rotations > 0;
      changes = changes || (s.rotations > 0 && s.of_change);
    }
    if (!any || frames < 2) return;
    // Rotation from each frame to the next, and its derivative by the next one's; by its own it is minus the transpose.
    std::vector<Vector3d> steps(frames - 1), before;
    std::vector<Matrix3d> derivatives;
    const auto steps_of = [&](const Trajectory& of, std::vector<Vector3d>& to) {
      to.resize(frames - 1);
      for (int64_t t = 0; t + 1 < frames; ++t)
        to[t] = axis_angle_of(of[t].local[joint].conjugate() * of[t + 1].local[joint]);
    };
    steps_of(trajectory, steps);
    if (changes) steps_of(problem.start, before);
    if (linear) {
      derivatives.resize(frames - 1);
      for (int64_t t = 0; t + 1 < frames; ++t) derivatives[t] = log_derivative(steps[t]);
    }
    for (const Smoothness& s : problem.smoothness) {
      const double weight = s.rotations * joint_factor(s, joint);
      if (weight <= 0) continue;
      const std::vector<double> c = difference(s.order - 1);
      const double per = std::pow(problem.rate, 2 * s.order);
      for (int64_t t = 0; t + s.order < frames; ++t) {
        Vector3d r = Vector3d::Zero();
        for (int n = 0; n < s.order; ++n)
          r += c[n] * (s.of_change ? Vector3d(steps[t + n] - before[t + n]) : steps[t + n]);
        const Weighted w = weighted(s.loss, per * r.squaredNorm());
        out.cost += weight * w.cost;
        if (!linear) continue;
        const double factor = weight * w.factor * per;
        std::array<Matrix3d, 4> d;
        d.fill(Matrix3d::Zero());
        for (int n = 0; n < s.order; ++n) {
          d[n] -= c[n] * derivatives[t + n].transpose();
          d[n + 1] += c[n] * derivatives[t + n];
        }
        for (int n = 0; n <= s.order; ++n) {
          out.gradient[t + n] += factor * d[n].transpose() * r;
          for (int m = 0; m <= n; ++m) out.blocks[t + m][n - m] += factor * d[n].transpose() * d[m];
        }
      }
    }
  }
};

}  // namespace

std::vector<double> difference(int order) {
  std::vector<double> c{1};
  for (int n = 0; n < order; ++n) {
    c.push_back(0);
    for (size_t i = c.size() - 1; i > 0; --i) c[i] = c[i - 1] - c[i];
    c[0] = -c[0];
  }
  return c;
}

double joint_factor(const Smoothness& s, int joint) {
  return s.joints.empty() ? 1 : s.joints[static_cast<size_t>(joint)];
}

void add_rotation_terms(const Problem& problem, const Trajectory& trajectory, const std::vector<char>& linear,
                        std::vector<RotationEquations>& out) {
  out.resize(linear.size());
#pragma omp parallel for num_threads(at::get_num_threads()) schedule(dynamic)
  for (int j = 0; j < problem.bones.size(); ++j) {
    RotationEquations& own = out[static_cast<size_t>(j)];
    JointTerms terms{problem, trajectory, j, linear[static_cast<size_t>(j)] != 0, own};
    own.cost = 0;
    if (terms.linear) {
      std::array<Matrix3d, 4> none;
      none.fill(Matrix3d::Zero());
      own.blocks.assign(trajectory.size(), none);
      own.gradient.assign(trajectory.size(), Vector3d::Zero());
    }
    terms.add_single_frames();
    terms.add_differences();
  }
}

}  // namespace inhabit::refine
