// Protects the trajectory solver: its equations and its Jacobians against finite differences, and each term against
// what it must come to in closed form.
#include "inhabit/refine/solve.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "dense_band.h"
#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/refine/terms.h"

namespace inhabit::refine {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

std::vector<Vector3d> normals(std::mt19937_64& random, size_t count) {
  std::normal_distribution<double> normal;
  std::vector<Vector3d> out(count);
  for (Vector3d& v : out)
    for (double& x : v) x = normal(random);
  return out;
}

/// The built-in body in poses drawn around bent ones.
Trajectory random_trajectory(int64_t frames, double spread, uint64_t seed) {
  std::mt19937_64 random(seed);
  Trajectory out(static_cast<size_t>(frames));
  const std::vector<Vector3d> base = normals(random, kStandardJoints);
  for (FramePose& pose : out) {
    const std::vector<Vector3d> v = normals(random, kStandardJoints + 1);
    for (int j = 0; j < kStandardJoints; ++j)
      pose.local.push_back(quaternion_of(Vector3d(0.4 * base[j] + spread * v[j])));
    pose.trans = spread * v.back();
  }
  return out;
}

Problem problem_of(const Trajectory& start) {
  Problem problem;
  problem.bones = bones_of(builtin_body().skeleton);
  problem.points = joint_points(kStandardJoints);
  problem.start = start;
  return problem;
}

std::vector<BonesPose> posed(const Problem& problem, const Trajectory& trajectory) {
  std::vector<BonesPose> out(trajectory.size());
  for (size_t t = 0; t < trajectory.size(); ++t)
    pose_bones(problem.bones, trajectory[t].local, trajectory[t].trans, out[t]);
  return out;
}

Trajectory stepped(const Unknowns& unknowns, const Trajectory& from, int system, int64_t index, double by) {
  Trajectory out = from;
  const int64_t frame = index / unknowns.columns[system], column = index % unknowns.columns[system];
  FramePose& pose = out[static_cast<size_t>(frame)];
  if (system == 0 && unknowns.root >= 0 && column - unknowns.root < 3 && column >= unknowns.root)
    pose.trans[column - unknowns.root] += by;
  for (size_t j = 0; j < pose.local.size(); ++j) {
    const auto [where, first] = unknowns.rotations[j];
    if (where != system || column < first || column >= first + 3) continue;
    Vector3d d = Vector3d::Zero();
    d[column - first] = by;
    pose.local[j] = pose.local[j] * quaternion_of(d);
  }
  return out;
}

/// A problem with every kind of term, none of them at its least.
Problem everything(int64_t frames) {
  Problem problem = problem_of(random_trajectory(frames, 0.05, 3));
  std::mt19937_64 random(4);
  problem.points.push_back({Attachment{10, 1, Vector3d(0.01, -0.02, 0.08)}});
  problem.points.push_back({Attachment{4, 0.3, Vector3d(0, -0.1, 0.05)}, Attachment{1, 0.7, Vector3d(0.02, -0.4, 0)}});
  problem.stay_near.rotations.assign(static_cast<size_t>(frames) * kStandardJoints, 2.0);
  problem.stay_near.root.assign(static_cast<size_t>(frames), 3.0);
  problem.smoothness.push_back({1, 1e-2, 2e-2, {}, false, {}});
  problem.smoothness.push_back({2, 3e-5, 1e-5, {Loss::Kind::huber, 20}, false, {}});
  problem.smoothness.push_back({3, 1e-7, 1e-8, {}, true, std::vector<double>(kStandardJoints, 0.5)});
  problem.smoothness.push_back({2, 1e-4, 1e-4, {Loss::Kind::norm, 1}, false, {}});
  for (int64_t t = 0; t < frames; ++t) {
    problem.places.push_back({t, 20, normals(random, 1)[0], Vector3d(5, 0, 7), {}});
    problem.places.push_back({t, 23, normals(random, 1)[0], Vector3d(1, 2, 3), {Loss::Kind::huber, 0.1}});
    problem.planes.push_back({t, 22, Vector3d(0.6, 0.8, 0), 0.5, 4, false});
    problem.planes.push_back({t, 19, Vector3d::UnitZ(), -0.1, 6, true});
    problem.planes.push_back({t, 5, Vector3d::UnitY(), -5, 6, false});  // far on its outer side
    if (t + 1 < frames) problem.holds.push_back({t, 22, Vector3d(8, 3, 8)});
  }
  problem.limits.low.assign(kStandardJoints, Vector3d::Constant(-0.2));
  problem.limits.high.assign(kStandardJoints, Vector3d::Constant(0.3));
  problem.limit_weight = 4;
  return problem;
}

TEST(Terms, GradientIsThatOfTheCost) {
  const Problem problem = everything(6);
  const Unknowns unknowns = unknowns_of(problem);
  const Trajectory at = random_trajectory(6, 0.07, 8);
  NormalEquations equations;
  const double cost = linearise(problem, unknowns, at, equations);
  EXPECT_NEAR(cost, cost_of(problem, at), 1e-9 * cost);
  ASSERT_GT(unknowns.columns.size(), 2U) << "some joints move no point";
  constexpr double kStep = 1e-6;
  for (int system = 0; system < static_cast<int>(unknowns.columns.size()); ++system)
    for (int64_t i = 0; i < equations.gradients[system].size(); ++i) {
      const double numeric = (cost_of(problem, stepped(unknowns, at, system, i, kStep)) -
                              cost_of(problem, stepped(unknowns, at, system, i, -kStep))) /
                             (2 * kStep);
      EXPECT_NEAR(equations.gradients[system][i], numeric, 1e-5 * (1 + std::abs(numeric))) << system << " " << i;
    }
}

TEST(Terms, EquationsAreThoseOfTheResiduals) {
  // Where residuals vanish the Gauss-Newton matrix is the cost's own second derivative.
  Problem problem = problem_of(random_trajectory(5, 0.05, 3));
  problem.stay_near.rotations.assign(5 * kStandardJoints, 2.0);
  problem.stay_near.root.assign(5, 3.0);
  problem.smoothness.push_back({3, 1e-7, 1e-7, {}, true, {}});
  problem.smoothness.push_back({1, 1e-3, 1e-3, {}, true, {}});
  const std::vector<BonesPose> poses = posed(problem, problem.start);
  for (int64_t t = 0; t < 5; ++t) problem.places.push_back({t, 20, poses[t].positions[20], Vector3d(5, 6, 7), {}});
  const Unknowns unknowns = unknowns_of(problem);
  NormalEquations equations, beside;
  ASSERT_LT(linearise(problem, unknowns, problem.start, equations), 1e-12);
  constexpr double kStep = 1e-5;
  for (int system = 0; system < static_cast<int>(unknowns.columns.size()); ++system) {
    BlockBand band(problem.frames(), unknowns.columns[static_cast<size_t>(system)], coupling(problem));
    for (int64_t t = 0; t < problem.frames(); ++t) fill_frame(problem, unknowns, equations, system, t, band);
    const MatrixXd matrix = dense(band);
    for (int64_t i = 0; i < matrix.cols(); i += 7) {
      linearise(problem, unknowns, stepped(unknowns, problem.start, system, i, kStep), beside);
      const VectorXd up = beside.gradients[system];
      linearise(problem, unknowns, stepped(unknowns, problem.start, system, i, -kStep), beside);
      const VectorXd column = (up - beside.gradients[system]) / (2 * kStep);
      EXPECT_LT((column - matrix.col(i)).norm(), 1e-4 * (1 + column.norm())) << system << " " << i;
    }
  }
}

TEST(Solve, LessensTheCostToWhereItsGradientVanishes) {
  const Problem problem = everything(12);
  const Solution solution = solve(problem, {200, 1e-14});
  EXPECT_LT(solution.cost, 0.8 * solution.start_cost);
  const Unknowns unknowns = unknowns_of(problem);
  NormalEquations equations;
  linearise(problem, unknowns, problem.start, equations);
  std::vector<double> before;
  for (const VectorXd& gradient : equations.gradients) before.push_back(gradient.norm());
  linearise(problem, unknowns, solution.trajectory, equations);
  for (size_t i = 0; i < before.size(); ++i) EXPECT_LT(equations.gradients[i].norm(), 1e-3 * before[i]) << i;
}

TEST(Solve, AConstantVelocityIsSmoothAlready) {
  Trajectory start(30, random_trajectory(1, 0, 2)[0]);
  for (size_t t = 0; t < start.size(); ++t) start[t].trans += Vector3d(0.02, 0, -0.01) * static_cast<double>(t);
  Problem problem = problem_of(start);
  problem.smoothness.push_back({2, 1, 1, {}, false, {}});
  const Solution solution = solve(problem);
  for (size_t t = 0; t < start.size(); ++t) EXPECT_LT((solution.trajectory[t].trans - start[t].trans).norm(), 1e-8);
}

TEST(Solve, FixedFramesAreBitExactAndTheRestFollows) {
  Trajectory start = random_trajectory(40, 0.02, 5);
  Problem problem = problem_of(start);
  problem.fixed.assign(40, 0);
  problem.fixed[0] = problem.fixed[20] = problem.fixed[39] = 1;
  problem.smoothness.push_back({2, 1e-3, 1e-3, {}, false, {}});
  const Solution solution = solve(problem);
  EXPECT_LT(solution.cost, solution.start_cost);
  for (const size_t t : {0, 20, 39}) {
    EXPECT_EQ(solution.trajectory[t].trans, start[t].trans);
    for (int j = 0; j < kStandardJoints; ++j)
      EXPECT_EQ(solution.trajectory[t].local[j].coeffs(), start[t].local[j].coeffs());
  }
  EXPECT_GT((solution.trajectory[10].trans - start[10].trans).norm(), 1e-4);
}

TEST(Solve, WhatIsKnownDoesNotMove) {
  Problem problem = problem_of(random_trajectory(4, 0.02, 5));
  problem.moves = false;
  problem.rotates.assign(kStandardJoints, 0);
  problem.rotates[16] = problem.rotates[18] = 1;
  for (int64_t t = 0; t < 4; ++t) problem.places.push_back({t, 20, Vector3d(0.5, 0.3, 0.4), Vector3d::Ones(), {}});
  const Solution solution = solve(problem, {50, 1e-10});
  EXPECT_LT(solution.cost, 0.9 * solution.start_cost);
  for (size_t t = 0; t < 4; ++t)
    for (int j = 0; j < kStandardJoints; ++j) {
      const bool same = solution.trajectory[t].local[j].coeffs() == problem.start[t].local[j].coeffs();
      EXPECT_EQ(same, j != 16 && j != 18) << j;
    }
}

TEST(Solve, AHandReachesItsPlace) {
  Problem problem = problem_of(random_trajectory(20, 0, 5));
  problem.stay_near.rotations.assign(20 * kStandardJoints, 1.0);
  problem.stay_near.root.assign(20, 100.0);
  problem.smoothness.push_back({2, 1e-4, 1e-4, {}, true, {}});
  const std::vector<BonesPose> before = posed(problem, problem.start);
  const Vector3d target = before[10].positions[20] + Vector3d(0.05, 0.05, 0.03);
  problem.places.push_back({10, 20, target, Vector3d::Constant(1e8), {}});
  const Solution solution = solve(problem, {50, 1e-10});
  const std::vector<BonesPose> after = posed(problem, solution.trajectory);
  EXPECT_LT((after[10].positions[20] - target).norm(), 1e-4);
  EXPECT_LT((after[19].positions[20] - before[19].positions[20]).norm(), 0.05) << "frames far off move less";
}

TEST(Solve, AHeldFootStandsStill) {
  Trajectory start = random_trajectory(30, 0, 6);
  for (size_t t = 0; t < start.size(); ++t) start[t].trans.x() += 0.004 * static_cast<double>(t);
  Problem problem = problem_of(start);
  problem.stay_near.rotations.assign(30 * kStandardJoints, 1.0);
  problem.stay_near.root.assign(30, 1000.0);
  for (int64_t t = 5; t < 25; ++t) problem.holds.push_back({t, 10, Vector3d::Constant(1e6)});
  const Solution solution = solve(problem, {50, 1e-9});
  const std::vector<BonesPose> after = posed(problem, solution.trajectory);
  for (size_t t = 5; t <= 25; ++t) EXPECT_LT((after[t].positions[10] - after[15].positions[10]).norm(), 2e-3) << t;
}

TEST(Solve, ThePlaceOutsideAWallIsFound) {
  Problem problem = problem_of(random_trajectory(5, 0, 6));
  problem.stay_near.rotations.assign(5 * kStandardJoints, 1.0);
  problem.stay_near.root.assign(5, 1.0);
  const double face = posed(problem, problem.start)[0].positions[0].z() + 0.1;  // the pelvis is 10 cm inside
  for (int64_t t = 0; t < 5; ++t) problem.planes.push_back({t, 0, Vector3d::UnitZ(), face + 0.05, 1e6, false});
  const std::vector<BonesPose> after = posed(problem, solve(problem).trajectory);
  for (const BonesPose& pose : after) EXPECT_NEAR(pose.positions[0].z(), face + 0.05, 1e-5);
}

TEST(Solve, ThreadsDoNotChangeABit) {
  const Problem problem = everything(40);
  const int threads = at::get_num_threads();
  at::set_num_threads(1);
  const Solution one = solve(problem);
  at::set_num_threads(2);
  const Solution two = solve(problem);
  at::set_num_threads(threads);
  for (size_t t = 0; t < 40; ++t) EXPECT_EQ(one.trajectory[t].trans, two.trajectory[t].trans) << t;
}

TEST(Solve, RefusesWhatIsNoProblem) {
  Problem problem = everything(4);
  const auto refused = [](const Problem& p) { EXPECT_THROW(solve(p), Error); };
  problem.holds.push_back({3, 0, Vector3d::Ones()});  // there is no frame 4
  refused(problem);
  problem = everything(4);
  problem.start[2].trans.x() = std::nan("");
  refused(problem);
  problem = everything(4);
  problem.smoothness[0].order = 4;
  refused(problem);
}

TEST(Solve, AWholeStepBehindAPlaneIsShortenedAndNotGivenUp) {
  // The root is pulled to 1 m and kept off a wall at 0.1 m, of which nothing is felt on this side: a whole step, and
  // every damped one until damping has grown by six orders, ends deep in the wall.
  Problem problem = problem_of(random_trajectory(1, 0, 3));
  problem.rotates.assign(kStandardJoints, 0);
  const Vector3d root = posed(problem, problem.start)[0].positions[0];
  problem.places.push_back({0, 0, root + Vector3d(1, 0, 0), Vector3d::Ones(), {}});
  problem.planes.push_back({0, 0, -Vector3d::UnitX(), -root.x() - 0.1, 1e4, false});
  SolveOptions options;
  options.iterations = 3;
  const Solution found = solve(problem, options);
  EXPECT_GE(found.iterations, 2);
  EXPECT_NEAR(found.start_cost, 0.5, 1e-9);
  EXPECT_LT(found.cost, 0.42);  // at best 0.405
}

}  // namespace
}  // namespace inhabit::refine
