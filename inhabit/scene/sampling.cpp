#include "inhabit/scene/sampling.h"

#include <fmt/format.h>

#include <numeric>

#include "inhabit/error.h"
#include "inhabit/scene/triangle.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;

double uniform01(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

struct Triangle {
  Vector3d a, b, c;
  double area() const { return 0.5 * (b - a).cross(c - a).norm(); }
};

struct Sphere {
  Vector3d center = Vector3d::Zero();
  double radius = 0;
};

double squared_distance(const Vector3d& p, const Triangle& t) {
  return (closest_on_triangle<double>(p, t.a, t.b, t.c) - p).squaredNorm();
}

/// Calls use(triangle) for every triangle of the scene.
template <typename Use>
void each_triangle(const Scene& scene, const Use& use) {
  for (const Mesh& mesh : scene.meshes) {
    const torch::Tensor vertices = mesh.vertices.contiguous(), faces = mesh.faces.contiguous();
    const float* v = vertices.data_ptr<float>();
    const int64_t* f = faces.data_ptr<int64_t>();
    const auto corner = [&](int64_t i) { return Eigen::Map<const Eigen::Vector3f>(v + 3 * i).cast<double>(); };
    for (int64_t i = 0; i < faces.size(0); ++i)
      use(Triangle{corner(f[3 * i]), corner(f[3 * i + 1]), corner(f[3 * i + 2])});
  }
}

/// Triangles with running sums of their areas, to draw points from.
struct Surface {
  std::vector<Triangle> triangles;
  std::vector<double> area_up_to;

  void add(const Triangle& t) {
    const double area = t.area();
    if (!(area > 0)) return;
    triangles.push_back(t);
    area_up_to.push_back((area_up_to.empty() ? 0 : area_up_to.back()) + area);
  }
  Vector3d draw(std::mt19937_64& random) const {
    const double at = uniform01(random) * area_up_to.back();
    const auto found = std::upper_bound(area_up_to.begin(), area_up_to.end(), at) - area_up_to.begin();
    const Triangle& t = triangles[std::min(static_cast<size_t>(found), triangles.size() - 1)];
    double u = uniform01(random), v = uniform01(random);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    return t.a + u * (t.b - t.a) + v * (t.c - t.a);
  }
};

/// Adds what of a triangle may lie in the sphere: whole where it is inside or small, else by its quarters, so that most
/// of what is added lies in the sphere, however large the triangle is.
void add_clipped(const Triangle& t, const Sphere& sphere, Surface& surface) {
  const double r2 = sphere.radius * sphere.radius;
  if (squared_distance(sphere.center, t) > r2) return;
  const double farthest = std::max(
      {(t.a - sphere.center).squaredNorm(), (t.b - sphere.center).squaredNorm(), (t.c - sphere.center).squaredNorm()});
  const double edge = std::max({(t.b - t.a).squaredNorm(), (t.c - t.b).squaredNorm(), (t.a - t.c).squaredNorm()});
  if (farthest <= r2 || edge < r2 / 64) return surface.add(t);
  const Vector3d ab = (t.a + t.b) / 2, bc = (t.b + t.c) / 2, ca = (t.c + t.a) / 2;
  for (const Triangle& quarter : {Triangle{t.a, ab, ca}, {ab, t.b, bc}, {ca, bc, t.c}, {ab, bc, ca}}) {
    add_clipped(quarter, sphere, surface);
  }
}

void set_row(torch::Tensor& points, int64_t i, const Vector3d& p) {
  Eigen::Map<Eigen::Vector3f>(points.data_ptr<float>() + 3 * i) = p.cast<float>();
}

/// `count` of the given rows: distinct ones where there are enough, else every one, then any.
torch::Tensor draw_rows(const torch::Tensor& points, std::vector<int64_t> rows, int64_t count,
                        std::mt19937_64& random) {
  const auto n = static_cast<int64_t>(rows.size());
  torch::Tensor chosen = torch::empty({count}, torch::kInt64);
  int64_t* out = chosen.data_ptr<int64_t>();
  for (int64_t i = 0; i < count; ++i) {
    if (i >= n) {
      out[i] = rows[random() % rows.size()];
      continue;
    }
    std::swap(rows[static_cast<size_t>(i)], rows[static_cast<size_t>(i) + random() % static_cast<uint64_t>(n - i)]);
    out[i] = rows[static_cast<size_t>(i)];
  }
  return points.index_select(0, chosen);
}

[[noreturn]] void too_far(const std::string& scene, const Sphere& sphere, double nearest) {
  throw Error(
      scene,
      fmt::format("nothing of the scene lies within {:.2f} m of ({:.2f}, {:.2f}, {:.2f}); the nearest is {:.2f} m away",
                  sphere.radius, sphere.center.x(), sphere.center.y(), sphere.center.z(), nearest));
}

torch::Tensor cloud_points_near(const Scene& scene, const Sphere& sphere, int64_t count, std::mt19937_64& random) {
  const torch::Tensor cloud = scene.points.contiguous();
  std::vector<int64_t> near;
  double nearest = HUGE_VAL;
  for (int64_t i = 0; i < cloud.size(0); ++i) {
    const double d2 =
        (Eigen::Map<const Eigen::Vector3f>(cloud.data_ptr<float>() + 3 * i).cast<double>() - sphere.center)
            .squaredNorm();
    if (d2 <= sphere.radius * sphere.radius) near.push_back(i);
    nearest = std::min(nearest, d2);
  }
  if (near.empty()) too_far(scene.name, sphere, std::sqrt(nearest));
  return draw_rows(cloud, std::move(near), count, random);
}

}  // namespace

torch::Tensor sample_points(const Scene& scene, int64_t count, std::mt19937_64& random) {
  if (scene.meshes.empty() && scene.points.defined() && scene.points.size(0) > 0) {
    std::vector<int64_t> rows(static_cast<size_t>(scene.points.size(0)));
    std::iota(rows.begin(), rows.end(), 0);
    return draw_rows(scene.points, std::move(rows), count, random);
  }
  Surface surface;
  each_triangle(scene, [&](const Triangle& t) { surface.add(t); });
  if (surface.triangles.empty()) throw Error("scene '" + scene.name + "' has no surface to take points from");
  torch::Tensor points = torch::empty({count, 3});
  for (int64_t i = 0; i < count; ++i) set_row(points, i, surface.draw(random));
  return points;
}

torch::Tensor sample_points_near(const Scene& scene, const torch::Tensor& center, double radius, int64_t count,
                                 std::mt19937_64& random) {
  const torch::Tensor c = center.to(torch::kFloat64).contiguous();
  const Sphere sphere{Eigen::Map<const Vector3d>(c.data_ptr<double>()), radius};
  if (!sphere.center.allFinite() || !(radius > 0))
    throw Error("points are asked for around a place that is not finite");
  if (scene.meshes.empty() && scene.points.defined() && scene.points.size(0) > 0) {
    return cloud_points_near(scene, sphere, count, random);
  }
  Surface surface;
  double nearest = HUGE_VAL;
  each_triangle(scene, [&](const Triangle& t) {
    // A bounding sphere around the first corner sends most triangles of a large scene away cheaply.
    const double size = std::sqrt(std::max((t.b - t.a).squaredNorm(), (t.c - t.a).squaredNorm()));
    const double at_least = (t.a - sphere.center).norm() - size;
    if (at_least > radius && at_least >= nearest) return;
    nearest = std::min(nearest, std::sqrt(squared_distance(sphere.center, t)));
    add_clipped(t, sphere, surface);
  });
  if (nearest == HUGE_VAL) throw Error("scene '" + scene.name + "' has no surface to take points from");
  if (surface.triangles.empty()) too_far(scene.name, sphere, nearest);
  torch::Tensor points = torch::empty({count, 3});
  int64_t found = 0;
  // A surface that only just reaches into the sphere may need many tries; repeat what was found rather than go on for
  // ever.
  for (int64_t tries = 1000 * count + 100000; found < count && tries > 0; --tries) {
    const Vector3d p = surface.draw(random);
    if ((p - sphere.center).squaredNorm() <= radius * radius) set_row(points, found++, p);
  }
  if (found == 0) too_far(scene.name, sphere, nearest);
  for (int64_t i = found; i < count; ++i) points[i] = points[i - found];
  return points;
}

}  // namespace inhabit
