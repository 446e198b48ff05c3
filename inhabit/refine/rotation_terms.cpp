#include "inhabit/refine/rotation_terms.h"

#include <ATen/Parallel.h>

#include <cmath>

#include "inhabit/math/quaternion.h"
#include "inhabit/refine/terms.h"

namespace inhabit::refine {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Derivative of log(exp(a) exp(d)) by d at d = 0: the inverse of SO(3)'s right Jacobian. Its transpose is that of
/// log(exp(d) exp(a)).
Matrix3d log_derivative(const Vector3d& a) {
  const double angle2 = a.squaredNorm(), angle = std::sqrt(angle2);
  const Matrix3d k = cross_matrix(a);
  const double second = angle2 < 1e-6 ? 1.0 / 12 + angle2 / 720 : 1 / angle2 - 0.5 / (angle * std::tan(0.5 * angle));
  return Matrix3d::Identity() + 0.5 * k + second * k * k;
}

/// Rotations: nearness, limits and differences in time.
class RotationTerms {
 public:
  /// @param linear false: the cost alone
  RotationTerms(const Problem& problem, const Trajectory& trajectory, int joint, bool linear, RotationEquations& out)
      : problem_(problem), trajectory_(trajectory), joint_(joint), linear_(linear), out_(out) {
    out.cost = 0;
    if (linear) {
      std::array<Matrix3d, 4> none;
      none.fill(Matrix3d::Zero());
      out.blocks.assign(trajectory.size(), none);
      out.gradient.assign(trajectory.size(), Vector3d::Zero());
    }
    add_single_frames();
    add_differences();
  }

 private:
  void add_single_frames() {
    const auto joints = static_cast<int64_t>(problem_.bones.size());
    for (int64_t t = 0; t < problem_.frames(); ++t) {
      const Eigen::Quaterniond& now = trajectory_[t].local[joint_];
      const double near = problem_.stay_near.rotations.empty() ? 0 : problem_.stay_near.rotations[t * joints + joint_];
      if (near > 0) {
        const Vector3d r = axis_angle_of(near_[t].local[joint_].conjugate() * now);
        out_.cost += 0.5 * near * r.squaredNorm();
        if (linear_) {
          const Matrix3d d = log_derivative(r);
          out_.blocks[t][0] += near * d.transpose() * d;
          out_.gradient[t] += near * d.transpose() * r;
        }
      }
      if (problem_.limit_weight > 0 && joint_ > 0 && !problem_.low.empty()) {
        const Vector3d a = axis_angle_of(now);
        const Vector3d over = (a - problem_.high[joint_]).cwiseMax(0.0) + (a - problem_.low[joint_]).cwiseMin(0.0);
        if (over.isZero()) continue;
        out_.cost += 0.5 * problem_.limit_weight * over.squaredNorm();
        if (linear_) {
          const Vector3d active = problem_.limit_weight * over.cwiseSign().cwiseAbs();
          const Matrix3d d = log_derivative(a);
          out_.blocks[t][0] += d.transpose() * active.asDiagonal() * d;
          out_.gradient[t] += problem_.limit_weight * d.transpose() * over;
        }
      }
    }
  }

  void add_differences() {
    const int64_t frames = problem_.frames();
    bool any = false, changes = false;
    for (const Smoothness& s : problem_.smoothness) {
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
        to[t] = axis_angle_of(of[t].local[joint_].conjugate() * of[t + 1].local[joint_]);
    };
    steps_of(trajectory_, steps);
    if (changes) steps_of(problem_.start, before);
    if (linear_) {
      derivatives.resize(frames - 1);
      for (int64_t t = 0; t + 1 < frames; ++t) derivatives[t] = log_derivative(steps[t]);
    }
    for (const Smoothness& s : problem_.smoothness) {
      const double weight = s.rotations * joint_factor(s, joint_);
      if (weight <= 0) continue;
      const std::vector<double> c = difference(s.order - 1);
      const double per = std::pow(problem_.rate, 2 * s.order);
      for (int64_t t = 0; t + s.order < frames; ++t) {
        Vector3d r = Vector3d::Zero();
        for (int n = 0; n < s.order; ++n)
          r += c[n] * (s.of_change ? Vector3d(steps[t + n] - before[t + n]) : steps[t + n]);
        const Weighted w = weighted(s.loss, per * r.squaredNorm());
        out_.cost += weight * w.cost;
        if (!linear_) continue;
        const double factor = weight * w.factor * per;
        std::array<Matrix3d, 4> d;
        d.fill(Matrix3d::Zero());
        for (int n = 0; n < s.order; ++n) {
          d[n] -= c[n] * derivatives[t + n].transpose();
          d[n + 1] += c[n] * derivatives[t + n];
        }
        for (int n = 0; n <= s.order; ++n) {
          out_.gradient[t + n] += factor * d[n].transpose() * r;
          for (int m = 0; m <= n; ++m) out_.blocks[t + m][n - m] += factor * d[n].transpose() * d[m];
        }
      }
    }
  }

  const Problem& problem_;
  const Trajectory& near_ = problem_.stay_near.to.empty() ? problem_.start : problem_.stay_near.to;
  const Trajectory& trajectory_;
  int joint_;
  bool linear_;
  RotationEquations& out_;
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
  for (int j = 0; j < problem.bones.size(); ++j)
    RotationTerms(problem, trajectory, j, linear[static_cast<size_t>(j)] != 0, out[static_cast<size_t>(j)]);
}

}  // namespace inhabit::refine
