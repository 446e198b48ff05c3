#include "decimate.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <queue>
#include <tuple>

namespace inhabit {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using Eigen::Vector4d;

struct Candidate {
  double cost;
  int a, b;
  int stamp_a, stamp_b;  ///< when either vertex has changed since, the candidate is stale
  Vector3d place;
  bool operator>(const Candidate& o) const { return std::tie(cost, a, b) > std::tie(o.cost, o.a, o.b); }
};

class Decimator {
 public:
  Decimator(const TriangleSurface& s, const std::function<double(const Vector3d&)>& importance)
      : x_(s.vertices),
        faces_(s.faces),
        importance_(importance),
        alive_(s.vertices.size(), true),
        face_alive_(s.faces.size(), true),
        stamp_(s.vertices.size(), 0),
        around_(s.vertices.size()),
        quadric_(s.vertices.size(), Matrix4d::Zero()),
        left_(s.vertices.size()) {
    for (size_t f = 0; f < faces_.size(); ++f) {
      const Vector3d n = normal(faces_[f]);
      const double area = n.norm();
      for (int i = 0; i < 3; ++i) around_[faces_[f][i]].push_back(static_cast<int>(f));
      if (area < 1e-14) continue;
      Vector4d plane;
      plane << n / area, -n.dot(x_[faces_[f][0]]) / area;
      for (int i = 0; i < 3; ++i) quadric_[faces_[f][i]] += area * plane * plane.transpose();
    }
  }

  TriangleSurface run(size_t vertices) {
    // An edge that could not go may be able to once its surroundings have changed: passes until nothing more goes.
    for (size_t before = left_ + 1; left_ > vertices && left_ < before;) {
      before = left_;
      for (size_t v = 0; v < x_.size(); ++v)
        for (int n : neighbours(static_cast<int>(v)))
          if (static_cast<int>(v) < n) push(static_cast<int>(v), n);
      while (left_ > vertices && !queue_.empty()) {
        const Candidate c = queue_.top();
        queue_.pop();
        if (!alive_[c.a] || !alive_[c.b] || stamp_[c.a] != c.stamp_a || stamp_[c.b] != c.stamp_b) continue;
        if (allowed(c)) collapse(c);
      }
    }
    return result();
  }

 private:
  Vector3d normal(const Vector3i& f) const { return 0.5 * (x_[f[1]] - x_[f[0]]).cross(x_[f[2]] - x_[f[0]]); }
  bool on_plane(int v) const { return x_[v].x() == 0; }

  std::vector<int> neighbours(int v) const {
    std::vector<int> near;
    for (int f : around_[v])
      for (int i = 0; i < 3; ++i)
        if (faces_[f][i] != v) near.push_back(faces_[f][i]);
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    return near;
  }

  int faces_with(int a, int b) const {
    int count = 0;
    for (int f : around_[a]) count += faces_[f][0] == b || faces_[f][1] == b || faces_[f][2] == b;
    return count;
  }

  void push(int a, int b) {
    const Matrix4d q = quadric_[a] + quadric_[b];
    const bool plane = on_plane(a) || on_plane(b);
    // The place of least error; a little of the pull towards the middle keeps flat regions well conditioned.
    const Vector3d middle =
        on_plane(a) == on_plane(b) ? Vector3d(0.5 * (x_[a] + x_[b])) : (on_plane(a) ? x_[a] : x_[b]);
    const double pull = 1e-3 * q.topLeftCorner<3, 3>().trace() + 1e-12;
    Eigen::Matrix3d m = q.topLeftCorner<3, 3>() + pull * Eigen::Matrix3d::Identity();
    Vector3d r = -q.topRightCorner<3, 1>() + pull * middle;
    if (plane) {
      m.row(0).setZero();
      m.col(0).setZero();
      m(0, 0) = 1;
      r[0] = 0;
    }
    const Vector3d place = m.ldlt().solve(r);
    const Vector4d h(place.x(), place.y(), place.z(), 1);
    const double length2 = (x_[a] - x_[b]).squaredNorm();
    // The small term in the edge's length makes triangles even where the surface is flat.
    const double cost = (std::max(0.0, h.dot(q * h)) + 2e-4 * length2 * length2) * importance_(place);
    queue_.push({cost, a, b, stamp_[a], stamp_[b], plane ? Vector3d(0, place.y(), place.z()) : place});
  }

  static double longest_squared(const std::array<Vector3d, 3>& t) {
    return std::max({(t[1] - t[0]).squaredNorm(), (t[2] - t[1]).squaredNorm(), (t[0] - t[2]).squaredNorm()});
  }

  bool allowed(const Candidate& c) const {
    const int shared_faces = faces_with(c.a, c.b);
    const bool both_on_plane = on_plane(c.a) && on_plane(c.b);
    if (both_on_plane && shared_faces != 1) return false;
    const std::vector<int> near_a = neighbours(c.a), near_b = neighbours(c.b);
    std::vector<int> common;
    std::set_intersection(near_a.begin(), near_a.end(), near_b.begin(), near_b.end(), std::back_inserter(common));
    if (static_cast<int>(common.size()) != shared_faces) return false;
    for (int n : common)
      if (neighbours(n).size() <= 3) return false;
    if (on_plane(c.a) != on_plane(c.b)) {
      // The new vertex lies in the plane: it may meet other vertices of the plane only along the open edge.
      const int rim = on_plane(c.a) ? c.a : c.b;
      for (int n : on_plane(c.a) ? near_b : near_a)
        if (n != rim && on_plane(n) && faces_with(rim, n) != 1) return false;
    }
    for (int v : {c.a, c.b})
      for (int f : around_[v]) {
        const Vector3i& face = faces_[f];
        const bool has_a = (face.array() == c.a).any(), has_b = (face.array() == c.b).any();
        if (has_a && has_b) continue;
        std::array<Vector3d, 3> moved;
        for (int i = 0; i < 3; ++i) moved[i] = face[i] == v ? c.place : x_[face[i]];
        const Vector3d before = normal(face), after = 0.5 * (moved[1] - moved[0]).cross(moved[2] - moved[0]);
        if (before.dot(after) < 0.3 * before.norm() * after.norm()) return false;
        // Slivers may only get better.
        const double shape = after.norm() / longest_squared(moved);
        if (shape < 0.1 && shape < before.norm() / longest_squared({x_[face[0]], x_[face[1]], x_[face[2]]}))
          return false;
      }
    return true;
  }

  void collapse(const Candidate& c) {
    x_[c.a] = c.place;
    quadric_[c.a] += quadric_[c.b];
    alive_[c.b] = false;
    --left_;
    ++stamp_[c.a];
    for (int f : around_[c.b]) {
      Vector3i& face = faces_[f];
      if ((face.array() == c.a).any()) {
        face_alive_[f] = false;
        for (int i = 0; i < 3; ++i)
          if (face[i] != c.b) std::erase(around_[face[i]], f);
      } else {
        for (int i = 0; i < 3; ++i)
          if (face[i] == c.b) face[i] = c.a;
        around_[c.a].push_back(f);
      }
    }
    around_[c.b].clear();
    for (int n : neighbours(c.a)) push(std::min(c.a, n), std::max(c.a, n));
  }

  TriangleSurface result() const {
    TriangleSurface out;
    std::vector<int> place(x_.size(), -1);
    for (size_t v = 0; v < x_.size(); ++v)
      if (alive_[v] && !around_[v].empty()) {
        place[v] = static_cast<int>(out.vertices.size());
        out.vertices.push_back(x_[v]);
      }
    for (size_t f = 0; f < faces_.size(); ++f)
      if (face_alive_[f]) out.faces.emplace_back(place[faces_[f][0]], place[faces_[f][1]], place[faces_[f][2]]);
    return out;
  }

  std::vector<Vector3d> x_;
  std::vector<Vector3i> faces_;
  const std::function<double(const Vector3d&)>& importance_;
  std::vector<bool> alive_, face_alive_;
  std::vector<int> stamp_;
  std::vector<std::vector<int>> around_;  ///< faces at each vertex
  std::vector<Matrix4d, Eigen::aligned_allocator<Matrix4d>> quadric_;
  size_t left_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue_;
};

}  // namespace

TriangleSurface decimate(const TriangleSurface& surface, size_t vertices,
                         const std::function<double(const Vector3d&)>& importance) {
  return Decimator(surface, importance).run(vertices);
}

}  // namespace inhabit
