#include "inhabit/motion/level.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/landmarks.h"

namespace inhabit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using torch::Tensor;

constexpr double kSpeedWindow = 0.1;                         // seconds that a foot's speed is taken over
constexpr double kShortestStance = 0.1, kLongestStance = 1;  // seconds of a stance
constexpr double kSlowFoot = 0.2;                            // m/s
constexpr double kPlaneReach = 0.03;                         // metres from the plane: the foot stands on something else
constexpr double kFootNoise = 0.006;                         // metres, of a standing foot about the plane
constexpr double kLineReach = 0.25, kLineNoise = 0.06;       // slope of the lines between hips and shoulders
constexpr double kLineEvery = 0.5, kLineWeight = 0.2;        // seconds; neighbours lean alike
constexpr double kUsualSlope = 0.18;                         // slope (10 degrees) that is not surprising
constexpr double kSteepest = 0.36, kSlopeStep = 0.012;       // slopes that are tried
constexpr size_t kMostStances = 400;                         // stances that are looked at

/// A place or a direction with its height_over over the plane y = a x + b z, and how much it counts.
struct SlopeSample {
  Vector3d at;
  double weight;
};

Vector3d point_of(const Tensor& t) { return {t[0].item<double>(), t[1].item<double>(), t[2].item<double>()}; }

/// Places where a foot stands. @param path (T, 3)
void find_stances(const Tensor& path, double rate, std::vector<SlopeSample>& out) {
  const int64_t frames = path.size(0), half = std::max<int64_t>(1, std::llround(kSpeedWindow * rate / 2));
  if (frames <= 2 * half) return;
  const Tensor speed = (path.slice(0, 2 * half) - path.slice(0, 0, -2 * half)).norm(2, 1) * (rate / (2.0 * half));
  const double slow = std::max(kSlowFoot, torch::quantile(speed, 0.15).item<double>());
  const Tensor stands = (speed <= slow).contiguous();
  const bool* at = stands.data_ptr<bool>();
  const auto most = std::max<int64_t>(1, std::llround(kLongestStance * rate));
  for (int64_t first = 0, last = 0; first < stands.size(0); first = std::max(last, first + 1)) {
    last = first;
    while (last < stands.size(0) && last - first < most && at[last]) ++last;
    const double seconds = static_cast<double>(last - first) / rate;
    if (seconds >= kShortestStance)
      out.push_back({point_of(path.slice(0, first + half, last + half).mean(0)), std::min(1.0, seconds / 0.5)});
  }
}

double height_over(const SlopeSample& s, double a, double b) { return s.at.y() - a * s.at.x() - b * s.at.z(); }

/// How much weight of feet there is within reach of one height_over, for a slope. @param middle that height_over
double feet_near(const std::vector<SlopeSample>& feet, double a, double b, double& middle) {
  std::vector<std::pair<double, double>> heights;
  heights.reserve(feet.size());
  for (const SlopeSample& s : feet) heights.emplace_back(height_over(s, a, b), s.weight);
  std::sort(heights.begin(), heights.end());
  double best = -1;
  for (size_t i = 0, first = 0; i < heights.size(); ++i) {  // about each foot in turn
    while (heights[i].first - heights[first].first > kPlaneReach) ++first;
    double sum = 0;
    for (size_t k = first; k < heights.size() && heights[k].first - heights[i].first <= kPlaneReach; ++k) {
      const double far = (heights[k].first - heights[i].first) / kPlaneReach;
      sum += heights[k].second * (1 - far * far);
    }
    if (sum <= best) continue;
    best = sum;
    middle = heights[i].first;
  }
  return best;
}

double line_cost(const std::vector<SlopeSample>& lines, double a, double b) {
  double cost = 0;
  for (const SlopeSample& s : lines) cost += s.weight * std::min(1.0, std::pow(height_over(s, a, b) / kLineReach, 2));
  return cost;
}

/// Tukey's weight of a residual.
double tukey_weight(double residual, double reach) {
  const double u = residual / reach;
  return std::abs(u) >= 1 ? 0 : (1 - u * u) * (1 - u * u);
}

}  // namespace

FloorSlope floor_slope(const Clip& clip) {
  FloorSlope out;
  Landmarks marks;
  try {
    marks = find_landmarks(clip.skeleton, "skeleton");
  } catch (const Error&) {
    return out;
  }
  const Tensor joints = clip.joints.to(torch::kDouble);
  std::vector<SlopeSample> feet, lines;
  for (const size_t side : {0, 1})
    find_stances(joints.select(1, marks.toe[side] >= 0 ? marks.toe[side] : marks.ankle[side]), clip.rate, feet);
  out.stances = static_cast<int64_t>(feet.size());
  if (out.stances < FloorSlope::kLeastStances) return out;
  if (feet.size() > kMostStances) {
    std::vector<SlopeSample> some;
    for (size_t i = 0; i < kMostStances; ++i) some.push_back(feet[i * feet.size() / kMostStances]);
    feet = some;
  }
  const Tensor across = joints.select(1, marks.hip[0]) - joints.select(1, marks.hip[1]) +
                        joints.select(1, marks.shoulder[0]) - joints.select(1, marks.shoulder[1]);
  const Tensor left = across / across.norm(2, 1, true).clamp_min(1e-9);
  const auto every = std::max<int64_t>(1, std::llround(kLineEvery * clip.rate));
  for (int64_t t = 0; t < left.size(0); t += every * std::max<int64_t>(1, left.size(0) / every / 1000))
    lines.push_back({point_of(left[t]), kLineWeight});
  Vector3d plane = Vector3d::Zero();  // a, b, c of y = a x + b z + c
  double best = -1e300;
  const int steps = static_cast<int>(kSteepest / kSlopeStep);
  for (int i = -steps; i <= steps; ++i)
    for (int j = -steps; j <= steps; ++j) {
      const double a = i * kSlopeStep, b = j * kSlopeStep;
      double middle = 0;
      const double score =
          feet_near(feet, a, b, middle) - line_cost(lines, a, b) - (a * a + b * b) / (kUsualSlope * kUsualSlope);
      if (score <= best) continue;
      best = score;
      plane = {a, b, middle};
    }
  Matrix3d information;
  for (int round = 0; round < 20; ++round) {
    information = Vector3d(1 / (kUsualSlope * kUsualSlope), 1 / (kUsualSlope * kUsualSlope), 0).asDiagonal();
    Vector3d right = Vector3d::Zero();
    const auto add = [&](const Vector3d& row, double y, double weight) {
      information += weight * row * row.transpose();
      right += weight * y * row;
    };
    for (const SlopeSample& s : feet)
      add({s.at.x(), s.at.z(), 1}, s.at.y(),
          s.weight * tukey_weight(height_over(s, plane.x(), plane.y()) - plane.z(), kPlaneReach) /
              (kFootNoise * kFootNoise));
    for (const SlopeSample& s : lines)
      add({s.at.x(), s.at.z(), 0}, s.at.y(),
          s.weight * tukey_weight(height_over(s, plane.x(), plane.y()), kLineReach) / (kLineNoise * kLineNoise));
    plane = information.ldlt().solve(right);
  }
  constexpr double kDegrees = 180 / M_PI;
  out.normal = Vector3d(-plane.x(), 1, -plane.y()).normalized();
  out.degrees = std::atan(std::hypot(plane.x(), plane.y())) * kDegrees;
  const Eigen::Matrix2d spread = information.inverse().topLeftCorner<2, 2>();
  out.uncertainty =
      std::atan(std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvalues()[1])) * kDegrees;
  double weights = 0, mean = 0;
  const auto stands = [&](const SlopeSample& s) {
    return std::abs(height_over(s, plane.x(), plane.y()) - plane.z()) < kPlaneReach;
  };
  for (const SlopeSample& s : feet)
    if (stands(s)) {
      weights += s.weight;
      mean += s.weight * s.at.y();
    }
  for (const SlopeSample& s : feet)
    if (stands(s)) {
      out.off_plane += s.weight / weights * std::abs(height_over(s, plane.x(), plane.y()) - plane.z()) * out.normal.y();
      out.off_level += s.weight / weights * std::abs(s.at.y() - mean / weights);
    }
  return out;
}

void rotate_clip(Clip& clip, const Tensor& rotation) {
  auto rotated = [&](const Tensor& points) { return points.matmul(rotation.t()); };
  const Tensor root = clip.skeleton.offsets.defined() ? clip.skeleton.offsets[0] : torch::zeros({3});
  if (clip.joints.defined()) clip.joints = rotated(clip.joints);
  if (clip.trans.defined()) clip.trans = rotated(clip.trans + root) - root;
  if (clip.rotations.defined()) {
    clip.rotations = clip.rotations.clone();
    clip.rotations.select(1, 0).copy_(
        matrix_to_axis_angle(rotation.matmul(axis_angle_to_matrix(clip.rotations.select(1, 0)))));
  }
  if (clip.hand_targets.defined()) {
    clip.hand_targets = clip.hand_targets.clone();
    clip.hand_targets.narrow(2, 0, 3).copy_(rotated(clip.hand_targets.narrow(2, 0, 3)));
  }
  if (clip.object_pose.defined() && clip.object_pose.numel() > 0) {
    const Tensor place = rotated(clip.object_pose.narrow(2, 0, 3));
    const Tensor angle = matrix_to_axis_angle(rotation.matmul(axis_angle_to_matrix(clip.object_pose.narrow(2, 3, 3))));
    clip.object_pose = torch::cat({place, angle}, 2);
  }
}

Tensor rotation_upright(const Vector3d& up) {
  const Matrix3d rotation = Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitY()).toRotationMatrix();
  Tensor matrix = torch::empty({3, 3});
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) matrix[r][c] = rotation(r, c);
  return matrix;
}

void level(Clip& clip, const FloorSlope& slope) { rotate_clip(clip, rotation_upright(slope.normal)); }

}  // namespace inhabit
