#include "inhabit/refine/solve.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/interruption.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/refine/depth_terms.h"
#include "inhabit/refine/terms.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLeastPart = 0.01;  // of a step

void require(bool good, const char* what) {
  if (!good) throw Error("refine", what);
}

void check(const Problem& problem) {
  const size_t joints = problem.bones.parents.size(), frames = problem.start.size();
  require(frames > 0 && joints > 0, "no frames or no joints");
  require(problem.fixed.empty() || problem.fixed.size() == frames, "fixed frames: not one number a frame");
  require(problem.rotates.empty() || problem.rotates.size() == joints, "unknown rotations: not one number a joint");
  require(problem.points.size() >= joints, "the first points are not the joints");
  const StayNear& near = problem.stay_near;
  require(near.rotations.empty() || near.rotations.size() == frames * joints, "weights: not one a frame and joint");
  require(near.root.empty() || near.root.size() == frames, "weights of the root: not one a frame");
  const JointLimits& limits = problem.limits;
  require(limits.low.size() == limits.high.size() && (limits.low.empty() || limits.low.size() == joints),
          "limits: not one a joint");
  require(problem.initial.empty() || problem.initial.size() == frames, "the beginning has other frames");
  require(near.to.empty() || near.to.size() == frames, "what to stay near to has other frames");
  for (const Trajectory* trajectory : {&problem.start, &problem.initial, &near.to})
    for (const FramePose& pose : *trajectory) {
      require(pose.local.size() == joints, "rotations: not one a joint");
      require(pose.trans.allFinite(), "a translation is not finite");
      for (const Eigen::Quaterniond& q : pose.local) require(q.coeffs().allFinite(), "a rotation is not finite");
    }
  if (problem.depth) {
    require(problem.depth->clouds.size() == frames, "depth: not one cloud a frame");
    require(joints == kStandardJoints && problem.depth->skin, "depth: no skin on the standard joints");
  }
  for (const Smoothness& s : problem.smoothness) {
    require(s.order >= 1 && s.order <= 3, "smoothness is of order 1, 2 or 3");
    require(s.joints.empty() || s.joints.size() == joints, "smoothness: not one factor a joint");
  }
  const auto points = static_cast<int>(problem.points.size());
  const auto in_frames = [&](int64_t frame, int64_t more) {
    return frame >= 0 && frame + more < static_cast<int64_t>(frames);
  };
  const auto known = [&](const auto& terms, int64_t more) {
    for (const auto& t : terms)
      require(in_frames(t.frame, more) && t.point >= 0 && t.point < points, "a term is of no frame or point");
  };
  known(problem.places, 0);
  known(problem.holds, 1);
  known(problem.planes, 0);
  for (const PlaceTerm& p : problem.places)
    require(p.target.allFinite() && p.weight.allFinite(), "a target is not finite");
}

/// `from` after `part` of a step.
Trajectory moved(const Problem& problem, const Unknowns& unknowns, const Trajectory& from,
                 const std::vector<VectorXd>& step, double part) {
  Trajectory out = from;
  for (size_t t = 0; t < out.size(); ++t) {
    if (!problem.fixed.empty() && problem.fixed[t] != 0) continue;
    const auto at = [&](int system, int column) -> Vector3d {
      return part * step[system].segment<3>(static_cast<Eigen::Index>(t) * unknowns.columns[system] + column);
    };
    for (size_t j = 0; j < out[t].local.size(); ++j) {
      const auto [system, column] = unknowns.rotations[j];
      if (system < 0) continue;
      Eigen::Quaterniond& q = out[t].local[j];
      q = (q * quaternion_of(at(system, column))).normalized();
    }
    if (unknowns.root >= 0) out[t].trans += at(0, unknowns.root);
  }
  return out;
}

/// The step of one system; false where its matrix is not positive definite.
bool damped_step(const Problem& problem, const Unknowns& unknowns, const NormalEquations& equations, int system,
                 double damping, BlockBand& matrix, VectorXd& step) {
  step = -equations.gradients[static_cast<size_t>(system)];
  const auto fill = [&](int64_t frame) {
    fill_frame(problem, unknowns, equations, system, frame, matrix);
    BlockBand::Block block = matrix.at(frame, 0);
    block.diagonal().array() += damping * block.diagonal().array() + 1e-9;
  };
  return step.size() == 0 || matrix.solve(fill, step);
}

}  // namespace

Solution solve(const Problem& problem, const SolveOptions& options) {
  check(problem);
  const Unknowns unknowns = unknowns_of(problem);
  NormalEquations equations;
  std::vector<BlockBand> matrices;
  for (const int columns : unknowns.columns) matrices.emplace_back(problem.frames(), columns, coupling(problem));
  Solution out{problem.initial.empty() ? problem.start : problem.initial, 0, 0, 0};
  double damping = 1e-6;
  for (int round = 0; round < options.iterations && damping < 1e6; ++round) {
    interruption_point();
    out.cost = linearise(problem, unknowns, out.trajectory, equations);
    require(std::isfinite(out.cost), "the cost is not finite");
    if (round == 0) out.start_cost = out.cost;
    if (out.cost == 0) break;  // no term asks for anything
    std::vector<VectorXd> step(matrices.size());
    std::vector<char> good(matrices.size(), 1);
    const auto find = [&](size_t i) {
      good[i] = damped_step(problem, unknowns, equations, static_cast<int>(i), damping, matrices[i], step[i]) ? 1 : 0;
    };
    find(0);  // on two threads
#pragma omp parallel for num_threads(at::get_num_threads()) schedule(static)
    for (size_t i = 1; i < step.size(); ++i) find(i);  // small: a thread each
    const bool solved = std::all_of(good.begin(), good.end(), [](char each) { return each != 0; });
    // Where one-sided terms set in along the way, a whole step leads too far, and a part of it is dearer to find by
    // more damping than by trying.
    Trajectory trial;
    double next = out.cost;
    for (double part = 1; solved && part > kLeastPart && !(next < out.cost); part *= 0.5) {
      trial = moved(problem, unknowns, out.trajectory, step, part);
      next = cost_of(problem, trial);
    }
    if (!(next < out.cost)) {
      damping *= 1000;
      continue;
    }
    const bool small = out.cost - next < options.tolerance * out.cost;
    damping = std::max(1e-9, damping * 0.1);
    out.trajectory = std::move(trial);
    out.cost = next;
    ++out.iterations;
    if (small) break;
  }
  return out;
}

}  // namespace inhabit::refine
