#include "inhabit/reconstruct/align_depth.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/scene/point_rows.h"
#include "inhabit/scene/query.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;

constexpr double kDepthLoss = 0.05;  // metres, scale of Huber's loss
constexpr int kLineRounds = 30, kChamferRounds = 40;
constexpr size_t kFewest = 30;  // pairs of a vertex and its pixel

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double huber_factor(double away, double scale) { return away <= scale ? 1 : scale / away; }

/// Normal equations of s and o.
struct Line {
  Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();

  void add(double raw, double target, double weight) {
    const Eigen::Vector2d row(raw, 1);
    a += weight * row * row.transpose();
    b += weight * target * row;
  }
  /// (s raw + o) ray at `target`.
  void add(const DepthSample& sample, const Vector3d& target, double weight) {
    add(sample.depth, target.dot(sample.ray) / sample.ray.squaredNorm(), weight * sample.ray.squaredNorm());
  }
  DepthScale solved() const {
    const Eigen::Vector2d x = a.ldlt().solve(b);
    return {x[0], x[1]};
  }
};

/// The robust line through (raw, depth) of all frames' vertices.
DepthScale first_line(const std::vector<SeenBody>& frames, const std::string& subject) {
  std::vector<std::array<double, 2>> pairs;
  for (const SeenBody& frame : frames)
    for (size_t i = 0; i < frame.vertices.size(); ++i)
      if (std::isfinite(frame.raw[i])) pairs.push_back({frame.raw[i], frame.vertices[i].z()});
  if (pairs.size() < kFewest)
    throw Error(subject, "the body is hardly where the masks say that a person is: " + std::to_string(pairs.size()) +
                             " of its vertices are; are camera, motion and masks of one recording?");
  DepthScale out{0, 0};
  std::vector<double> away(pairs.size(), 0);
  for (int round = 0; round < kLineRounds; ++round) {
    // A wide loss at first, down to that of the distances' own spread.
    const double loss = round == 0 ? HUGE_VAL : std::max(0.5 * kDepthLoss, 1.5 * median_of(away));
    Line line;
    for (size_t i = 0; i < pairs.size(); ++i) line.add(pairs[i][0], pairs[i][1], huber_factor(away[i], loss));
    out = line.solved();
    for (size_t i = 0; i < pairs.size(); ++i) away[i] = std::abs(out.scale * pairs[i][0] + out.offset - pairs[i][1]);
  }
  if (!(out.scale > 0) || !std::isfinite(out.scale) || !std::isfinite(out.offset))
    throw Error(subject, "the maps' numbers do not grow as the body is farther away: depth is wanted, not disparity");
  return out;
}

Vector3d point_of(const DepthSample& sample, const DepthScale& scale) {
  return (scale.scale * sample.depth + scale.offset) * sample.ray;
}

/// One frame's part of the equations at a scale. @param distances of points to vertices are added
void add_chamfer(const SeenBody& frame, const CloudQuery& vertices, const DepthScale& at, Line* line,
                 std::vector<double>& distances) {
  std::vector<Vector3d> points;
  points.reserve(frame.person.size());
  for (const DepthSample& sample : frame.person) points.push_back(point_of(sample, at));
  const torch::Tensor rows = point_rows(points);
  const Neighbours near = vertices.nearest(rows);
  const auto index = near.indices.accessor<int64_t, 2>();
  const auto away = near.distances.accessor<float, 2>();
  for (size_t i = 0; i < points.size(); ++i) {
    const auto k = static_cast<int64_t>(i);
    distances.push_back(away[k][0]);
    if (line != nullptr)
      line->add(frame.person[i], frame.vertices[static_cast<size_t>(index[k][0])],
                huber_factor(away[k][0], kDepthLoss) / static_cast<double>(points.size()));
  }
  if (line == nullptr) return;
  const Neighbours back = CloudQuery(rows).nearest(point_rows(frame.vertices));
  const auto from = back.indices.accessor<int64_t, 2>();
  const auto far = back.distances.accessor<float, 2>();
  for (size_t i = 0; i < frame.vertices.size(); ++i) {
    const auto k = static_cast<int64_t>(i);
    line->add(frame.person[static_cast<size_t>(from[k][0])], frame.vertices[i],
              huber_factor(far[k][0], kDepthLoss) / static_cast<double>(frame.vertices.size()));
  }
}

}  // namespace

DepthAlignment align_depth(const std::vector<SeenBody>& frames, const std::string& subject) {
  DepthAlignment out;
  out.scale = first_line(frames, subject);
  std::vector<const SeenBody*> used;
  std::vector<CloudQuery> vertices;
  std::vector<double> depths;
  for (const SeenBody& frame : frames) {
    if (frame.person.empty() || frame.vertices.empty()) continue;
    used.push_back(&frame);
    vertices.emplace_back(point_rows(frame.vertices));
    for (const Vector3d& v : frame.vertices) depths.push_back(v.z());
  }
  double mean = 0, square = 0;
  for (const double z : depths) mean += z / static_cast<double>(depths.size());
  for (const double z : depths) square += (z - mean) * (z - mean) / static_cast<double>(depths.size());
  out.spread = std::sqrt(square);
  for (int round = 0;; ++round) {
    Line line;
    std::vector<double> distances;
    for (size_t f = 0; f < used.size(); ++f) add_chamfer(*used[f], vertices[f], out.scale, &line, distances);
    out.after = median_of(distances);
    if (round == 0) out.before = out.after;
    const DepthScale next = line.solved();
    if (round == kChamferRounds || !(next.scale > 0) || !std::isfinite(next.offset)) break;
    const double step = std::abs(next.scale - out.scale.scale) / out.scale.scale;
    out.scale = next;
    if (step < 1e-6) break;
  }
  return out;
}

}  // namespace inhabit::reconstruct
