#include "inhabit/refine/terms.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "inhabit/math/panel_kernel.h"
#include "inhabit/refine/depth_terms.h"
#include "inhabit/refine/trajectory.h"

namespace inhabit::refine {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

bool is_fixed(const Problem& problem, int64_t frame) {
  return !problem.fixed.empty() && problem.fixed[static_cast<size_t>(frame)] != 0;
}

/// Points whose places enter differences in time: the joints, and points of HoldTerm.
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

/// Differences in time of places. @param equations null: the cost alone
double add_place_differences(const Problem& problem, const std::vector<int>& core, const MatrixXd& places,
                             const MatrixXd& start, PlaceEquations* equations) {
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
          r += c[n] * places.col(t + n).segment<3>(row);
          if (s.of_change) r -= c[n] * start.col(t + n).segment<3>(row);
        }
        const Weighted w = weighted(s.loss, per * r.squaredNorm());
        cost += weight * w.cost;
        if (equations == nullptr) continue;
        const double factor = weight * w.factor * per;
        for (int n = 0; n <= s.order; ++n) {
          equations->gradient.col(t + n).segment<3>(row) += factor * c[n] * r;
          for (int m = 0; m <= n; ++m) equations->add(t + m, n - m, row, Vector3d::Constant(factor * c[n] * c[m]));
        }
      }
  }
  std::vector<int> row_of(problem.points.size(), -1);
  for (size_t i = 0; i < core.size(); ++i) row_of[static_cast<size_t>(core[i])] = static_cast<int>(3 * i);
  for (const HoldTerm& h : problem.holds) {
    const int row = row_of[static_cast<size_t>(h.point)];
    const Vector3d r = places.col(h.frame + 1).segment<3>(row) - places.col(h.frame).segment<3>(row);
    const Vector3d force = h.weight.cwiseProduct(r);
    cost += 0.5 * force.dot(r);
    if (equations == nullptr) continue;
    equations->gradient.col(h.frame + 1).segment<3>(row) += force;
    equations->gradient.col(h.frame).segment<3>(row) -= force;
    equations->add(h.frame, 0, row, h.weight);
    equations->add(h.frame + 1, 0, row, h.weight);
    equations->add(h.frame, 1, row, -h.weight);
  }
  return cost;
}

/// Adds scale . direction . (d place / d unknowns of the main system) to a row.
void add_point_row(const Problem& problem, const Unknowns& unknowns, const Point& point, const BonesPose& pose,
                   const std::vector<Matrix3d>& rotations, const Vector3d& direction, double scale, double* row) {
  for (const Attachment& a : point) {
    const Vector3d at = pose.positions[a.joint] + rotations[a.joint] * a.offset, along = a.weight * scale * direction;
    for (int j = a.joint; j >= 0; j = problem.bones.parents[j]) {
      const auto [system, column] = unknowns.rotations[j];
      if (system != Unknowns::kMain) continue;
      // direction . (R_i x arm) = R_i . (arm x direction)
      Eigen::Map<Vector3d>(row + column) += rotations[j].transpose() * (at - pose.positions[j]).cross(along);
    }
    if (unknowns.root >= 0) Eigen::Map<Vector3d>(row + unknowns.root) += along;
  }
}

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
  out.limbs.clear();
  out.cost = 0;
  // A row of the Jacobian and a residual along `direction`, both times the root of the weight.
  const auto add = [&](const Point& point, const Vector3d& direction, double residual, double weight) {
    const double root = std::sqrt(weight);
    const size_t begin = out.values.size();
    out.values.resize(begin + static_cast<size_t>(unknowns->columns[Unknowns::kMain]), 0.0);
    add_point_row(problem, *unknowns, point, pose, rotations, direction, root, out.values.data() + begin);
    out.residuals.push_back(root * residual);
    out.limbs.push_back(unknowns->limb_of_point(point));
  };
  for (const PlaceTerm* term : terms.places) {
    const Point& point = problem.points[static_cast<size_t>(term->point)];
    const Vector3d r = place_of(point, pose) - term->target;
    const Weighted w = weighted(term->loss, r.cwiseProduct(term->weight).dot(r));
    out.cost += w.cost;
    if (unknowns == nullptr) continue;
    for (int i = 0; i < 3; ++i)
      if (term->weight[i] > 0) add(point, Vector3d::Unit(i), r[i], w.factor * term->weight[i]);
  }
  for (const PlaneTerm* term : terms.planes) {
    const Point& point = problem.points[static_cast<size_t>(term->point)];
    const double r = term->normal.dot(place_of(point, pose)) - term->height;
    if (r >= 0 && !term->on_it) continue;
    out.cost += 0.5 * term->weight * r * r;
    if (unknowns == nullptr) continue;
    add(point, term->normal, r, term->weight);
  }
}

MatrixXd places_of(const Problem& problem, const std::vector<int>& core, const Poses& poses) {
  MatrixXd places(3 * core.size(), poses.size());
  for (size_t t = 0; t < poses.size(); ++t)
    for (size_t i = 0; i < core.size(); ++i)
      places.col(static_cast<Eigen::Index>(t)).segment<3>(static_cast<Eigen::Index>(3 * i)) =
          place_of(problem.points[static_cast<size_t>(core[i])], poses[t]);
  return places;
}

MatrixXd start_places(const Problem& problem, const std::vector<int>& core) {
  for (const Smoothness& s : problem.smoothness)
    if (s.of_change && s.positions > 0) return places_of(problem, core, posed(problem.bones, problem.start));
  return {};
}

std::vector<Matrix3d> matrices_of(const BonesPose& pose) {
  std::vector<Matrix3d> out;
  out.reserve(pose.rotations.size());
  for (const Eigen::Quaterniond& q : pose.rotations) out.push_back(q.toRotationMatrix());
  return out;
}

/// Rotations' terms (those of `linear` with their equations), and the root's distance from where it is to stay.
double add_near(const Problem& problem, const Trajectory& trajectory, const std::vector<char>& linear,
                std::vector<RotationEquations>& out) {
  add_rotation_terms(problem, trajectory, linear, out);
  double cost = 0;
  for (const RotationEquations& joint : out) cost += joint.cost;
  const Trajectory& near = problem.near_to();
  for (size_t t = 0; t < problem.stay_near.root.size(); ++t)
    cost += 0.5 * problem.stay_near.root[t] * (trajectory[t].trans - near[t].trans).squaredNorm();
  return cost;
}

/// The same as gradients.
void add_near_gradients(const Problem& problem, const Unknowns& unknowns, const Trajectory& trajectory,
                        NormalEquations& out) {
  const Trajectory& near = problem.near_to();
  for (size_t j = 0; j < out.rotations.size(); ++j) {
    const auto [system, column] = unknowns.rotations[j];
    if (system < 0) continue;
    for (int64_t t = 0; t < problem.frames(); ++t)
      out.gradients[system].segment<3>(t * unknowns.columns[system] + column) += out.rotations[j].gradient[t];
  }
  if (unknowns.root < 0) return;
  for (size_t t = 0; t < problem.stay_near.root.size(); ++t)
    out.gradients[0].segment<3>(static_cast<int64_t>(t) * unknowns.columns[0] + unknowns.root) +=
        problem.stay_near.root[t] * (trajectory[t].trans - near[t].trans);
}

/// Products of a limb's rows, in its columns alone: a frame's panel is the sum of what its limbs add.
struct LimbProducts {
  const std::vector<int>& columns;
  int64_t padded, wide;       ///< numbers of a part of a row, and of a row: [-a, b_0, b_1 ...], zeros behind each part
  std::vector<double>& rows;  ///< as many as were begun
  int64_t count = 0;

  LimbProducts(const std::vector<int>& of, int64_t parts, std::vector<double>& scratch)
      : columns(of), padded(padded_to_panel(static_cast<int64_t>(of.size()))), wide(padded * parts), rows(scratch) {
    rows.clear();
  }
  void begin_row() { rows.resize(static_cast<size_t>(++count * wide), 0.0); }
  /// A part of the row begun last: `weight` times the limb's columns of `from`.
  void set(int64_t part, const double* from, double weight) {
    double* to = rows.data() + (count - 1) * wide + part * padded;
    for (size_t i = 0; i < columns.size(); ++i) to[i] = weight * from[columns[i]];
  }
  /// Adds aᵀ b_k to the blocks of a frame. @param sums scratch
  void add_to(BlockBand& matrix, int64_t frame, std::vector<double>& sums) const {
    if (count == 0 || columns.empty()) return;
    const auto size = static_cast<int64_t>(columns.size());
    const int64_t stride = wide - padded, blocks = stride / padded;
    sums.assign(static_cast<size_t>(size * stride), 0.0);
    const double* a = rows.data();
    subtract_products(a, a + padded, wide, count, sums.data(), stride, size, padded, true);
    subtract_products(a, a + 2 * padded, wide, count, sums.data() + padded, stride, size, stride - padded, false);
    for (int64_t i = 0; i < size; ++i) {
      const double* from = sums.data() + i * stride;
      double* to = matrix.panel(frame) + columns[static_cast<size_t>(i)] * matrix.stride();
      for (int64_t k = 0; k < blocks; ++k, from += padded, to += matrix.padded())
        for (int64_t j = k == 0 ? i : 0; j < size; ++j) to[columns[static_cast<size_t>(j)]] += from[j];
    }
  }
};

/// J_tᵀ W J_t+k of the core points for every k, where any weight is not 0, in a frame's panel of the main system.
void add_places(const Unknowns& unknowns, const NormalEquations& equations, int64_t t, BlockBand& matrix) {
  thread_local std::vector<double> scratch, sums;
  const int64_t rows = equations.places.gradient.rows(), padded = matrix.padded(),
                reach = std::min<int64_t>(matrix.band(), matrix.frames() - 1 - t);
  for (size_t limb = 0; limb < unknowns.limbs.size(); ++limb) {
    LimbProducts products(unknowns.limbs[limb], reach + 2, scratch);
    for (int64_t r = 0; r < rows; ++r) {
      if (equations.place_limbs[static_cast<size_t>(r)] != static_cast<int>(limb)) continue;
      bool any = false;
      for (int64_t k = 0; k <= reach; ++k) any = any || equations.places.weights[static_cast<size_t>(k)](r, t) != 0;
      if (!any) continue;
      const double* own = equations.jacobians.data() + (t * rows + r) * padded;
      products.begin_row();
      products.set(0, own, -1);
      for (int64_t k = 0; k <= reach; ++k)
        products.set(k + 1, own + k * rows * padded, equations.places.weights[static_cast<size_t>(k)](r, t));
    }
    products.add_to(matrix, t, sums);
  }
}

/// aᵀ a of a frame's own rows a.
void add_own(const Unknowns& unknowns, const FrameRows& own, int64_t t, BlockBand& matrix) {
  thread_local std::vector<double> scratch, sums;
  for (size_t limb = 0; limb < unknowns.limbs.size(); ++limb) {
    LimbProducts products(unknowns.limbs[limb], 2, scratch);
    for (size_t r = 0; r < own.limbs.size(); ++r) {
      if (own.limbs[r] != static_cast<int>(limb)) continue;
      const double* row = own.values.data() + r * static_cast<size_t>(matrix.block());
      products.begin_row();
      products.set(0, row, -1);
      products.set(1, row, 1);
    }
    products.add_to(matrix, t, sums);
  }
}

/// The columns that move each limb's points.
void find_limbs(const Problem& problem, Unknowns& out) {
  const std::vector<int>& parents = problem.bones.parents;
  const auto joints = parents.size();
  std::vector<int> children(joints, 0);
  for (size_t j = 0; j < joints; ++j)
    if (parents[j] >= 0) ++children[static_cast<size_t>(parents[j])];
  std::vector<size_t> last;  // joint of each limb
  out.limb_of.resize(joints);
  for (size_t j = 0; j < joints; ++j) {
    const bool goes_on = parents[j] >= 0 && children[static_cast<size_t>(parents[j])] == 1;
    out.limb_of[j] = goes_on ? out.limb_of[static_cast<size_t>(parents[j])] : static_cast<int>(last.size());
    if (!goes_on) last.emplace_back();
    last[static_cast<size_t>(out.limb_of[j])] = j;
  }
  for (const size_t end : last) {
    std::vector<int>& columns = out.limbs.emplace_back();
    const auto add = [&](int column) {
      for (int i = 0; column >= 0 && i < 3; ++i) columns.push_back(column + i);
    };
    add(out.root);
    for (int j = static_cast<int>(end); j >= 0; j = parents[static_cast<size_t>(j)]) {
      const auto [system, column] = out.rotations[static_cast<size_t>(j)];
      if (system == Unknowns::kMain) add(column);
    }
    std::sort(columns.begin(), columns.end());
  }
  std::vector<int>& all = out.limbs.emplace_back(static_cast<size_t>(out.columns[Unknowns::kMain]));
  std::iota(all.begin(), all.end(), 0);
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
  find_limbs(problem, out);
  return out;
}

double cost_of(const Problem& problem, const Trajectory& trajectory) {
  const std::vector<int> core = core_points(problem);
  const Poses poses = posed(problem.bones, trajectory);
  const std::vector<FrameTerms> terms = by_frame(problem);
  std::vector<RotationEquations> rotations;
  double cost =
      add_near(problem, trajectory, std::vector<char>(static_cast<size_t>(problem.bones.size()), 0), rotations) +
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
  const Poses poses = posed(problem.bones, trajectory);
  const int64_t rows = static_cast<int64_t>(3 * core.size()), columns = unknowns.columns[0],
                padded = padded_to_panel(columns);
  out.gradients.resize(unknowns.columns.size());
  for (size_t i = 0; i < out.gradients.size(); ++i) out.gradients[i].setZero(frames * unknowns.columns[i]);
  out.places.gradient.setZero(rows, frames);
  for (int k = 0; k <= coupling(problem); ++k) out.places.weights[static_cast<size_t>(k)].setZero(rows, frames);
  double cost =
      add_place_differences(problem, core, places_of(problem, core, poses), start_places(problem, core), &out.places);

  out.jacobians.resize(static_cast<size_t>(frames * rows * padded));
  out.own.resize(static_cast<size_t>(frames));
  out.place_limbs.resize(static_cast<size_t>(rows));
  for (int64_t row = 0; row < rows; ++row)
    out.place_limbs[static_cast<size_t>(row)] =
        unknowns.limb_of_point(problem.points[static_cast<size_t>(core[static_cast<size_t>(row / 3)])]);
  using ByRow = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
#pragma omp parallel for num_threads(at::get_num_threads()) schedule(static)
  for (int64_t t = 0; t < frames; ++t) {
    const std::vector<Matrix3d> rotations = matrices_of(poses[t]);
    FrameRows& own = out.own[static_cast<size_t>(t)];
    double* places = out.jacobians.data() + t * rows * padded;
    std::fill_n(places, rows * padded, 0.0);
    for (int64_t row = 0; row < rows; ++row)
      add_point_row(problem, unknowns, problem.points[static_cast<size_t>(core[static_cast<size_t>(row / 3)])],
                    poses[t], rotations, Vector3d::Unit(row % 3), 1, places + row * padded);
    const Eigen::Map<const ByRow, 0, Eigen::OuterStride<>> jacobian(places, rows, columns,
                                                                    Eigen::OuterStride<>(padded));
    add_frame_rows(problem, &unknowns, terms[t], poses[t], rotations, own);
    if (problem.depth && !is_fixed(problem, t))
      add_depth_rows(problem, &unknowns, t, trajectory[t], poses[t], own.values, own.residuals, own.cost);
    const auto count = static_cast<Eigen::Index>(own.residuals.size());
    own.limbs.resize(own.residuals.size(), static_cast<int>(unknowns.limbs.size()) - 1);  // skin moves with many joints
    auto gradient = out.gradients[0].segment(t * columns, columns);
    gradient.noalias() += jacobian.transpose() * out.places.gradient.col(t);
    gradient.noalias() += Eigen::Map<const ByRow>(own.values.data(), count, columns).transpose() *
                          Eigen::Map<const VectorXd>(own.residuals.data(), count);
  }
  for (const FrameRows& frame : out.own) cost += frame.cost;
  std::vector<char> linear;
  for (const auto& [system, column] : unknowns.rotations) linear.push_back(system >= 0 ? 1 : 0);
  cost += add_near(problem, trajectory, linear, out.rotations);
  add_near_gradients(problem, unknowns, trajectory, out);
  // What is known does not move.
  for (int64_t t = 0; t < frames; ++t)
    for (size_t i = 0; is_fixed(problem, t) && i < out.gradients.size(); ++i)
      out.gradients[i].segment(t * unknowns.columns[i], unknowns.columns[i]).setZero();
  return cost;
}

void fill_frame(const Problem& problem, const Unknowns& unknowns, const NormalEquations& equations, int system,
                int64_t frame, BlockBand& matrix) {
  matrix.clear(frame);
  if (is_fixed(problem, frame)) {
    matrix.at(frame, 0).setIdentity();
    return;
  }
  if (system == Unknowns::kMain) {
    add_places(unknowns, equations, frame, matrix);
    add_own(unknowns, equations.own[static_cast<size_t>(frame)], frame, matrix);
    if (unknowns.root >= 0 && !problem.stay_near.root.empty())
      matrix.at(frame, 0).diagonal().segment<3>(unknowns.root).array() += problem.stay_near.root[frame];
  }
  const auto reach = static_cast<int>(std::min<int64_t>(matrix.band(), matrix.frames() - 1 - frame));
  for (size_t j = 0; j < equations.rotations.size(); ++j) {
    const auto [of, column] = unknowns.rotations[j];
    if (of != system) continue;
    for (int apart = 0; apart <= reach; ++apart)
      matrix.at(frame, apart).block<3, 3>(column, column) += equations.rotations[j].blocks[frame][apart];
  }
  for (int apart = 1; apart <= reach; ++apart)
    if (is_fixed(problem, frame + apart)) matrix.at(frame, apart).setZero();
}

}  // namespace inhabit::refine
