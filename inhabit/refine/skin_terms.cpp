#include "inhabit/refine/skin_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "inhabit/refine/approach.h"
#include "inhabit/refine/depth_terms.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kMargin = 0.008;  // metres: what is so much less deep than it may be must not become too deep
constexpr double kApart = 0.04;    // metres between the vertices of one ball that are minded
constexpr double kSame = 0.002;    // metres: two rays have met one surface
constexpr double kCarries = 0.1;   // of a vertex's weights: a joint whose balls it may be over
constexpr double kStretch = 1.5;   // flesh at a bent joint is no more than so much thicker than at rest
constexpr double kThrough = -0.5;  // cosine between the faces where a way enters and where it leaves: a board, no edge

Vector3d row_of(const torch::Tensor& rows, size_t i) {
  return Eigen::Map<const Eigen::Vector3f>(rows.data_ptr<float>() + 3 * i).cast<double>();
}

}  // namespace

/// A vertex in a frame whose way from its ball is looked at.
struct Flesh::Looked {
  size_t near;  // of the approach
  int vertex;
  Vector3d place;
  Vector3d normal = Vector3d::Zero(), surface = Vector3d::Zero();
  double depth = 0;
};

Flesh::Flesh(const BodyModel& body, const torch::Tensor& betas, std::vector<BodyBall> balls)
    : balls_(std::move(balls)), covered_(balls_.size()) {
  const Skin skin = skin_of(body, betas);
  for (BodyBall& ball : balls_) ball.radius = 0;
  for (int v = 0; v < static_cast<int>(skin.size()); ++v) {
    const Vector3d& at = skin.rest[static_cast<size_t>(v)];
    Point vertex;
    std::array<double, kStandardJoints> part{};
    for (int k = skin.first[static_cast<size_t>(v)]; k < skin.first[static_cast<size_t>(v) + 1]; ++k) {
      const auto [joint, weight] = skin.weights[static_cast<size_t>(k)];
      vertex.push_back({joint, weight, at - skin.joints[static_cast<size_t>(joint)]});
      part[static_cast<size_t>(joint)] = weight;
    }
    vertices_.push_back(std::move(vertex));
    size_t under = 0;
    double least = std::numeric_limits<double>::infinity();
    for (size_t b = 0; b < balls_.size(); ++b) {
      const Attachment& middle = balls_[b].point.front();
      const auto joint = static_cast<size_t>(middle.joint);
      const double distance = (skin.joints[joint] + middle.offset - at).norm();
      if (part[joint] > kCarries && distance < least) least = distance, under = b;
    }
    if (!std::isfinite(least)) continue;
    covered_[under].push_back(v);
    balls_[under].radius = std::max(balls_[under].radius, least);
  }
}

std::vector<PlaneTerm> Flesh::planes(const SceneQuery& solid, const Poses& poses, double depth, double weight,
                                     std::vector<Point>& points) {
  const Approach approach(solid, balls_, poses, 0);
  std::vector<Looked> looked, in;
  std::vector<Vector3d> from, to;
  for (size_t n = 0; n < approach.near.size(); ++n) {
    const BallPlace& at = approach.near[n];
    const bool inside = approach.inside[n] != 0;
    if (!inside && at.distance >= kStretch * balls_[at.ball].radius) continue;
    const BonesPose& pose = poses[static_cast<size_t>(at.frame)];
    const Vector3d out = inside ? (at.surface - at.place).normalized() : Vector3d::Zero();
    for (const int v : covered_[at.ball]) {
      const Vector3d place = place_of(vertices_[static_cast<size_t>(v)], pose);
      if (inside) {
        const double deep = out.dot(at.surface - place);
        if (deep > depth - kMargin) in.push_back({n, v, place, out, at.surface, deep});
      } else if ((place - at.place).norm() > at.distance) {
        looked.push_back({n, v, place});
        from.push_back(at.place);
        to.push_back(place);
      }
    }
  }
  const auto cast = [&](const std::vector<Vector3d>& begin, const std::vector<Vector3d>& end) {
    std::vector<Vector3d> along;
    double longest = 0;
    for (size_t i = 0; i < begin.size(); ++i) {
      along.push_back(end[i] - begin[i]);
      longest = std::max(longest, along.back().norm());
    }
    return solid.cast(point_rows(begin), point_rows(along), longest);
  };
  if (!looked.empty()) {
    const RayHits hits = cast(from, to);
    std::vector<Looked> deep;
    for (size_t i = 0; i < looked.size(); ++i) {
      if (!hits.hit.data_ptr<bool>()[i]) continue;
      Looked& l = looked[i];
      const Vector3d way = l.place - from[i];
      l.surface = row_of(hits.points, i);
      l.normal = row_of(hits.normals, i);
      if (l.normal.dot(way) > 0) l.normal = -l.normal;
      l.depth = l.normal.dot(l.surface - l.place);
      if (hits.distances.data_ptr<float>()[i] < way.norm() && l.depth > depth - kMargin) deep.push_back(l);
    }
    from.clear(), to.clear();
    for (const Looked& l : deep) from.push_back(l.place), to.push_back(approach.near[l.near].place);
    if (!deep.empty()) {
      // Back again: a vertex that is inside meets the same surface, one that is outside must have gone through.
      const RayHits back = cast(from, to);
      for (size_t i = 0; i < deep.size(); ++i) {
        Vector3d normal = row_of(back.normals, i);
        if (normal.dot(to[i] - from[i]) > 0) normal = -normal;
        if ((row_of(back.points, i) - deep[i].surface).norm() < kSame || normal.dot(deep[i].normal) < kThrough)
          in.push_back(deep[i]);
      }
    }
  }
  std::sort(in.begin(), in.end(), [](const Looked& a, const Looked& b) {
    return a.near != b.near ? a.near < b.near : a.depth != b.depth ? a.depth > b.depth : a.vertex < b.vertex;
  });
  std::vector<PlaneTerm> out;
  std::vector<Vector3d> taken;
  for (size_t i = 0; i < in.size(); ++i) {
    const Looked& l = in[i];
    if (i == 0 || in[i - 1].near != l.near) taken.clear();
    if (std::any_of(taken.begin(), taken.end(), [&](const Vector3d& t) { return (t - l.place).norm() < kApart; }))
      continue;
    taken.push_back(l.place);
    const auto [number, is_new] = number_.try_emplace(l.vertex, static_cast<int>(points.size()));
    if (is_new) points.push_back(vertices_[static_cast<size_t>(l.vertex)]);
    out.push_back(
        {approach.near[l.near].frame, number->second, l.normal, l.normal.dot(l.surface) - depth, weight, false});
  }
  return out;
}

}  // namespace inhabit::refine
