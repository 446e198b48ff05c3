#include "inhabit/refine/skin_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "inhabit/refine/approach.h"
#include "inhabit/scene/point_rows.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kMargin = 0.008;  // metres: what is so much less deep than it may be must not become too deep
constexpr double kApart = 0.04;    // metres between the vertices of one ball that are minded
constexpr int64_t kAtOnce = 128;   // frames, of each of which thousands of vertices are looked at
constexpr double kSame = 0.002;    // metres: two rays have met one surface
constexpr double kCarries = 0.1;   // of a vertex's weights: a joint whose balls it may be over
constexpr double kStretch = 1.5;   // flesh at a bent joint is no more than so much thicker than at rest
constexpr double kThrough = -0.5;  // cosine between the faces where a segment enters and leaves: a board, no edge

/// A vertex in a frame, and where the flesh under it enters the scene.
struct Entry {
  size_t near;  // of the approach: frame and ball
  int vertex;
  Vector3d ball, place;  // of the ball's middle and of the vertex
  Vector3d surface = Vector3d::Zero(), normal = Vector3d::Zero();
  double depth = 0;  // metres, of the vertex under the plane at the surface
};

/// What rays from `from` to `to` meet first.
RayHits cast(const SceneQuery& solid, const std::vector<Vector3d>& from, const std::vector<Vector3d>& to) {
  std::vector<Vector3d> along;
  double longest = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    along.push_back(to[i] - from[i]);
    longest = std::max(longest, along.back().norm());
  }
  return solid.cast(point_rows(from), point_rows(along), longest);
}

/// The face's side that looks against `segment`.
Vector3d against(const Vector3d& normal, const Vector3d& segment) { return normal.dot(segment) > 0 ? -normal : normal; }

/// A surface that a limb has gone into, seen from the side that it came from.
struct Entered {
  bool is = false;
  Vector3d surface = Vector3d::Zero(), normal = Vector3d::Zero();
};

bool same_bone(const BodyBall& a, const BodyBall& b) { return a.point.front().joint == b.point.front().joint; }

/// Of each ball of an approach, what its limb has gone into. Limbs are followed outward, from each ball to the next:
/// what a thigh has sunk into lies under it, also where the exit below is nearer. Who leaves over an edge is outside
/// again, who comes out at the back of a board is not.
/// @param before of each ball the one that its limb comes from, -1 for none
std::vector<Entered> entered(const SceneQuery& solid, const Approach& approach, const std::vector<BodyBall>& balls,
                             const std::vector<int>& before, const Poses& poses) {
  const size_t count = approach.near.size();
  std::vector<Vector3d> from, to;
  for (const BallPlace& at : approach.near) {
    const int b = before[at.ball];
    from.push_back(b < 0 ? at.place
                         : place_of(balls[static_cast<size_t>(b)].point, poses[static_cast<size_t>(at.frame)]));
    to.push_back(at.place + (b < 0 ? Vector3d(0, 1e-6, 0) : Vector3d::Zero()));
  }
  std::vector<Entered> out(count);
  if (count == 0) return out;
  const RayHits in = cast(solid, from, to), back = cast(solid, to, from);
  std::vector<Entered> limb(balls.size());
  for (size_t n = 0; n < count; ++n) {
    const BallPlace& at = approach.near[n];
    if (n == 0 || approach.near[n - 1].frame != at.frame) std::fill(limb.begin(), limb.end(), Entered());
    const bool inside = approach.inside[n] != 0, joined = before[at.ball] >= 0;
    const Vector3d segment = to[n] - from[n];
    const bool crosses = joined && in.hit.data_ptr<bool>()[n] && in.distances.data_ptr<float>()[n] < segment.norm();
    // The face through which it comes out before it gets here, if it has come out.
    const Vector3d left = -against(row_point(back.normals, n), segment);
    Entered& here = limb[at.ball];
    // A shank is no less under the seat for the thigh that has gone through it.
    if (joined && (inside || same_bone(balls[at.ball], balls[static_cast<size_t>(before[at.ball])])))
      here = limb[static_cast<size_t>(before[at.ball])];
    if (here.is) {
      if (!inside && crosses && left.dot(here.normal) >= kThrough) here.is = false;
    } else if (crosses) {
      const Vector3d normal = against(row_point(in.normals, n), segment);
      here = {inside || left.dot(normal) < kThrough, row_point(in.points, n), normal};
    } else if (inside) {
      here = {true, at.surface, (at.surface - at.place).normalized()};
    }
    out[n] = here;
  }
  return out;
}

/// Of vertices whose balls are outside, those that are deeper than `least` behind where the segment from the ball
/// enters a surface, with that surface.
void keep_entering(const SceneQuery& solid, double least, std::vector<Entry>& segments) {
  if (segments.empty()) return;
  std::vector<Vector3d> balls, places;
  for (const Entry& each : segments) balls.push_back(each.ball), places.push_back(each.place);
  const RayHits hits = cast(solid, balls, places);
  std::vector<Entry> deep;
  balls.clear(), places.clear();
  for (size_t i = 0; i < segments.size(); ++i) {
    Entry& each = segments[i];
    const Vector3d segment = each.place - each.ball;
    if (!hits.hit.data_ptr<bool>()[i] || hits.distances.data_ptr<float>()[i] >= segment.norm()) continue;
    each.surface = row_point(hits.points, i);
    each.normal = against(row_point(hits.normals, i), segment);
    each.depth = each.normal.dot(each.surface - each.place);
    if (each.depth <= least) continue;
    balls.push_back(each.ball), places.push_back(each.place);
    deep.push_back(each);
  }
  segments.clear();
  if (deep.empty()) return;
  // Back again: a vertex that is inside meets the same surface, one that is outside must have gone through.
  const RayHits back = cast(solid, places, balls);
  for (size_t i = 0; i < deep.size(); ++i) {
    const Vector3d left = against(row_point(back.normals, i), balls[i] - places[i]);
    if ((row_point(back.points, i) - deep[i].surface).norm() < kSame || left.dot(deep[i].normal) < kThrough)
      segments.push_back(deep[i]);
  }
}

}  // namespace

Flesh::Flesh(const BodyModel& body, const torch::Tensor& betas, std::vector<BodyBall> balls)
    : balls_(std::move(balls)), covered_(balls_.size()) {
  const Skin skin = skin_of(body, betas);
  follow_limbs(body, skin);
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

void Flesh::follow_limbs(const BodyModel& body, const Skin& skin) {
  const auto joint = [&](size_t b) { return balls_[b].point.front().joint; };
  const auto middle = [&](size_t b) -> Vector3d {
    return skin.joints[static_cast<size_t>(joint(b))] + balls_[b].point.front().offset;
  };
  for (size_t b = 0; b < balls_.size(); ++b) {
    before_.push_back(-1);
    double least = std::numeric_limits<double>::infinity();
    for (size_t other = 0; other < b; ++other) {
      if (joint(other) != joint(b) && joint(other) != body.skeleton.parents[static_cast<size_t>(joint(b))]) continue;
      const double distance = (middle(other) - middle(b)).norm();
      if (distance < least) least = distance, before_.back() = static_cast<int>(other);
    }
  }
}

std::vector<PlaneTerm> Flesh::planes(const SceneQuery& solid, const Poses& poses, double depth, double weight,
                                     std::vector<Point>& points) {
  std::vector<PlaneTerm> out;
  const auto frames = static_cast<int64_t>(poses.size());
  for (int64_t first = 0; first < frames; first += kAtOnce) {
    const Poses some(poses.begin() + first, poses.begin() + std::min(frames, first + kAtOnce));
    for (PlaneTerm& plane : planes_of_some(solid, some, depth, weight, points)) {
      plane.frame += first;
      out.push_back(plane);
    }
  }
  return out;
}

std::vector<PlaneTerm> Flesh::planes_of_some(const SceneQuery& solid, const Poses& poses, double depth, double weight,
                                             std::vector<Point>& points) {
  const Approach approach(solid, balls_, poses, 0);
  const std::vector<Entered> limbs = entered(solid, approach, balls_, before_, poses);
  std::vector<Entry> in, segments;
  for (size_t n = 0; n < approach.near.size(); ++n) {
    const BallPlace& at = approach.near[n];
    const Entered& limb = limbs[n];
    if (!limb.is && at.distance >= kStretch * balls_[at.ball].radius) continue;
    const BonesPose& pose = poses[static_cast<size_t>(at.frame)];
    for (const int v : covered_[at.ball]) {
      const Vector3d place = place_of(vertices_[static_cast<size_t>(v)], pose);
      if (limb.is)
        in.push_back({n, v, at.place, place, limb.surface, limb.normal, limb.normal.dot(limb.surface - place)});
      else if ((place - at.place).norm() > at.distance)
        segments.push_back({n, v, at.place, place});
    }
  }
  keep_entering(solid, depth - kMargin, segments);
  in.insert(in.end(), segments.begin(), segments.end());
  std::erase_if(in, [&](const Entry& each) { return each.depth <= depth - kMargin; });
  std::sort(in.begin(), in.end(), [](const Entry& a, const Entry& b) {
    return a.near != b.near ? a.near < b.near : a.depth != b.depth ? a.depth > b.depth : a.vertex < b.vertex;
  });
  std::vector<PlaneTerm> out;
  std::vector<Vector3d> taken;
  for (size_t i = 0; i < in.size(); ++i) {
    const Entry& each = in[i];
    if (i == 0 || in[i - 1].near != each.near) taken.clear();
    if (std::any_of(taken.begin(), taken.end(), [&](const Vector3d& t) { return (t - each.place).norm() < kApart; }))
      continue;
    taken.push_back(each.place);
    const auto [number, is_new] = number_.try_emplace(each.vertex, static_cast<int>(points.size()));
    if (is_new) points.push_back(vertices_[static_cast<size_t>(each.vertex)]);
    out.push_back({approach.near[each.near].frame, number->second, each.normal, each.normal.dot(each.surface) - depth,
                   weight, false});
  }
  return out;
}

}  // namespace inhabit::refine
