#include "inhabit/refine/terms.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>

#include "inhabit/math/quaternion.h"
#include "inhabit/refine/depth_terms.h"
#include "inhabit/refine/panel_kernel.h"

namespace inhabit::refine {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

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

/// Coefficients of the n-th difference.
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

bool is_fixed(const Problem& problem, int64_t frame) {
  return !problem.fixed.empty() && problem.fixed[static_cast<size_t>(frame)] != 0;
}

std::vector<BonesPose> poses_of(const Problem& problem, const Trajectory& trajectory) {
  std::vector<BonesPose> poses(trajectory.size());
  for (size_t t = 0; t < trajectory.size(); ++t)
    pose_bones(problem.bones, trajectory[t].local, trajectory[t].trans, poses[t]);
  return poses;
}

/// Points whose places enter differences in time: the joints, and what is held.
std::vector<int> core_points(const Problem& problem) {
  std::vector<char> is_core(problem.points.size(), 0);
  for (const Smoothness& s : problem.smoothness)
    if (s.positions > 0)
      for (int j = 0; j < problem.bones.size(); ++j) is_core[static_cast<size_t>(j)] |= joint_factor(s, j) > 0;
  for (const HoldTerm& h : problem.holds) is_core[static_cast<size_t>(h.point)] = 1;
  std::vector<int> core;
  for (size_t i = 0; i < is_core.size(); ++i)
    if (is_core[i]) core.push_back(static_cast<int>(i));
  return core;
}

/// What the terms say about the core points' places: half pᵀ W p in the small, W diagonal for every pair of frames.
struct PlaceEquations {
  std::vector<VectorXd> gradient;                ///< (frames) 3 a core point
  std::vector<std::array<VectorXd, 4>> weights;  ///< (frames, apart)

  PlaceEquations(int64_t frames, int64_t rows, int band) : gradient(frames, VectorXd::Zero(rows)), weights(frames) {
    for (auto& w : weights)
      for (int k = 0; k <= band; ++k) w[static_cast<size_t>(k)] = VectorXd::Zero(rows);
  }
  void add(int64_t t, int apart, int64_t row, const Vector3d& weight) {
    weights[static_cast<size_t>(t)][static_cast<size_t>(apart)].segment<3>(row) += weight;
  }
};

/// Differences in time of places. @param equations null: the cost alone
double add_place_differences(const Problem& problem, const std::vector<int>& core, const std::vector<VectorXd>& places,
                             const std::vector<VectorXd>& start, PlaceEquations* equations) {
  double cost = 0;
  const int64_t frames = problem.frames();
  for (const Smoothness& s : problem.smoothness) {
    if (s.positions <= 0) continue;
    const std::vector<double> c = difference(s.order);
    const double scale = std::pow(problem.rate, s.order), per = scale * scale;
    for (int64_t t = 0; t + s.order < frames; ++t)
      for (size_t i = 0; i < core.size(); ++i) {
        if (core[i] >= problem.bones.size()) break;
        const double weight = s.positions * joint_factor(s, core[i]);
        if (weight <= 0) continue;
        const auto row = static_cast<Eigen::Index>(3 * i);
        Vector3d r = Vector3d::Zero();
        for (int n = 0; n <= s.order; ++n) {
          r += c[n] * places[t + n].segment<3>(row);
          if (s.of_change) r -= c[n] * start[t + n].segment<3>(row);
        }
        const Weighted w = weighted(s.loss, per * r.squaredNorm());
        cost += weight * w.cost;
        if (equations == nullptr) continue;
        const double factor = weight * w.factor * per;
        for (int n = 0; n <= s.order; ++n) {
          equations->gradient[t + n].segment<3>(row) += factor * c[n] * r;
          for (int m = 0; m <= n; ++m) equations->add(t + m, n - m, row, Vector3d::Constant(factor * c[n] * c[m]));
        }
      }
  }
  std::vector<int> row_of(problem.points.size(), -1);
  for (size_t i = 0; i < core.size(); ++i) row_of[static_cast<size_t>(core[i])] = static_cast<int>(3 * i);
  for (const HoldTerm& h : problem.holds) {
    const int row = row_of[static_cast<size_t>(h.point)];
    const Vector3d r = places[h.frame + 1].segment<3>(row) - places[h.frame].segment<3>(row);
    const Vector3d force = h.weight.cwiseProduct(r);
    cost += 0.5 * force.dot(r);
    if (equations == nullptr) continue;
    equations->gradient[h.frame + 1].segment<3>(row) += force;
    equations->gradient[h.frame].segment<3>(row) -= force;
    equations->add(h.frame, 0, row, h.weight);
    equations->add(h.frame + 1, 0, row, h.weight);
    equations->add(h.frame, 1, row, -h.weight);
  }
  return cost;
}

/// d place / d unknowns of the main system, three rows of `out` from `row` on, which hold zeros.
template <class Rows>
void point_jacobian(const Problem& problem, const Unknowns& unknowns, const Point& point, const BonesPose& pose,
                    const std::vector<Matrix3d>& rotations, Rows&& out) {
  for (const Attachment& a : point) {
    const Vector3d at = pose.positions[a.joint] + rotations[a.joint] * a.offset;
    for (int j = a.joint; j >= 0; j = problem.bones.parents[j]) {
      const auto [system, column] = unknowns.rotations[j];
      if (system != Unknowns::kMain) continue;
      const Vector3d arm = at - pose.positions[j];
      for (int i = 0; i < 3; ++i) out.col(column + i) += a.weight * rotations[j].col(i).cross(arm);
    }
    if (unknowns.root >= 0)
      for (int i = 0; i < 3; ++i) out(i, unknowns.root + i) += a.weight;
  }
}

/// Terms of single frames on points: rows of a Jacobian and residuals, both times the root of the weight.
struct FrameRows {
  std::vector<double> values;  ///< (rows, columns) row by row
  std::vector<double> residuals;
  double cost = 0;
};

/// Which terms a frame has.
struct FrameTerms {
  std::vector<const PlaceTerm*> places;
  std::vector<const PlaneTerm*> planes;
};

std::vector<FrameTerms> by_frame(const Problem& problem) {
  std::vector<FrameTerms> out(problem.start.size());
  for (const PlaceTerm& p : problem.places) out[p.frame].places.push_back(&p);
  for (const PlaneTerm& p : problem.planes) out[p.frame].planes.push_back(&p);
  return out;
}

/// @param unknowns null: the cost alone
void add_frame_rows(const Problem& problem, const Unknowns* unknowns, const FrameTerms& terms, const BonesPose& pose,
                    const std::vector<Matrix3d>& rotations, FrameRows& out) {
  out.values.clear();
  out.residuals.clear();
  out.cost = 0;
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  Rows jacobian;
  const auto linear = [&](const Point& point) {
    jacobian.setZero(3, unknowns->columns[Unknowns::kMain]);
    point_jacobian(problem, *unknowns, point, pose, rotations, jacobian);
  };
  const auto add = [&](const Eigen::RowVectorXd& row, double residual, double weight) {
    const double root = std::sqrt(weight);
    for (Eigen::Index i = 0; i < row.size(); ++i) out.values.push_back(root * row[i]);
    out.residuals.push_back(root * residual);
  };
  for (const PlaceTerm* term : terms.places) {
    const Point& point = problem.points[static_cast<size_t>(term->point)];
    const Vector3d r = place_of(point, pose) - term->target;
    const Weighted w = weighted(term->loss, r.cwiseProduct(term->weight).dot(r));
    out.cost += w.cost;
    if (unknowns == nullptr) continue;
    linear(point);
    for (int i = 0; i < 3; ++i)
      if (term->weight[i] > 0) add(jacobian.row(i), r[i], w.factor * term->weight[i]);
  }
  for (const PlaneTerm* term : terms.planes) {
    const Point& point = problem.points[static_cast<size_t>(term->point)];
    const double r = term->normal.dot(place_of(point, pose)) - term->height;
    if (r >= 0 && !term->on_it) continue;
    out.cost += 0.5 * term->weight * r * r;
    if (unknowns == nullptr) continue;
    linear(point);
    add(term->normal.transpose() * jacobian, r, term->weight);
  }
}

/// Rotations: nearness, limits and differences in time. @param out null: the cost alone
class RotationTerms {
 public:
  RotationTerms(const Problem& problem, const Unknowns* unknowns, const Trajectory& trajectory, NormalEquations* out)
      : problem_(problem), unknowns_(unknowns), trajectory_(trajectory), out_(out) {}

  double add() {
    double cost = 0;
    for (int j = 0; j < problem_.bones.size(); ++j) {
      if (out_ != nullptr) {
        system_ = unknowns_->rotations[j][0];
        column_ = unknowns_->rotations[j][1];
      }
      cost += add_single_frames(j) + add_differences(j);
    }
    for (int64_t t = 0; t < problem_.frames() && !problem_.stay_near.root.empty(); ++t) {
      const double weight = problem_.stay_near.root[t];
      const Vector3d r = trajectory_[t].trans - near_[t].trans;
      cost += 0.5 * weight * r.squaredNorm();
      if (out_ == nullptr || unknowns_->root < 0) continue;
      auto block = out_->matrices[0].at(t, 0);
      block.diagonal().segment<3>(unknowns_->root).array() += weight;
      out_->gradients[0].segment<3>(t * unknowns_->columns[0] + unknowns_->root) += weight * r;
    }
    return cost;
  }

 private:
  bool linear() const { return out_ != nullptr && system_ >= 0; }
  auto gradient(int64_t t) { return out_->gradients[system_].segment<3>(t * unknowns_->columns[system_] + column_); }
  void add_block(int64_t t, int apart, const Matrix3d& values) {
    out_->matrices[system_].at(t, apart).block<3, 3>(column_, column_) += values;
  }

  double add_single_frames(int joint) {
    double cost = 0;
    const auto joints = static_cast<int64_t>(problem_.bones.size());
    for (int64_t t = 0; t < problem_.frames(); ++t) {
      const Eigen::Quaterniond& now = trajectory_[t].local[joint];
      const double near = problem_.stay_near.rotations.empty() ? 0 : problem_.stay_near.rotations[t * joints + joint];
      if (near > 0) {
        const Vector3d r = axis_angle_of(near_[t].local[joint].conjugate() * now);
        cost += 0.5 * near * r.squaredNorm();
        if (linear()) {
          const Matrix3d d = log_derivative(r);
          add_block(t, 0, near * d.transpose() * d);
          gradient(t) += near * d.transpose() * r;
        }
      }
      if (problem_.limit_weight > 0 && joint > 0 && !problem_.low.empty()) {
        const Vector3d a = axis_angle_of(now);
        const Vector3d over = (a - problem_.high[joint]).cwiseMax(0.0) + (a - problem_.low[joint]).cwiseMin(0.0);
        if (over.isZero()) continue;
        cost += 0.5 * problem_.limit_weight * over.squaredNorm();
        if (linear()) {
          const Vector3d active = problem_.limit_weight * over.cwiseSign().cwiseAbs();
          const Matrix3d d = log_derivative(a);
          add_block(t, 0, d.transpose() * active.asDiagonal() * d);
          gradient(t) += problem_.limit_weight * d.transpose() * over;
        }
      }
    }
    return cost;
  }

  double add_differences(int joint) {
    double cost = 0;
    const int64_t frames = problem_.frames();
    bool any = false, changes = false;
    for (const Smoothness& s : problem_.smoothness) {
      any = any || s.rotations > 0;
      changes = changes || (s.rotations > 0 && s.of_change);
    }
    if (!any || frames < 2) return 0;
    // Rotation from each frame to the next, and its derivative by the next one's; by its own it is minus the transpose.
    std::vector<Vector3d> steps(frames - 1), before;
    std::vector<Matrix3d> derivatives;
    const auto steps_of = [&](const Trajectory& of, std::vector<Vector3d>& to) {
      to.resize(frames - 1);
      for (int64_t t = 0; t + 1 < frames; ++t)
        to[t] = axis_angle_of(of[t].local[joint].conjugate() * of[t + 1].local[joint]);
    };
    steps_of(trajectory_, steps);
    if (changes) steps_of(problem_.start, before);
    if (linear()) {
      derivatives.resize(frames - 1);
      for (int64_t t = 0; t + 1 < frames; ++t) derivatives[t] = log_derivative(steps[t]);
    }
    for (const Smoothness& s : problem_.smoothness) {
      const double weight = s.rotations * joint_factor(s, joint);
      if (weight <= 0) continue;
      const std::vector<double> c = difference(s.order - 1);
      const double per = std::pow(problem_.rate, 2 * s.order);
      for (int64_t t = 0; t + s.order < frames; ++t) {
        Vector3d r = Vector3d::Zero();
        for (int n = 0; n < s.order; ++n)
          r += c[n] * (s.of_change ? Vector3d(steps[t + n] - before[t + n]) : steps[t + n]);
        const Weighted w = weighted(s.loss, per * r.squaredNorm());
        cost += weight * w.cost;
        if (!linear()) continue;
        const double factor = weight * w.factor * per;
        std::array<Matrix3d, 4> d;
        d.fill(Matrix3d::Zero());
        for (int n = 0; n < s.order; ++n) {
          d[n] -= c[n] * derivatives[t + n].transpose();
          d[n + 1] += c[n] * derivatives[t + n];
        }
        for (int n = 0; n <= s.order; ++n) {
          gradient(t + n) += factor * d[n].transpose() * r;
          for (int m = 0; m <= n; ++m) add_block(t + m, n - m, factor * d[n].transpose() * d[m]);
        }
      }
    }
    return cost;
  }

  const Problem& problem_;
  const Trajectory& near_ = problem_.stay_near.to.empty() ? problem_.start : problem_.stay_near.to;
  const Unknowns* unknowns_;
  const Trajectory& trajectory_;
  NormalEquations* out_;
  int system_ = -1, column_ = 0;
};

std::vector<VectorXd> places_of(const Problem& problem, const std::vector<int>& core,
                                const std::vector<BonesPose>& poses) {
  std::vector<VectorXd> places(poses.size(), VectorXd(3 * core.size()));
  for (size_t t = 0; t < poses.size(); ++t)
    for (size_t i = 0; i < core.size(); ++i)
      places[t].segment<3>(static_cast<Eigen::Index>(3 * i)) =
          place_of(problem.points[static_cast<size_t>(core[i])], poses[t]);
  return places;
}

std::vector<VectorXd> start_places(const Problem& problem, const std::vector<int>& core) {
  for (const Smoothness& s : problem.smoothness)
    if (s.of_change && s.positions > 0) return places_of(problem, core, poses_of(problem, problem.start));
  return {};
}

std::vector<Matrix3d> matrices_of(const BonesPose& pose) {
  std::vector<Matrix3d> out;
  out.reserve(pose.rotations.size());
  for (const Eigen::Quaterniond& q : pose.rotations) out.push_back(q.toRotationMatrix());
  return out;
}

/// A frame's panel of the main system: J_tᵀ W J_t+k for every k, and aᵀ a of its own rows a.
/// @param jacobian (rows, padded) of the frame; those of the frames after it follow
/// @param scratch rows of [-J_t, W J_t, W J_t+1 ...], so that a frame's products are one
void fill_panel(const std::array<VectorXd, 4>& weights, const double* jacobian, int64_t rows, int64_t columns,
                const FrameRows& own, int64_t t, BlockBand& matrix, std::vector<double>& scratch) {
  const int64_t padded = matrix.padded(), reach = std::min<int64_t>(matrix.band(), matrix.frames() - 1 - t);
  double* panel = matrix.panel(t);
  std::fill(panel, panel + columns * matrix.stride(), 0.0);
  const int64_t wide = padded * (reach + 2);
  scratch.resize(static_cast<size_t>(wide * rows));
  for (int64_t r = 0; r < rows; ++r) {
    double* row = scratch.data() + r * wide;
    for (int64_t i = 0; i < padded; ++i) row[i] = -jacobian[r * padded + i];
    for (int64_t k = 0; k <= reach; ++k) {
      const double weight = weights[static_cast<size_t>(k)][r];
      const double* from = jacobian + (k * rows + r) * padded;
      for (int64_t i = 0; i < padded; ++i) row[(k + 1) * padded + i] = weight * from[i];
    }
  }
  const double* a = scratch.data();
  subtract_products(a, a + padded, wide, rows, panel, matrix.stride(), columns, padded, true);
  subtract_products(a, a + 2 * padded, wide, rows, panel + padded, matrix.stride(), columns, padded * reach, false);
  const auto count = static_cast<int64_t>(own.residuals.size());
  scratch.assign(static_cast<size_t>(2 * padded * count), 0.0);  // rows of [-a, a]
  for (int64_t r = 0; r < count; ++r) {
    double* row = scratch.data() + 2 * r * padded;
    for (int64_t i = 0; i < columns; ++i) {
      row[padded + i] = own.values[static_cast<size_t>(r * columns + i)];
      row[i] = -row[padded + i];
    }
  }
  a = scratch.data();
  subtract_products(a, a + padded, 2 * padded, count, panel, matrix.stride(), columns, padded, true);
}

/// What is known does not move: no coupling, and a step of zero.
void hold_fixed(const Problem& problem, NormalEquations& equations) {
  for (size_t system = 0; system < equations.matrices.size(); ++system) {
    BlockBand& matrix = equations.matrices[system];
    for (int64_t t = 0; t < matrix.frames(); ++t) {
      if (!is_fixed(problem, t)) continue;
      matrix.at(t, 0).setIdentity();
      for (int k = 1; k <= matrix.band(); ++k) {
        if (t + k < matrix.frames()) matrix.at(t, k).setZero();
        if (t - k >= 0) matrix.at(t - k, k).setZero();
      }
      equations.gradients[system].segment(t * matrix.block(), matrix.block()).setZero();
    }
  }
}

}  // namespace

Weighted weighted(const Loss& loss, double squared) {
  const double length = std::sqrt(squared);
  if (loss.kind == Loss::Kind::norm) {
    const double rounded = std::sqrt(squared + loss.scale * loss.scale);
    return {rounded - loss.scale, 1 / rounded};
  }
  if (loss.kind == Loss::Kind::huber && length > loss.scale)
    return {loss.scale * (length - 0.5 * loss.scale), loss.scale / length};
  return {0.5 * squared, 1};
}

std::vector<Point> joint_points(int joints) {
  std::vector<Point> points;
  points.reserve(static_cast<size_t>(joints));
  for (int j = 0; j < joints; ++j) points.push_back({Attachment{j, 1, Vector3d::Zero()}});
  return points;
}

Vector3d place_of(const Point& point, const BonesPose& pose) {
  Vector3d place = Vector3d::Zero();
  for (const Attachment& a : point) {
    Vector3d at = pose.positions[a.joint];
    if (!a.offset.isZero()) at += pose.rotations[a.joint] * a.offset;
    place += a.weight * at;
  }
  return place;
}

int coupling(const Problem& problem) {
  int band = problem.holds.empty() ? 0 : 1;
  for (const Smoothness& s : problem.smoothness)
    if (s.positions > 0 || s.rotations > 0) band = std::max(band, s.order);
  return band;
}

Unknowns unknowns_of(const Problem& problem) {
  const int joints = problem.bones.size();
  std::vector<char> moves(static_cast<size_t>(joints), 0);
  const auto uses = [&](const Point& point) {
    for (const Attachment& a : point)
      for (int j = a.offset.isZero() ? problem.bones.parents[a.joint] : a.joint; j >= 0; j = problem.bones.parents[j])
        moves[static_cast<size_t>(j)] = 1;
  };
  for (const int core : core_points(problem)) uses(problem.points[static_cast<size_t>(core)]);
  for (const PlaceTerm& p : problem.places) uses(problem.points[static_cast<size_t>(p.point)]);
  for (const PlaneTerm& p : problem.planes) uses(problem.points[static_cast<size_t>(p.point)]);
  if (problem.depth)
    for (const Skin::Weight& w : problem.depth->skin->weights)
      for (int j = w.joint; j >= 0 && moves[static_cast<size_t>(j)] == 0; j = problem.bones.parents[j])
        moves[static_cast<size_t>(j)] = 1;
  Unknowns out;
  out.columns = {problem.moves ? 3 : 0};
  if (problem.moves) out.root = 0;
  for (int j = 0; j < joints; ++j) {
    if (!problem.rotates.empty() && problem.rotates[static_cast<size_t>(j)] == 0) {
      out.rotations.push_back({-1, -1});
      continue;
    }
    if (moves[static_cast<size_t>(j)]) {
      out.rotations.push_back({Unknowns::kMain, out.columns[Unknowns::kMain]});
      out.columns[Unknowns::kMain] += 3;
    } else {
      out.rotations.push_back({static_cast<int>(out.columns.size()), 0});
      out.columns.push_back(3);
    }
  }
  return out;
}

NormalEquations make_equations(const Problem& problem, const Unknowns& unknowns) {
  const int64_t frames = problem.frames();
  const int band = coupling(problem);
  NormalEquations out;
  for (const int columns : unknowns.columns) {
    out.matrices.emplace_back(frames, columns, band);
    out.gradients.push_back(VectorXd::Zero(frames * columns));
  }
  return out;
}

double cost_of(const Problem& problem, const Trajectory& trajectory) {
  const std::vector<int> core = core_points(problem);
  const std::vector<BonesPose> poses = poses_of(problem, trajectory);
  const std::vector<FrameTerms> terms = by_frame(problem);
  double cost =
      RotationTerms(problem, nullptr, trajectory, nullptr).add() +
      add_place_differences(problem, core, places_of(problem, core, poses), start_places(problem, core), nullptr);
  const int64_t frames = problem.frames();
  // In parts of their own, so that the sum does not depend on the number of threads.
  std::vector<double> parts(static_cast<size_t>(frames), 0);
#pragma omp parallel for num_threads(at::get_num_threads()) schedule(static)
  for (int64_t t = 0; t < frames; ++t) {
    FrameRows rows;
    add_frame_rows(problem, nullptr, terms[t], poses[t], {}, rows);
    if (problem.depth && !is_fixed(problem, t))
      add_depth_rows(problem, nullptr, t, trajectory[t], poses[t], rows.values, rows.residuals, rows.cost);
    parts[t] = rows.cost;
  }
  for (const double part : parts) cost += part;
  return cost;
}

double linearise(const Problem& problem, const Unknowns& unknowns, const Trajectory& trajectory, NormalEquations& out) {
  const int64_t frames = problem.frames();
  const std::vector<int> core = core_points(problem);
  const std::vector<FrameTerms> terms = by_frame(problem);
  const int rows = static_cast<int>(3 * core.size()), columns = unknowns.columns[0], band = out.matrices[0].band();
  for (size_t i = 1; i < out.matrices.size(); ++i) out.matrices[i].clear();
  for (VectorXd& gradient : out.gradients) gradient.setZero();
  const std::vector<BonesPose> poses = poses_of(problem, trajectory);
  PlaceEquations places(frames, rows, band);
  double cost =
      add_place_differences(problem, core, places_of(problem, core, poses), start_places(problem, core), &places);

  BlockBand& matrix = out.matrices[0];
  const int64_t padded = matrix.padded();
  using ByRow = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<double> jacobians(static_cast<size_t>(frames * rows * padded), 0.0);
  const auto jacobian_of = [&](int64_t t) { return jacobians.data() + t * rows * padded; };
  std::vector<FrameRows> own(static_cast<size_t>(frames));
#pragma omp parallel for num_threads(at::get_num_threads()) schedule(static)
  for (int64_t t = 0; t < frames; ++t) {
    const std::vector<Matrix3d> rotations = matrices_of(poses[t]);
    Eigen::Map<ByRow, 0, Eigen::OuterStride<>> jacobian(jacobian_of(t), rows, columns, Eigen::OuterStride<>(padded));
    for (size_t i = 0; i < core.size(); ++i)
      point_jacobian(problem, unknowns, problem.points[static_cast<size_t>(core[i])], poses[t], rotations,
                     jacobian.middleRows<3>(static_cast<Eigen::Index>(3 * i)));
    add_frame_rows(problem, &unknowns, terms[t], poses[t], rotations, own[t]);
    if (problem.depth && !is_fixed(problem, t))
      add_depth_rows(problem, &unknowns, t, trajectory[t], poses[t], own[t].values, own[t].residuals, own[t].cost);
    const auto count = static_cast<Eigen::Index>(own[t].residuals.size());
    auto gradient = out.gradients[0].segment(t * columns, columns);
    gradient.noalias() += jacobian.transpose() * places.gradient[t];
    gradient.noalias() += Eigen::Map<const ByRow>(own[t].values.data(), count, columns).transpose() *
                          Eigen::Map<const VectorXd>(own[t].residuals.data(), count);
  }
  for (const FrameRows& frame : own) cost += frame.cost;
#pragma omp parallel num_threads(at::get_num_threads())
  {
    std::vector<double> scratch;
#pragma omp for schedule(static)
    for (int64_t t = 0; t < frames; ++t)
      fill_panel(places.weights[t], jacobian_of(t), rows, columns, own[t], t, matrix, scratch);
  }
  cost += RotationTerms(problem, &unknowns, trajectory, &out).add();
  hold_fixed(problem, out);
  return cost;
}

}  // namespace inhabit::refine
