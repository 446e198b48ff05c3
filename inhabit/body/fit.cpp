#include "inhabit/body/fit.h"

#include <Eigen/Dense>

#include "inhabit/body/bones.h"
#include "inhabit/body/two_bone.h"
#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"

namespace inhabit {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using torch::Tensor;

using Targets = std::array<Vector3d, kStandardJoints>;

struct Frame {
  std::vector<Quaterniond> local = std::vector<Quaterniond>(kStandardJoints, Quaterniond::Identity());
  Vector3d trans = Vector3d::Zero();
};

/// Joints whose turning moves another joint. Three unknowns each, then three of the translation.
constexpr std::array<int, 17> kTurning = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 16, 17, 18, 19};
constexpr int kTurns = 3 * static_cast<int>(kTurning.size()), kUnknowns = kTurns + 3;
constexpr double kLimitWeight = 0.05;  // metres a radian beyond a limit
constexpr int kWindow = 240;           // frames solved together
constexpr int kRounds = 10;            // at most; four or five are usual

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// The rotation that best carries `from` onto `to` (Kabsch 1976).
Quaterniond best_rotation(const std::vector<Vector3d>& from, const std::vector<Vector3d>& to) {
  Matrix3d h = Matrix3d::Zero();
  for (size_t i = 0; i < from.size(); ++i) h += to[i] * from[i].transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(h, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d flip = Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return Quaterniond(Matrix3d(svd.matrixU() * flip * svd.matrixV().transpose())).normalized();
}

Quaterniond shortest_turn(const Vector3d& from, const Vector3d& to) {
  return from.squaredNorm() < 1e-12 || to.squaredNorm() < 1e-12 ? Quaterniond::Identity()
                                                                : Quaterniond::FromTwoVectors(from, to);
}

/// One frame in closed form.
Frame closed_form(const Bones& bones, const Targets& y) {
  const auto& parents = standard_parents();
  std::array<Quaterniond, kStandardJoints> global;
  global.fill(Quaterniond::Identity());
  const auto from_children = [&](int joint, std::initializer_list<int> children) {
    std::vector<Vector3d> from, to;
    for (int c : children) {
      from.push_back(bones.offsets[c]);
      to.push_back(y[c] - y[joint]);
    }
    return best_rotation(from, to);
  };
  const auto towards = [&](int joint, int child) {
    const Quaterniond& parent = global[parents[joint]];
    return shortest_turn(parent * bones.offsets[child], y[child] - y[joint]) * parent;
  };
  const auto limb = [&](const Limb& l, bool knee) {
    const Vector3d &upper = bones.offsets[l.mid], &lower = bones.offsets[l.end];
    const Vector3d upper_now = y[l.mid] - y[l.start], lower_now = y[l.end] - y[l.mid];
    const Vector3d rest_hinge = l.rest_pole.cross(upper).normalized();
    // A straight limb shows no bending plane: its hinge leans on where the parent and the shortest turn would put it.
    const Vector3d likely = towards(l.start, l.mid) * rest_hinge;
    Vector3d hinge = upper_now.cross(lower_now);
    if (knee && hinge.dot(likely) < 0) hinge.setZero();
    hinge += 0.1 * upper_now.norm() * lower_now.norm() * likely;
    if (upper_now.squaredNorm() < 1e-12 || lower_now.squaredNorm() < 1e-12) return;
    global[l.start] = rotation_between_frames(upper, rest_hinge, upper_now, hinge);
    global[l.mid] = rotation_between_frames(lower, rest_hinge, lower_now, hinge);
  };
  global[0] = from_children(0, {1, 2, 3});
  global[3] = towards(3, 6);
  global[6] = towards(6, 9);
  global[9] = from_children(9, {12, 13, 14});
  global[12] = towards(12, 15);
  global[13] = towards(13, 16);
  global[14] = towards(14, 17);
  for (Side side : {Side::left, Side::right}) {
    limb(leg(side), true);
    limb(arm(side), false);
  }
  global[7] = towards(7, 10);
  global[8] = towards(8, 11);
  for (int j : {10, 11, 15, 20, 21}) global[j] = global[parents[j]];

  Frame frame;
  frame.trans = y[0] - bones.offsets[0];
  for (int j = 0; j < kStandardJoints; ++j)
    frame.local[j] = j == 0 ? global[0] : (global[parents[j]].conjugate() * global[j]).normalized();
  return frame;
}

struct Problem {
  Bones bones;
  std::array<double, kStandardJoints> weights;
  std::array<Vector3d, kStandardJoints> low, high;  ///< joint limits
  std::array<Vector3d, kStandardJoints> rest_pull;  ///< metres a radian of each axis-angle component
  double smoothness;
};

/// Derivative of the axis-angle vector a of a rotation R by d in R exp(d), to second order in a.
Matrix3d log_derivative(const Vector3d& a) {
  const Matrix3d k = cross_matrix(a);
  return Matrix3d::Identity() + 0.5 * k + k * k / 12.0;
}

Vector3d beyond_limits(const Problem& problem, int joint, const Vector3d& a) {
  return (a - problem.high[joint]).cwiseMax(0.0) + (a - problem.low[joint]).cwiseMin(0.0);
}

Vector3d turn_between(const Frame& before, const Frame& after, int joint) {
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
        sum += problem.smoothness * problem.smoothness * turn_between(*before, frames[t], j).squaredNorm();
      if (j == 0) continue;
      const Vector3d a = axis_angle_of(frames[t].local[j]);
      sum += problem.rest_pull[j].cwiseProduct(a).squaredNorm();
      sum += kLimitWeight * kLimitWeight * beyond_limits(problem, j, a).squaredNorm();
    }
    before = &frames[t];
  }
  return 0.5 * sum;
}

/// One frame's own part of the normal equations.
void add_frame(const Problem& problem, const Targets& y, const Frame& frame, MatrixXd& h, VectorXd& g) {
  BonesPose pose;
  pose_bones(problem.bones, frame.local, frame.trans, pose);
  std::array<Matrix3d, kStandardJoints> turn;
  for (int j = 0; j < kStandardJoints; ++j) turn[j] = pose.rotations[j].toRotationMatrix();
  std::array<int, kStandardJoints> column;
  column.fill(-1);
  for (size_t i = 0; i < kTurning.size(); ++i) column[kTurning[i]] = 3 * static_cast<int>(i);

  MatrixXd jacobian = MatrixXd::Zero(3 * kStandardJoints, kUnknowns);
  VectorXd residual(3 * kStandardJoints);
  for (int k = 0; k < kStandardJoints; ++k) {
    const double w = std::sqrt(problem.weights[k]);
    residual.segment<3>(3 * k) = w * (pose.positions[k] - y[k]);
    jacobian.block<3, 3>(3 * k, kTurns) = w * Matrix3d::Identity();
    for (int j = problem.bones.parents[k]; j >= 0; j = problem.bones.parents[j])
      jacobian.block<3, 3>(3 * k, column[j]) = -w * cross_matrix(pose.positions[k] - pose.positions[j]) * turn[j];
  }
  h.noalias() = jacobian.transpose() * jacobian;
  g.noalias() = jacobian.transpose() * residual;
  for (int j : kTurning) {
    if (j == 0) continue;
    const Vector3d a = axis_angle_of(frame.local[j]), over = beyond_limits(problem, j, a);
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

/// Levenberg-Marquardt over a window of frames. Only neighbouring frames are coupled, through smoothness, so the normal
/// equations are block tridiagonal and solved by a block Cholesky sweep.
void solve_window(const Problem& problem, const std::vector<Targets>& targets, size_t first, std::vector<Frame>& frames,
                  const Frame* before) {
  const size_t n = frames.size();
  const double s2 = problem.smoothness * problem.smoothness;
  double now = cost(problem, targets, first, frames, before), damping = 1e-6;
  std::vector<MatrixXd> h(n, MatrixXd(kUnknowns, kUnknowns));
  std::vector<VectorXd> g(n, VectorXd(kUnknowns)), step(n, VectorXd(kUnknowns));
  std::vector<Eigen::LLT<MatrixXd>> factor(n);
  for (int round = 0; round < kRounds; ++round) {
    for (size_t t = 0; t < n; ++t) add_frame(problem, targets[first + t], frames[t], h[t], g[t]);
    for (size_t t = 0; t < n; ++t) {
      const Frame* last = t == 0 ? before : &frames[t - 1];
      if (last == nullptr) continue;
      for (size_t i = 0; i < kTurning.size(); ++i) {
        const Vector3d r = turn_between(*last, frames[t], kTurning[i]);
        const auto at = 3 * static_cast<Eigen::Index>(i);
        g[t].segment<3>(at) += s2 * r;
        if (t > 0) g[t - 1].segment<3>(at) -= s2 * r;
      }
      h[t].diagonal().head(kTurns).array() += s2;
      if (t > 0) h[t - 1].diagonal().head(kTurns).array() += s2;
    }
    bool better = false;
    double next = now;
    while (!better && damping < 1) {
      MatrixXd pivot;
      for (size_t t = 0; t < n; ++t) {
        pivot = h[t];
        pivot.diagonal().array() += damping;
        step[t] = -g[t];
        if (t > 0) {
          // The coupling block is -s2 on the turns' diagonal.
          const MatrixXd inverse = factor[t - 1].solve(MatrixXd::Identity(kUnknowns, kUnknowns));
          pivot.topLeftCorner(kTurns, kTurns) -= s2 * s2 * inverse.topLeftCorner(kTurns, kTurns);
          step[t].head(kTurns) += s2 * factor[t - 1].solve(step[t - 1]).head(kTurns);
        }
        factor[t].compute(pivot);
      }
      for (size_t t = n; t-- > 0;) {
        if (t + 1 < n) step[t].head(kTurns) += s2 * step[t + 1].head(kTurns);
        step[t] = factor[t].solve(step[t]);
      }
      std::vector<Frame> trial;
      trial.reserve(n);
      for (size_t t = 0; t < n; ++t) trial.push_back(moved(frames[t], step[t]));
      next = cost(problem, targets, first, trial, before);
      better = next < now;
      if (better) frames = std::move(trial);
      damping = better ? std::max(1e-8, damping * 0.2) : damping * 20;
    }
    if (!better || now - next < 1e-4 * now) break;
    now = next;
  }
}

std::vector<Targets> targets_of(const Tensor& joints) {
  if (!joints.defined() || joints.dim() != 3 || joints.size(0) < 1 || joints.size(1) < kStandardJoints ||
      joints.size(2) != 3)
    throw Error("fit", "joints are not (T, 22 or more, 3)");
  const Tensor rows = joints.detach().narrow(1, 0, kStandardJoints).to(torch::kCPU, torch::kDouble).contiguous();
  if (!torch::isfinite(rows).all().item<bool>()) throw Error("fit", "a joint position is not finite");
  const double* p = rows.data_ptr<double>();
  std::vector<Targets> targets(static_cast<size_t>(rows.size(0)));
  for (Targets& y : targets)
    for (Vector3d& v : y) {
      v = Vector3d(p[0], p[1], p[2]);
      p += 3;
    }
  return targets;
}

/// The first 22 joints of a body's skeleton.
Bones standard_bones(const Skeleton& skeleton) {
  Bones bones = bones_of(skeleton);
  if (bones.size() < kStandardJoints ||
      !std::equal(standard_parents().begin(), standard_parents().end(), bones.parents.begin()))
    throw Error("fit", "the body's first 22 joints are not the standard ones");
  bones.parents.resize(kStandardJoints);
  bones.offsets.resize(kStandardJoints);
  return bones;
}

}  // namespace

Tensor fit_shape(const BodyModel& model, const Tensor& joints) {
  const std::vector<Targets> targets = targets_of(joints);
  const Bones bones = standard_bones(model.skeleton);
  std::array<double, kStandardJoints> length{};
  for (int j = 1; j < kStandardJoints; ++j) {
    std::vector<double> all;
    all.reserve(targets.size());
    for (const Targets& y : targets) all.push_back((y[j] - y[bones.parents[j]]).norm());
    std::nth_element(all.begin(), all.begin() + static_cast<int64_t>(all.size() / 2), all.end());
    length[j] = all[all.size() / 2];
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
  const std::vector<Targets> targets = targets_of(joints);
  BodyFit fit;
  fit.betas = !options.betas.defined() && options.fit_shape ? fit_shape(model, joints) : options.betas;

  Problem problem;
  problem.bones = standard_bones(shaped_skeleton(model, fit.betas));
  problem.smoothness = options.smoothness;
  problem.weights.fill(1);
  if (options.weights.defined()) {
    if (options.weights.numel() != kStandardJoints) throw Error("fit", "expected 22 weights");
    const Tensor w = options.weights.to(torch::kCPU, torch::kDouble).contiguous();
    for (int j = 0; j < kStandardJoints; ++j) problem.weights[j] = std::max(0.0, w.data_ptr<double>()[j]);
  }
  problem.low.fill(Vector3d::Constant(-6.3));
  problem.high.fill(Vector3d::Constant(6.3));
  if (model.joint_limits.defined()) {
    const Tensor limits = model.joint_limits.to(torch::kCPU, torch::kDouble).contiguous();
    auto l = limits.accessor<double, 3>();
    for (int j = 0; j < kStandardJoints; ++j)
      for (int i = 0; i < 3; ++i) {
        problem.low[j][i] = l[j][i][0];
        problem.high[j][i] = l[j][i][1];
      }
  }
  // Small enough not to show in the joints; knees and elbows are hinges, which is what settles the roll of thigh and
  // upper arm.
  problem.rest_pull.fill(Vector3d::Constant(0.003));
  for (int j : {4, 5}) problem.rest_pull[j] = {0.001, 0.02, 0.02};
  for (int j : {18, 19}) problem.rest_pull[j] = {0.01, 0.001, 0.01};
  for (int j : {13, 14}) problem.rest_pull[j] = Vector3d::Constant(0.006);

  std::vector<Frame> frames;
  frames.reserve(targets.size());
  for (size_t begin = 0; begin < targets.size(); begin += kWindow) {
    std::vector<Frame> window;
    for (size_t t = begin; t < std::min(targets.size(), begin + kWindow); ++t)
      window.push_back(closed_form(problem.bones, targets[t]));
    solve_window(problem, targets, begin, window, frames.empty() ? nullptr : &frames.back());
    frames.insert(frames.end(), window.begin(), window.end());
  }

  const int64_t count = static_cast<int64_t>(frames.size());
  fit.rotations = torch::zeros({count, model.joints(), 3});
  fit.trans = torch::empty({count, 3});
  auto r = fit.rotations.accessor<float, 3>();
  auto x = fit.trans.accessor<float, 2>();
  BonesPose pose;
  for (int64_t t = 0; t < count; ++t) {
    const Frame& frame = frames[t];
    pose_bones(problem.bones, frame.local, frame.trans, pose);
    for (int j = 0; j < kStandardJoints; ++j) {
      fit.mean_error += (pose.positions[j] - targets[t][j]).norm() / static_cast<double>(count * kStandardJoints);
      const Vector3d a = axis_angle_of(frame.local[j]);
      for (int i = 0; i < 3; ++i) r[t][j][i] = static_cast<float>(a[i]);
    }
    for (int i = 0; i < 3; ++i) x[t][i] = static_cast<float>(frame.trans[i]);
  }
  return fit;
}

}  // namespace inhabit
