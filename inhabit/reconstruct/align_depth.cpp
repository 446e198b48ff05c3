#include "inhabit/reconstruct/align_depth.h"

#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/quantile.h"
#include "inhabit/scene/point_rows.h"
#include "inhabit/scene/query.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;

constexpr double kDepthLoss = 0.05;  // metres, scale of Cauchy's loss
constexpr int kLineRounds = 30, kChamferRounds = 40;
constexpr size_t kLinePairs = 2000;
constexpr int kLineTries = 40;
constexpr double kWidestLine = 2;                       // logarithm of how far a slope may be from the ratio of spreads
constexpr double kFloorBand = 0.06;                     // part of the depth within which a pixel may be the floor
constexpr double kFloorPart = 0.1, kFloorDepths = 0.5;  // part of the pixels; metres
constexpr double kWidest = 0.8;                         // logarithm of how far the first scale may be off
constexpr int kFloorTries = 160;
constexpr double kFloorWeight = 1;  // beside 1 for either side of the Chamfer distance
constexpr size_t kFewest = 30;      // pairs of a vertex and its pixel

double median_or_zero(std::vector<double> values) { return values.empty() ? 0 : median(std::move(values)); }

double cauchy_factor(double away, double scale) { return 1 / (1 + away * away / (scale * scale)); }

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

double quartiles_apart(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() * 3 / 4] - values[values.size() / 4];
}

/// The line that most pairs are near to, over slopes about the ratio of both numbers' spreads. A wall behind the
/// person, far off in both numbers, would draw any line that starts from all pairs to itself.
DepthScale nearest_line(const std::vector<std::array<double, 2>>& pairs) {
  std::vector<double> raws, depths;
  const size_t every = pairs.size() / kLinePairs + 1;
  for (size_t i = 0; i < pairs.size(); i += every) {
    raws.push_back(pairs[i][0]);
    depths.push_back(pairs[i][1]);
  }
  const double ratio = quartiles_apart(depths) / quartiles_apart(raws);
  DepthScale best{0, 0};
  double least = HUGE_VAL;
  std::vector<double> offsets(raws.size());
  for (int i = -kLineTries; i <= kLineTries; ++i)
    for (const double sign : {1., -1.}) {
      const double scale = sign * ratio * std::exp(kWidestLine * i / kLineTries);
      for (size_t k = 0; k < raws.size(); ++k) offsets[k] = depths[k] - scale * raws[k];
      const double offset = median_or_zero(offsets);
      double cost = 0;
      for (const double o : offsets) cost += std::min(std::abs(o - offset), 4 * kDepthLoss);
      if (cost >= least) continue;
      least = cost;
      best = {scale, offset};
    }
  return best;
}

/// The robust line through (raw, depth) of all frames' vertices.
DepthScale first_line(const std::vector<SeenBody>& frames, const std::string& subject) {
  std::vector<std::array<double, 2>> pairs;
  for (const SeenBody& frame : frames)
    for (size_t i = 0; i < frame.vertices.size(); ++i)
      if (std::isfinite(frame.raw[i])) pairs.push_back({frame.raw[i], frame.vertices[i].z()});
  if (pairs.size() < kFewest)
    throw Error(subject, "the body is hardly where the masks say that a person is: " + std::to_string(pairs.size()) +
                             " of its vertices are; are camera, motion and masks of one recording?");
  DepthScale out = nearest_line(pairs);
  std::vector<double> away(pairs.size(), 0);
  for (int round = 0; round < kLineRounds; ++round) {
    for (size_t i = 0; i < pairs.size(); ++i) away[i] = std::abs(out.scale * pairs[i][0] + out.offset - pairs[i][1]);
    const double loss = std::max(0.5 * kDepthLoss, 1.5 * median_or_zero(away));
    Line line;
    for (size_t i = 0; i < pairs.size(); ++i) line.add(pairs[i][0], pairs[i][1], cauchy_factor(away[i], loss));
    out = line.solved();
  }
  // A body that hardly moves tells where it is and little of the scale: relief then decides.
  if (!(out.scale > 0) || !std::isfinite(out.scale) || !std::isfinite(out.offset))
    throw Error(subject, "the maps' numbers do not grow as the body is farther away: depth is wanted, not disparity");
  return out;
}

/// How far, as a part of its depth, a pixel's depth is from the floor's.
double off_floor(const std::array<double, 2>& pixel, const DepthScale& at) {
  return std::abs(at.scale * pixel[0] + at.offset - pixel[1]) / pixel[1];
}

/// The scale, with the body where a line has it, that puts most of the pixels on the floor; the line itself where few
/// are. @param part of the pixels that are on the floor, 0 where they are too few
DepthScale with_floor(const std::vector<SeenBody>& frames, const DepthScale& line, double& part) {
  std::vector<double> raws;
  size_t all = 0;
  for (const SeenBody& frame : frames) {
    for (const double raw : frame.raw)
      if (std::isfinite(raw)) raws.push_back(raw);
    all += frame.floor.size();
  }
  const double raw = median_or_zero(raws), depth = line.scale * raw + line.offset;
  DepthScale best = line;
  double most = 0;
  part = 0;
  for (int i = -kFloorTries; i <= kFloorTries; ++i) {
    const double scale = line.scale * std::exp(kWidest * i / kFloorTries);
    const DepthScale at{scale, depth - scale * raw};
    double on = 0, near = HUGE_VAL, far = 0;
    for (const SeenBody& frame : frames)
      for (const auto& pixel : frame.floor) {
        const double off = off_floor(pixel, at) / kFloorBand;
        if (off >= 1) continue;
        on += (1 - off * off) * (1 - off * off);
        near = std::min(near, pixel[1]);
        far = std::max(far, pixel[1]);
      }
    if (on <= most || far - near < kFloorDepths) continue;
    most = on;
    best = at;
  }
  if (all == 0 || most < kFloorPart * static_cast<double>(all)) return line;
  part = most / static_cast<double>(all);
  return best;
}

/// The floor's part of the equations: Tukey's loss, so that what stands on it does not count.
void add_floor(const SeenBody& frame, const DepthScale& at, Line& line) {
  double on = 0;
  for (const auto& pixel : frame.floor) on += off_floor(pixel, at) < kFloorBand ? 1 : 0;
  for (const auto& pixel : frame.floor) {
    const double off = off_floor(pixel, at) / kFloorBand;
    if (off >= 1) continue;
    // Errors of depth grow with it.
    const double weight = (1 - off * off) * (1 - off * off) / std::max(1.0, pixel[1] * pixel[1]);
    line.add(pixel[0], pixel[1], kFloorWeight * weight / on);
  }
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
                cauchy_factor(away[k][0], kDepthLoss) / static_cast<double>(points.size()));
  }
  if (line == nullptr) return;
  const Neighbours back = CloudQuery(rows).nearest(point_rows(frame.vertices));
  const auto from = back.indices.accessor<int64_t, 2>();
  const auto far = back.distances.accessor<float, 2>();
  for (size_t i = 0; i < frame.vertices.size(); ++i) {
    const auto k = static_cast<int64_t>(i);
    line->add(frame.person[static_cast<size_t>(from[k][0])], frame.vertices[i],
              cauchy_factor(far[k][0], kDepthLoss) / static_cast<double>(frame.vertices.size()));
  }
}

}  // namespace

DepthAlignment align_depth(const std::vector<SeenBody>& frames, const std::string& subject) {
  DepthAlignment out;
  out.scale = with_floor(frames, first_line(frames, subject), out.floor);
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
    if (out.floor > 0)
      for (const SeenBody* frame : used) add_floor(*frame, out.scale, line);
    out.after = median_or_zero(distances);
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
