#include "inhabit/body/fit.h"

#include <ATen/Parallel.h>

#include <Eigen/Dense>

#include "inhabit/body/bones.h"
#include "inhabit/body/fit_frames.h"
#include "inhabit/body/joint_limits.h"
#include "inhabit/error.h"
#include "inhabit/math/block_band.h"
#include "inhabit/math/quantile.h"
#include "inhabit/math/quaternion.h"

namespace inhabit {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using torch::Tensor;

using Targets = FitTargets;

/// As FitFrame, in the form that pose_bones() takes.
struct Frame {
  std::vector<Quaterniond> local;
  Vector3d trans;
};

std::vector<Frame> closed_form(const Bones& bones, const std::vector<Targets>& targets) {
  std::vector<Frame> out;
  out.reserve(targets.size());
  for (const FitFrame& frame : fit_frames(bones, targets))
    out.push_back({{frame.local.begin(), frame.local.end()}, frame.trans});
  return out;
}

/// Joints whose turning moves another joint. Three unknowns each, then three of the translation.
constexpr std::array<int, 17> kTurning = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 16, 17, 18, 19};
constexpr int kRotations = 3 * static_cast<int>(kTurning.size()), kUnknowns = kRotations + 3;
constexpr double kLimitWeight = 0.05;  // metres a radian beyond a limit
constexpr int kWindow = 240;           // frames solved together
constexpr int kRounds = 10;            // at most; four or five are usual

struct Problem {
  Bones bones;
  std::array<double, kStandardJoints> weights;
  JointLimits limits;
  std::array<Vector3d, kStandardJoints> rest_pull;  ///< metres a radian of each axis-angle component
  double smoothness;
};

Vector3d rotation_between(const Frame& before, const Frame& after, int joint) {
  return axis_angle_of(before.local[joint].conjugate() * after.local[joint]);
}

/// Half the sum of squared residuals of frames; `before` is the fixed frame ahead of them, or null.
double cost(const Problem& problem, const std::vector<Targets>& targets, size_t first, const std::vector<Frame>& frames,
            const Frame* before) {
  double sum = 0;
  BonesPose pose;
  for (size_t t = 0; t < frames.size(); ++t) {
    pose_bones(problem.bones, frames[t].local, frames[t].trans, pose);
    for (int k = 0; k < kStandardJoints; ++k)
      sum += problem.weights[k] * (pose.positions[k] - targets[first + t][k]).squaredNorm();
    for (int j : kTurning) {
      if (before != nullptr)
        sum += problem.smoothness * problem.smoothness * rotation_between(*before, frames[t], j).squaredNorm();
      if (j == 0) continue;
      const Vector3d a = axis_angle_of(frames[t].local[j]);
      sum += problem.rest_pull[j].cwiseProduct(a).squaredNorm();
      sum += kLimitWeight * kLimitWeight * problem.limits.beyond(j, a).squaredNorm();
    }
    before = &frames[t];
  }
  return 0.5 * sum;
}

/// Sums over the joints that rotate with a joint: those below it.
struct Moments {
  double weight = 0;
  Vector3d first = Vector3d::Zero();    ///< of positions p
  Matrix3d second = Matrix3d::Zero();   ///< of p p^T
  Vector3d error = Vector3d::Zero();    ///< of residuals e
  Vector3d turning = Vector3d::Zero();  ///< of p x e

  void add(const Moments& other) {
    weight += other.weight;
    first += other.first;
    second += other.second;
    error += other.error;
    turning += other.turning;
  }
};

/// One frame's own part of the normal equations. Rotating joint i by d moves joint k below it by (R_i d) x (p_k - p_i),
/// so that what two joints share are sums over the joints below the lower one: no Jacobian is written out.
void add_frame(const Problem& problem, const Targets& y, const Frame& frame, MatrixXd& h, Eigen::Ref<VectorXd> g) {
  BonesPose pose;
  pose_bones(problem.bones, frame.local, frame.trans, pose);
  const std::vector<int>& parents = problem.bones.parents;
  std::array<int, kStandardJoints> column;
  column.fill(-1);
  for (size_t i = 0; i < kTurning.size(); ++i) column[kTurning[i]] = 3 * static_cast<int>(i);

  std::array<Matrix3d, kStandardJoints> rotation;
  std::array<Vector3d, kStandardJoints> at;    // about the root, for precision
  std::array<Moments, kStandardJoints> below;  // without the joint itself
  Moments all;
  for (int k = kStandardJoints - 1; k >= 0; --k) {
    rotation[k] = pose.rotations[k].toRotationMatrix();
    at[k] = pose.positions[k] - frame.trans;
    const double w = problem.weights[k];
    const Vector3d error = pose.positions[k] - y[k];
    Moments own{w, w * at[k], w * at[k] * at[k].transpose(), w * error, w * at[k].cross(error)};
    own.add(below[k]);
    if (parents[k] >= 0)
      below[parents[k]].add(own);
    else
      all.add(own);
  }

  h.setZero();
  for (int j : kTurning) {
    const Moments& m = below[j];
    const auto to_j = static_cast<Eigen::Index>(column[j]);
    for (int i = j; i >= 0; i = parents[i]) {
      const auto to_i = static_cast<Eigen::Index>(column[i]);
      const Matrix3d outer =
          m.second - m.first * at[i].transpose() - at[j] * m.first.transpose() + m.weight * at[j] * at[i].transpose();
      const Matrix3d block = rotation[i].transpose() * (outer.trace() * Matrix3d::Identity() - outer) * rotation[j];
      h.block<3, 3>(to_i, to_j) = block;
      h.block<3, 3>(to_j, to_i) = block.transpose();
    }
    const Matrix3d shift = rotation[j].transpose() * cross_matrix(m.first - m.weight * at[j]);
    h.block<3, 3>(to_j, kRotations) = shift;
    h.block<3, 3>(kRotations, to_j) = shift.transpose();
    g.segment<3>(to_j) = rotation[j].transpose() * (m.turning - at[j].cross(m.error));
  }
  h.block<3, 3>(kRotations, kRotations) = all.weight * Matrix3d::Identity();
  g.tail<3>() = all.error;
  for (int j : kTurning) {
    if (j == 0) continue;
    const Vector3d a = axis_angle_of(frame.local[j]), over = problem.limits.beyond(j, a);
    const Matrix3d d = log_derivative(a);
    const Vector3d pull2 = problem.rest_pull[j].cwiseAbs2();
    Vector3d weight = pull2, force = pull2.cwiseProduct(a);
    for (int i = 0; i < 3; ++i)
      if (over[i] != 0) weight[i] += kLimitWeight * kLimitWeight;
    force += kLimitWeight * kLimitWeight * over;
    h.block<3, 3>(column[j], column[j]) += d.transpose() * weight.asDiagonal() * d;
    g.segment<3>(column[j]) += d.transpose() * force;
  }
}

Frame moved(const Frame& frame, const Eigen::Ref<const VectorXd>& step) {
  Frame out = frame;
  for (size_t i = 0; i < kTurning.size(); ++i) {
    Quaterniond& q = out.local[kTurning[i]];
    q = (q * quaternion_of(Vector3d(step.segment<3>(3 * static_cast<Eigen::Index>(i))))).normalized();
  }
  out.trans += step.tail<3>();
  return out;
}

/// Levenberg-Marquardt over a window of frames. Only neighbouring frames are coupled, through smoothness.
void solve_window(const Problem& problem, const std::vector<Targets>& targets, size_t first, std::vector<Frame>& frames,
                  const Frame* before) {
  const auto n = static_cast<int64_t>(frames.size());
  const double s2 = problem.smoothness * problem.smoothness;
  double now = cost(problem, targets, first, frames, before), damping = 1e-4;
  std::vector<MatrixXd> h(frames.size(), MatrixXd(kUnknowns, kUnknowns));
  VectorXd g(n * kUnknowns), step;
  BlockBand matrix(n, kUnknowns, 1);
  const auto row = [](int64_t frame, size_t i = 0) { return frame * kUnknowns + 3 * static_cast<int64_t>(i); };
  for (int round = 0; round < kRounds; ++round) {
    at::parallel_for(0, n, 16, [&](int64_t begin, int64_t end) {
      for (int64_t t = begin; t < end; ++t)
        add_frame(problem, targets[first + static_cast<size_t>(t)], frames[static_cast<size_t>(t)],
                  h[static_cast<size_t>(t)], g.segment<kUnknowns>(row(t)));
    });
    for (int64_t t = 0; t < n; ++t) {
      const auto frame = static_cast<size_t>(t);
      const Frame* last = t == 0 ? before : &frames[frame - 1];
      if (last == nullptr) continue;
      for (size_t i = 0; i < kTurning.size(); ++i) {
        const Vector3d r = rotation_between(*last, frames[frame], kTurning[i]);
        g.segment<3>(row(t, i)) += s2 * r;
        if (t > 0) g.segment<3>(row(t - 1, i)) -= s2 * r;
      }
      h[frame].diagonal().head(kRotations).array() += s2;
      if (t > 0) h[frame - 1].diagonal().head(kRotations).array() += s2;
    }
    bool better = false;
    double next = now;
    while (!better && damping < 1) {
      const auto fill = [&](int64_t t) {
        matrix.clear(t);
        BlockBand::Block own = matrix.at(t, 0);
        own = h[static_cast<size_t>(t)];
        own.diagonal().array() += damping;
        if (t + 1 < n) matrix.at(t, 1).diagonal().head(kRotations).setConstant(-s2);
      };
      step = -g;
      if (matrix.solve(fill, step)) {
        std::vector<Frame> trial;
        trial.reserve(frames.size());
        for (int64_t t = 0; t < n; ++t)
          trial.push_back(moved(frames[static_cast<size_t>(t)], step.segment<kUnknowns>(row(t))));
        next = cost(problem, targets, first, trial, before);
        better = next < now;
        if (better) frames = std::move(trial);
      }
      damping = better ? std::max(1e-8, damping * 0.2) : damping * 20;
    }
    if (!better || now - next < 3e-3 * now) break;
    now = next;
  }
}

BodyFit fit_of(const BodyModel& model, const Bones& bones, const std::vector<FitTargets>& targets,
               const std::vector<Frame>& frames) {
  BodyFit fit;
  const auto count = static_cast<int64_t>(frames.size());
  fit.rotations = torch::zeros({count, model.joints(), 3});
  fit.trans = torch::empty({count, 3});
  BonesPose pose;
  double sum = 0;
  for (int64_t t = 0; t < count; ++t) {
    const Frame& frame = frames[static_cast<size_t>(t)];
    pose_bones(bones, frame.local, frame.trans, pose);
    float* r = fit.rotations.data_ptr<float>() + t * model.joints() * 3;
    for (size_t j = 0; j < kStandardJoints; ++j) {
      const double error = (pose.positions[j] - targets[static_cast<size_t>(t)][j]).norm();
      sum += error;
      fit.max_error = std::max(fit.max_error, error);
      Eigen::Map<Eigen::Vector3f>(r + 3 * j) = axis_angle_of(frame.local[j]).cast<float>();
    }
    Eigen::Map<Eigen::Vector3f>(fit.trans.data_ptr<float>() + 3 * t) = frame.trans.cast<float>();
  }
  fit.mean_error = sum / static_cast<double>(count * kStandardJoints);
  return fit;
}

}  // namespace

Tensor fit_shape(const BodyModel& model, const Tensor& joints) {
  const std::vector<Targets> targets = fit_targets(joints);
  const Bones bones = fit_bones(model.skeleton);
  std::array<double, kStandardJoints> length{};
  for (int j = 1; j < kStandardJoints; ++j) {
    std::vector<double> all;
    all.reserve(targets.size());
    for (const Targets& y : targets) all.push_back((y[j] - y[bones.parents[j]]).norm());
    length[j] = median(std::move(all));
  }
  const int64_t betas = model.joint_dirs.size(2);
  const Tensor dirs = model.joint_dirs.to(torch::kDouble).contiguous();
  auto d = dirs.accessor<double, 3>();
  constexpr double kPull = 0.003;  // metres of bone length that one standard deviation is worth
  constexpr double kMostBeta = 3;
  std::vector<bool> limited(static_cast<size_t>(betas), false);
  VectorXd beta = VectorXd::Zero(betas);
  for (int round = 0; round < 8; ++round) {
    MatrixXd h = kPull * kPull * MatrixXd::Identity(betas, betas);
    VectorXd g = -kPull * kPull * beta;
    for (int j = 1; j < kStandardJoints; ++j) {
      const int parent = bones.parents[j];
      MatrixXd change(3, betas);
      for (int i = 0; i < 3; ++i)
        for (int64_t b = 0; b < betas; ++b) change(i, b) = d[j][i][b] - d[parent][i][b];
      const Vector3d bone = bones.offsets[j] + change * beta;
      const VectorXd slope = change.transpose() * bone.normalized();
      h += slope * slope.transpose();
      g += (length[j] - bone.norm()) * slope;
    }
    // Shapes are people's within a few standard deviations: what would go beyond stays at the limit for good.
    for (int64_t b = 0; b < betas; ++b) {
      if (!limited[static_cast<size_t>(b)]) continue;
      h.row(b).setZero();
      h.col(b).setZero();
      h(b, b) = 1;
      g(b) = 0;
    }
    beta += h.ldlt().solve(g);
    for (int64_t b = 0; b < betas; ++b) {
      if (std::abs(beta(b)) < kMostBeta) continue;
      beta(b) = std::copysign(kMostBeta, beta(b));
      limited[static_cast<size_t>(b)] = true;
    }
  }
  Tensor out = torch::empty({betas});
  for (int64_t b = 0; b < betas; ++b) out[b] = beta[b];
  return out;
}

BodyFit fit_body(const BodyModel& model, const Tensor& joints, const FitOptions& options) {
  const std::vector<Targets> targets = fit_targets(joints);
  const Tensor betas = !options.betas.defined() && options.fit_shape ? fit_shape(model, joints) : options.betas;

  Problem problem;
  problem.bones = fit_bones(shaped_skeleton(model, betas));
  problem.smoothness = options.smoothness;
  problem.weights.fill(1);
  if (options.weights.defined()) {
    if (options.weights.numel() != kStandardJoints) throw Error("fit", "expected 22 weights");
    const Tensor w = options.weights.to(torch::kCPU, torch::kDouble).contiguous();
    for (int j = 0; j < kStandardJoints; ++j) problem.weights[j] = std::max(0.0, w.data_ptr<double>()[j]);
  }
  problem.limits = joint_limits(model);
  // Small enough not to show in the joints; knees and elbows are hinges, which is what settles the roll of thigh and
  // upper arm.
  problem.rest_pull.fill(Vector3d::Constant(0.003));
  for (int j : {4, 5}) problem.rest_pull[j] = {0.001, 0.02, 0.02};
  for (int j : {18, 19}) problem.rest_pull[j] = {0.01, 0.001, 0.01};
  for (int j : {13, 14}) problem.rest_pull[j] = Vector3d::Constant(0.006);

  const std::vector<Frame> start = closed_form(problem.bones, targets);
  std::vector<Frame> frames;
  frames.reserve(targets.size());
  for (size_t begin = 0; begin < targets.size(); begin += kWindow) {
    const size_t end = std::min(targets.size(), begin + kWindow);
    std::vector<Frame> window(start.begin() + static_cast<int64_t>(begin), start.begin() + static_cast<int64_t>(end));
    solve_window(problem, targets, begin, window, frames.empty() ? nullptr : &frames.back());
    frames.insert(frames.end(), window.begin(), window.end());
  }
  BodyFit fit = fit_of(model, problem.bones, targets, frames);
  fit.betas = betas;
  return fit;
}

BodyFit fit_rotations(const BodyModel& model, const Tensor& joints, const Tensor& betas) {
  const std::vector<Targets> targets = fit_targets(joints);
  const Bones bones = fit_bones(shaped_skeleton(model, betas));
  BodyFit fit = fit_of(model, bones, targets, closed_form(bones, targets));
  fit.betas = betas;
  return fit;
}

}  // namespace inhabit
