// The trajectory solver beside Ceres on one problem: 300 frames of a noisy walk on the built-in body, near to where it
// is, of little acceleration, the feet in place while they stand. Both have analytic Jacobians, all 69 unknowns of a
// frame in one block, two threads, and stop at the same relative decrease of the cost. Then the whole of
// refine::refine on ten seconds.
#include <ATen/Parallel.h>
#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/io/files.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/refine/refine_clip.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/thread_variables.h"

namespace {

using namespace inhabit;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kJoints = kStandardJoints, kUnknowns = 3 + 3 * kJoints;
constexpr double kNear = 1 / (0.02 * 0.02), kNearRoot = 1 / (0.01 * 0.01), kSmooth = 1 / (4.0 * 4.0),
                 kPlace = 1 / (0.002 * 0.002), kTolerance = 1e-4;

Clip noisy_walk(int64_t frames) {
  const Clip walk = read_clip(INHABIT_SOURCE_DIR "/examples/data/walk.npz");
  std::vector<int64_t> there_and_back;  // the walk is three seconds long
  for (int64_t t = 0; t < frames; ++t) {
    const int64_t period = 2 * (walk.frames() - 1), phase = t % period;
    there_and_back.push_back(std::min(phase, period - phase));
  }
  Clip clip = frames_at(walk, there_and_back);
  torch::manual_seed(1);
  clip.rotations = clip.rotations + torch::randn_like(clip.rotations) * (M_PI / 180);
  clip.trans = clip.trans + torch::randn_like(clip.trans) * 0.01;
  return clip;
}

refine::Problem problem_of(const Clip& clip) {
  refine::Problem problem;
  problem.bones = bones_of(clip.skeleton);
  problem.points = refine::joint_points(kJoints);
  problem.start = refine::trajectory_of(clip);
  const auto frames = static_cast<size_t>(clip.frames());
  problem.stay_near.rotations.assign(frames * kJoints, kNear);
  problem.stay_near.root.assign(frames, kNearRoot);
  problem.smoothness.push_back({2, kSmooth, 0, {}, false, {}});
  const refine::Poses poses = refine::posed(problem.bones, problem.start);
  for (int64_t t = 0; t < clip.frames(); ++t) {
    const int foot = (t / 15) % 2 == 0 ? 10 : 11;  // each foot stands for half a second
    const int64_t since = t - t % 15;
    problem.places.push_back(
        {t, foot, poses[static_cast<size_t>(since)].positions[foot], Vector3d::Constant(kPlace), {}});
  }
  return problem;
}

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// d log(exp(-a) exp(a + d)) / d d: what a change of the rotation vector turns by.
Matrix3d right_jacobian(const Vector3d& a) {
  const double angle = a.norm();
  const Matrix3d k = cross(a);
  if (angle < 1e-5) return Matrix3d::Identity() - 0.5 * k + k * k / 6;
  return Matrix3d::Identity() - (1 - std::cos(angle)) / (angle * angle) * k +
         (angle - std::sin(angle)) / (angle * angle * angle) * k * k;
}

using FrameJacobian = Eigen::Matrix<double, 3 * kJoints, kUnknowns, Eigen::RowMajor>;

/// Joints of a frame whose parameters are the root's translation and 22 rotation vectors, and their derivatives.
void joints_of(const Bones& bones, const double* x, Eigen::Matrix<double, 3 * kJoints, 1>& places, BonesPose& pose,
               FrameJacobian* jacobian) {
  std::vector<Eigen::Quaterniond> local(kJoints);
  for (int j = 0; j < kJoints; ++j) local[j] = quaternion_of(Eigen::Map<const Vector3d>(x + 3 + 3 * j));
  pose_bones(bones, local, Eigen::Map<const Vector3d>(x), pose);
  for (int k = 0; k < kJoints; ++k) places.segment<3>(3 * k) = pose.positions[k];
  if (jacobian == nullptr) return;
  jacobian->setZero();
  std::array<Matrix3d, kJoints> turned;
  for (int j = 0; j < kJoints; ++j)
    turned[j] = pose.rotations[j].toRotationMatrix() * right_jacobian(Eigen::Map<const Vector3d>(x + 3 + 3 * j));
  for (int k = 0; k < kJoints; ++k) {
    jacobian->block<3, 3>(3 * k, 0).setIdentity();
    for (int j = bones.parents[k]; j >= 0; j = bones.parents[j])
      jacobian->block<3, 3>(3 * k, 3 + 3 * j) = -cross(pose.positions[k] - pose.positions[j]) * turned[j];
  }
}

class Near : public ceres::SizedCostFunction<kUnknowns, kUnknowns> {
 public:
  explicit Near(const refine::FramePose& start) : start_(start) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::Matrix<double, kUnknowns, 1>> r(residuals);
    r.head<3>() = std::sqrt(kNearRoot) * (Eigen::Map<const Vector3d>(x[0]) - start_.trans);
    using Square = Eigen::Matrix<double, kUnknowns, kUnknowns, Eigen::RowMajor>;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Square>(jacobians[0]).setZero();
      Eigen::Map<Square>(jacobians[0]).topLeftCorner<3, 3>().diagonal().setConstant(std::sqrt(kNearRoot));
    }
    for (int j = 0; j < kJoints; ++j) {
      const Eigen::Map<const Vector3d> a(x[0] + 3 + 3 * j);
      const Vector3d between = axis_angle_of(start_.local[j].conjugate() * quaternion_of(Vector3d(a)));
      r.segment<3>(3 + 3 * j) = std::sqrt(kNear) * between;
      if (jacobians == nullptr || jacobians[0] == nullptr) continue;
      const Matrix3d back = right_jacobian(between).inverse();
      Eigen::Map<Square>(jacobians[0]).block<3, 3>(3 + 3 * j, 3 + 3 * j) =
          std::sqrt(kNear) * back * right_jacobian(Vector3d(a));
    }
    return true;
  }

 private:
  refine::FramePose start_;
};

class Acceleration : public ceres::SizedCostFunction<3 * kJoints, kUnknowns, kUnknowns, kUnknowns> {
 public:
  Acceleration(const Bones& bones, double rate) : bones_(bones), scale_(std::sqrt(kSmooth) * rate * rate) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    Eigen::Map<Eigen::Matrix<double, 3 * kJoints, 1>> r(residuals);
    r.setZero();
    BonesPose pose;
    Eigen::Matrix<double, 3 * kJoints, 1> places;
    static thread_local FrameJacobian jacobian;
    for (int n = 0; n < 3; ++n) {
      const bool wanted = jacobians != nullptr && jacobians[n] != nullptr;
      const double c = n == 1 ? -2 * scale_ : scale_;
      joints_of(bones_, x[n], places, pose, wanted ? &jacobian : nullptr);
      r += c * places;
      if (wanted) Eigen::Map<FrameJacobian>{jacobians[n]} = c * jacobian;
    }
    return true;
  }

 private:
  const Bones& bones_;
  double scale_;
};

class Place : public ceres::SizedCostFunction<3, kUnknowns> {
 public:
  Place(const Bones& bones, int joint, const Vector3d& target) : bones_(bones), joint_(joint), target_(target) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    BonesPose pose;
    Eigen::Matrix<double, 3 * kJoints, 1> places;
    static thread_local FrameJacobian jacobian;
    const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
    joints_of(bones_, x[0], places, pose, wanted ? &jacobian : nullptr);
    Eigen::Map<Vector3d> out(residuals);
    out = std::sqrt(kPlace) * (places.segment<3>(3 * joint_) - target_);
    if (!wanted) return true;
    Eigen::Map<Eigen::Matrix<double, 3, kUnknowns, Eigen::RowMajor>> rows(jacobians[0]);
    rows = std::sqrt(kPlace) * jacobian.middleRows<3>(3 * joint_);
    return true;
  }

 private:
  const Bones& bones_;
  int joint_;
  Vector3d target_;
};

double solve_with_ceres(const refine::Problem& p, int* iterations) {
  const size_t frames = p.start.size();
  std::vector<std::array<double, kUnknowns>> x(frames);
  for (size_t t = 0; t < frames; ++t) {
    Eigen::Map<Vector3d>(x[t].data()) = p.start[t].trans;
    for (int j = 0; j < kJoints; ++j)
      Eigen::Map<Vector3d>(x[t].data() + 3 + 3 * j) = axis_angle_of(p.start[t].local[j]);
  }
  ceres::Problem problem;
  for (size_t t = 0; t < frames; ++t) problem.AddResidualBlock(new Near(p.start[t]), nullptr, x[t].data());
  for (size_t t = 0; t + 2 < frames; ++t)
    problem.AddResidualBlock(new Acceleration(p.bones, p.rate), nullptr, x[t].data(), x[t + 1].data(), x[t + 2].data());
  for (const refine::PlaceTerm& place : p.places)
    problem.AddResidualBlock(new Place(p.bones, place.point, place.target), nullptr,
                             x[static_cast<size_t>(place.frame)].data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.num_threads = at::get_num_threads();
  options.function_tolerance = kTolerance;
  options.max_num_iterations = 50;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  *iterations = static_cast<int>(summary.iterations.size()) - 1;
  return summary.final_cost;
}

void with_ceres(benchmark::State& state) {
  at::set_num_threads(2);
  const refine::Problem problem = problem_of(noisy_walk(300));
  int iterations = 0;
  for (auto _ : state) state.counters["cost"] = solve_with_ceres(problem, &iterations);
  state.counters["iterations"] = iterations;
}

void with_ours(benchmark::State& state) {
  at::set_num_threads(2);
  const refine::Problem problem = problem_of(noisy_walk(300));
  int iterations = 0;
  const double expected = solve_with_ceres(problem, &iterations);
  for (auto _ : state) {
    const refine::Solution solution = refine::solve(problem, {50, kTolerance});
    state.counters["cost"] = solution.cost;
    iterations = solution.iterations;
  }
  if (!(state.counters["cost"] < 1.001 * expected)) return state.SkipWithError("the cost is not as low as Ceres'");
  state.counters["iterations"] = iterations;
}

void whole(benchmark::State& state) {
  at::set_num_threads(2);
  const torch::NoGradGuard no_gradients;
  const Clip clip = noisy_walk(30 * state.range(0));
  builtin_body();
  for (auto _ : state) benchmark::DoNotOptimize(refine::refine(clip, {}));
}

BENCHMARK(with_ceres)->Name("refine/ceres")->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
BENCHMARK(with_ours)->Name("refine/ours")->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
BENCHMARK(whole)
    ->Name("refine/clip")
    ->ArgName("seconds")
    ->Arg(10)
    ->Arg(60)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

}  // namespace

int main(int argc, char** argv) {
  start_with_thread_variables(argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
