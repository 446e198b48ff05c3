#include "inhabit/reconstruct/place_object.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "inhabit/error.h"
#include "inhabit/math/quantile.h"
#include "inhabit/reconstruct/scene_points.h"
#include "inhabit/scene/point_rows.h"
#include "inhabit/scene/query.h"
#include "inhabit/scene/sampling.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;
using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

constexpr double kPointCell = 0.02;                          // metres
constexpr size_t kFewestPoints = 50, kFewestOfOneView = 25;  // that tell where an object is
constexpr size_t kMostPoints = 1500, kCoarsePoints = 250;
constexpr int64_t kMostSurface = 800, kCoarseSurface = 250;
constexpr int kYaws = 24, kCoarseRounds = 12, kFineRounds = 40;
constexpr double kStands = 0.3;         // metres above the floor: an object may begin there and still stand on it
constexpr size_t kBest = 5;             // starts that go on
constexpr double kObjectLoss = 0.02;    // metres, scale of Huber's loss at the end
constexpr double kHidden = 0.05;        // metres, and part of the distance: something is before the surface
constexpr double kUnseenBehind = 0.02;  // of the object's size: its own surface is before it

std::vector<Vector3d> rows_as_vectors(const torch::Tensor& rows) {
  const auto r = rows.accessor<float, 2>();
  std::vector<Vector3d> out;
  out.reserve(static_cast<size_t>(rows.size(0)));
  for (int64_t i = 0; i < rows.size(0); ++i) out.emplace_back(r[i][0], r[i][1], r[i][2]);
  return out;
}

template <class T>
std::vector<T> thinned(const std::vector<T>& all, size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> out;
  out.reserve(most);
  for (size_t i = 0; i < most; ++i) out.push_back(all[i * all.size() / most]);
  return out;
}

/// How an object fits, and the step that makes it fit better.
struct Fit {
  double cost = 0, distance = 0;  ///< mean loss of both sides, metres^2; median distance of the points, metres
  Matrix5d a = Matrix5d::Zero();
  Vector5d b = Vector5d::Zero();
};

class ObjectSearch {
 public:
  /// @param used (views) (height, width) bool, the pixels that points are of
  ObjectSearch(const std::vector<Mesh>& meshes, const ObjectViews& seen, std::vector<torch::Tensor> used,
               const Camera& camera, double floor)
      : seen_(seen), used_(std::move(used)), camera_(camera), floor_(floor), query_(scene_of(meshes)) {
    std::mt19937_64 random(1);
    const std::vector<Vector3d> surface = rows_as_vectors(sample_points(scene_of(meshes), kMostSurface, random));
    low_ = high_ = surface.front();
    for (const Vector3d& p : surface) low_ = low_.cwiseMin(p), high_ = high_.cwiseMax(p);
    for (const Mesh& mesh : meshes)
      if (mesh.vertices.size(0) > 0) low_.y() = std::min(low_.y(), mesh.vertices.select(1, 1).min().item<double>());
    surface_ = surface;
  }

  static Scene scene_of(const std::vector<Mesh>& meshes) {
    Scene out;
    out.meshes = meshes;
    return out;
  }

  double size() const { return (high_ - low_).norm(); }

  Placement search(const std::vector<Vector3d>& all, Fit& best_fit) {
    std::vector<std::pair<double, Placement>> found;
    Vector3d low = all.front(), high = low;
    for (const Vector3d& p : all) low = low.cwiseMin(p), high = high.cwiseMax(p);
    cut_ = std::max(0.1, 0.25 * (high - low).norm());  // by what is seen: a tiny object must not be a cheap one
    points_ = thinned(all, kCoarsePoints);
    cloud_ = std::make_unique<CloudQuery>(point_rows(points_));
    for (const Placement& start : starts(all)) {
      Placement p = start;
      const double cost = descend(p, thinned(surface_, static_cast<size_t>(kCoarseSurface)), kCoarseRounds, 0.1).cost;
      found.emplace_back(cost, p);
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    points_ = thinned(all, kMostPoints);
    cloud_ = std::make_unique<CloudQuery>(point_rows(points_));
    Placement best;
    best_fit.cost = HUGE_VAL;
    for (size_t i = 0; i < std::min(kBest, found.size()); ++i) {
      Placement p = found[i].second;
      const Fit fit = descend(p, surface_, kFineRounds, kObjectLoss);
      if (fit.cost < best_fit.cost) best_fit = fit, best = p;
    }
    return best;
  }

 private:
  /// Yaws all around, each at the scales that the seen width, the seen height and the seen top above the floor tell.
  std::vector<Placement> starts(const std::vector<Vector3d>& all) const {
    Vector3d middle = Vector3d::Zero();
    std::vector<double> heights, across;
    for (const Vector3d& p : all) middle += p / static_cast<double>(all.size());
    for (const Vector3d& p : all) {
      heights.push_back(p.y());
      across.push_back(std::hypot(p.x() - middle.x(), p.z() - middle.z()));
    }
    const Vector3d size = high_ - low_, own_middle = 0.5 * (low_ + high_);
    const double top = quantile(heights, 0.98), bottom = quantile(heights, 0.02);
    const auto largest = [](double metres) { return std::max(metres, 0.02); };
    struct First {
      double scale;
      bool on_floor;
    };
    std::vector<First> firsts = {
        {largest(quantile(across, 0.95)) / (0.5 * std::hypot(size.x(), size.z())), bottom - floor_ < kStands}};
    if (size.y() > 0.05 * size.norm()) {
      firsts.push_back({largest(top - bottom) / size.y(), false});
      if (top > floor_) firsts.push_back({largest(top - floor_) / size.y(), true});
    }
    std::vector<Placement> out;
    for (const First& first : firsts)
      for (int i = 0; i < kYaws; ++i) {
        Placement p;
        p.scale = first.scale;
        p.yaw = 2 * M_PI * i / kYaws;
        p.shift = middle - p.place(own_middle);
        if (first.on_floor) p.shift.y() = floor_ - p.scale * low_.y();
        out.push_back(p);
      }
    return out;
  }

  Fit descend(Placement& p, const std::vector<Vector3d>& surface, int rounds, double loss) const {
    double damping = 1e-3;
    Fit fit = fit_at(p, surface, loss);
    for (int round = 0; round < rounds; ++round) {
      Matrix5d a = fit.a;
      a.diagonal() *= 1 + damping;
      a.diagonal().array() += 1e-12;
      const Vector5d step = -a.ldlt().solve(fit.b);
      if (!step.allFinite()) break;
      Placement next = p;
      next.scale *= std::exp(std::clamp(step[0], -0.3, 0.3));
      next.yaw += std::clamp(step[1], -0.3, 0.3);
      next.shift += Vector3d(step.tail<3>());
      const Fit there = fit_at(next, surface, loss);
      if (there.cost < fit.cost) {
        const double gain = (fit.cost - there.cost) / fit.cost;
        p = next;
        fit = there;
        damping = std::max(1e-6, damping / 3);
        if (gain < 1e-5) break;
      } else {
        damping *= 10;
        if (damping > 1e6) break;
      }
    }
    return fit;
  }

  /// Cost and equations by (ln scale, yaw, shift).
  Fit fit_at(const Placement& p, const std::vector<Vector3d>& surface, double loss) const {
    Fit fit;
    const auto add = [&](const Vector3d& direction, double r, double factor, const Vector3d& at) {
      const Vector3d arm = at - p.shift;
      Vector5d row;
      row << direction.dot(arm), direction.dot(Vector3d::UnitY().cross(arm)), direction;
      fit.a += factor * row * row.transpose();
      fit.b += factor * r * row;
    };
    const auto weigh = [&](double away, double each) {  // cost, and the factor of its row
      const double r = std::min(away, cut_);
      fit.cost += each * (r <= loss ? 0.5 * r * r : loss * (r - 0.5 * loss));
      return away > cut_ ? 0 : each * (away <= loss ? 1 : loss / away);
    };
    const Vector3d foot(p.shift.x(), p.scale * low_.y() + p.shift.y(), p.shift.z());
    const double above = foot.y() - floor_, standing = weigh(std::abs(above), 1);
    if (standing > 0) add(Vector3d::UnitY(), above, standing, foot);
    add_points(p, fit, weigh, add);
    add_surface(p, surface, weigh, add);
    return fit;
  }

  /// Seen points to the surface.
  template <class Weigh, class Add>
  void add_points(const Placement& p, Fit& fit, const Weigh& weigh, const Add& add) const {
    const Eigen::AngleAxisd rotation(p.yaw, Vector3d::UnitY());
    std::vector<Vector3d> own;
    own.reserve(points_.size());
    for (const Vector3d& point : points_) own.emplace_back((rotation.inverse() * (point - p.shift)) / p.scale);
    const ClosestPoints closest = query_.closest(point_rows(own));
    const auto at = closest.points.accessor<float, 2>(), normal = closest.normals.accessor<float, 2>();
    const double each = 1 / static_cast<double>(points_.size());
    std::vector<double> distances;
    distances.reserve(points_.size());
    for (size_t i = 0; i < points_.size(); ++i) {
      const auto k = static_cast<int64_t>(i);
      const Vector3d place = p.place({at[k][0], at[k][1], at[k][2]}), apart = place - points_[i];
      const double away = apart.norm();
      distances.push_back(away);
      const double factor = weigh(away, each);
      // On the surface the distance has no direction but the normal's.
      Vector3d direction = apart / std::max(away, 1e-12);
      if (away < 1e-4) direction = rotation * Vector3d(normal[k][0], normal[k][1], normal[k][2]);
      if (factor > 0) add(direction, away < 1e-4 ? direction.dot(apart) : away, factor, place);
    }
    fit.distance = quantile(distances, 0.5);
  }

  /// What the cameras see of the surface to the seen points.
  template <class Weigh, class Add>
  void add_surface(const Placement& p, const std::vector<Vector3d>& surface, const Weigh& weigh, const Add& add) const {
    std::vector<Vector3d> seen;
    for (size_t v = 0; v < seen_.views.size(); ++v) see(p, surface, v, seen);
    if (seen.empty()) {  // a surface that cannot be what is seen
      weigh(HUGE_VAL, 1);
      return;
    }
    const Neighbours near = cloud_->nearest(point_rows(seen));
    const auto index = near.indices.accessor<int64_t, 2>();
    const double each = 1 / static_cast<double>(seen.size());
    for (size_t i = 0; i < seen.size(); ++i) {
      const Vector3d apart = seen[i] - points_[static_cast<size_t>(index[static_cast<int64_t>(i)][0])];
      const double factor = weigh(apart.norm(), each);
      if (factor > 0)
        for (int k = 0; k < 3; ++k) add(Vector3d::Unit(k), apart[k], factor, seen[i]);
    }
  }

  /// Adds the places of the surface that view `v` sees, in the world.
  void see(const Placement& p, const std::vector<Vector3d>& surface, size_t v, std::vector<Vector3d>& seen) const {
    const View& view = *seen_.views[v];
    const Eigen::Isometry3d &to_world = camera_.pose(view.frame), to_camera = to_world.inverse();
    const auto depth = view.depth.accessor<float, 2>();
    const auto person = view.person.accessor<bool, 2>();
    const auto mask = seen_.masks[v].accessor<bool, 2>(), used = used_[v].accessor<bool, 2>();
    const Eigen::AngleAxisd rotation(p.yaw, Vector3d::UnitY());
    const Vector3d eye = (rotation.inverse() * (to_world.translation() - p.shift)) / p.scale;
    std::vector<Vector3d> rays, places, own;
    for (const Vector3d& x : surface) {
      const Vector3d place = p.place(x);
      const OnImage at = project(camera_, to_camera, place);
      if (!at.inside() || person[at.row][at.column]) continue;
      const double d = depth[at.row][at.column];
      // No points are of the mask's rim: what is seen there would draw the object in, to the points inside.
      if (mask[at.row][at.column] && !used[at.row][at.column]) continue;
      // Nothing known there, or something else is before it.
      if (!mask[at.row][at.column] && (d <= 0 || d < at.z - kHidden * (1 + at.z))) continue;
      places.push_back(place);
      rays.emplace_back(x - eye);
      own.push_back(x);
    }
    if (rays.empty()) return;
    const std::vector<Vector3d> from(rays.size(), eye);
    const torch::Tensor hits = query_.cast(point_rows(from), point_rows(rays)).points;
    const auto hit = hits.accessor<float, 2>();
    for (size_t i = 0; i < rays.size(); ++i) {
      const auto k = static_cast<int64_t>(i);
      if ((own[i] - Vector3d(hit[k][0], hit[k][1], hit[k][2])).norm() < kUnseenBehind * size())
        seen.push_back(places[i]);
    }
  }

  const ObjectViews& seen_;
  std::vector<torch::Tensor> used_;
  const Camera& camera_;
  double floor_;
  SceneQuery query_;
  double cut_ = 0;  // metres: an outlier costs no more than this
  std::vector<Vector3d> surface_, points_;
  Vector3d low_, high_;
  std::unique_ptr<CloudQuery> cloud_;
};

}  // namespace

Vector3d Placement::place(const Vector3d& own) const {
  return scale * (Eigen::AngleAxisd(yaw, Vector3d::UnitY()) * own) + shift;
}

PlacedObject place_object(const std::string& name, const std::vector<Mesh>& meshes, const ObjectViews& seen,
                          const Camera& camera, double floor) {
  PointGrid grid(kPointCell);
  std::vector<torch::Tensor> used;
  for (size_t v = 0; v < seen.views.size(); ++v) {
    used.push_back(eroded(seen.masks[v], 1).logical_and(dilated(seen.views[v]->person, 2).logical_not()));
    grid.add(*seen.views[v], used.back(), camera, name);
  }
  const std::vector<Vector3d> points = grid.points(1);
  if (points.size() < (seen.views.size() > 1 ? kFewestPoints : kFewestOfOneView))
    throw Error(name, "only " + std::to_string(points.size()) + " points of it are seen in its masks");
  int64_t faces = 0;
  double extent = 0;
  for (const Mesh& mesh : meshes) {
    faces += mesh.faces.size(0);
    if (mesh.vertices.size(0) > 0)
      extent = std::max(extent,
                        (std::get<0>(mesh.vertices.max(0)) - std::get<0>(mesh.vertices.min(0))).max().item<double>());
  }
  if (faces == 0) throw Error(name, "has no faces");
  if (!(extent > 0)) throw Error(name, "has no size");
  ObjectSearch search(meshes, seen, std::move(used), camera, floor);
  PlacedObject out;
  out.name = name;
  Fit fit;
  out.placement = search.search(points, fit);
  out.placement.yaw = std::remainder(out.placement.yaw, 2 * M_PI);
  out.distance = fit.distance;
  out.points = static_cast<int64_t>(points.size());
  for (size_t i = 0; i < meshes.size(); ++i) {
    Mesh mesh = meshes[i];
    mesh.name = i == 0 ? name : name + "." + std::to_string(i);
    mesh.vertices = meshes[i].vertices.clone();
    auto v = mesh.vertices.accessor<float, 2>();
    for (int64_t k = 0; k < v.size(0); ++k) {
      const Vector3d at = out.placement.place({v[k][0], v[k][1], v[k][2]});
      for (int c = 0; c < 3; ++c) v[k][c] = static_cast<float>(at[c]);
    }
    out.meshes.push_back(std::move(mesh));
  }
  return out;
}

}  // namespace inhabit::reconstruct
