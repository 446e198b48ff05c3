#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/scene/basis_points.h"
#include "inhabit/scene/contact_map.h"
#include "inhabit/scene/distance_field.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/occupancy.h"
#include "inhabit/scene/query.h"
#include "inhabit/scene/sampling.h"
#include "inhabit/scene/walk_path.h"

namespace inhabit::python {
namespace {

using torch::Tensor;

const Floats& points_checked(const Floats& points, const char* name) {
  if (points.dim() != 2 || points.size(1) != 3) throw Error(name, "are not (N, 3)");
  return points;
}

/// A query that may be shared with a field over it.
using SharedQuery = std::shared_ptr<SceneQuery>;

struct Field {
  SharedQuery query;
  DistanceField field;
};

/// Distances (N) and, where wanted, their gradients (N, 3).
std::pair<Tensor, Tensor> field_at(const Field& of, const Floats& points) {
  points_checked(points, "points");
  const int64_t count = points.size(0);
  Tensor distances = torch::empty({count}), gradients = torch::empty({count, 3});
  const float* at = points.data_ptr<float>();
  for (int64_t i = 0; i < count; ++i) {
    Eigen::Vector3d up;
    distances.data_ptr<float>()[i] =
        static_cast<float>(of.field.distance(Eigen::Vector3d(at[3 * i], at[3 * i + 1], at[3 * i + 2]), &up));
    for (int a = 0; a < 3; ++a) gradients.data_ptr<float>()[3 * i + a] = static_cast<float>(up[a]);
  }
  return {distances, gradients};
}

Tensor path_between(const Scene& scene, const std::array<double, 2>& from, const std::array<double, 2>& to,
                    double margin) {
  const auto path = find_path(free_space(obstacles_of(scene)), {from[0], from[1]}, {to[0], to[1]}, margin);
  if (!path) return {};
  Tensor out = torch::empty({static_cast<int64_t>(path->points.size()), 2});
  for (size_t i = 0; i < path->points.size(); ++i)
    for (int a = 0; a < 2; ++a)
      out.data_ptr<float>()[2 * i + static_cast<size_t>(a)] = static_cast<float>(path->points[i][a]);
  return out;
}

void add_results(py::module_& m) {
  py::class_<ClosestPoints>(m, "ClosestPoints",
                            "The places of a scene nearest to N points; NaN and -1 for points that are not finite.")
      .def_property_readonly(
          "points", [](const ClosestPoints& c) { return c.points; }, "(N, 3) float32, metres.")
      .def_property_readonly(
          "distances", [](const ClosestPoints& c) { return c.distances; }, "(N) float32, metres, not negative.")
      .def_property_readonly(
          "normals", [](const ClosestPoints& c) { return c.normals; },
          "(N, 3) float32, unit normals; 0 for points of a cloud.")
      .def_property_readonly(
          "mesh", [](const ClosestPoints& c) { return c.mesh; },
          "(N) int64, index into scene.meshes; -1: a point of the cloud.")
      .def_property_readonly(
          "face", [](const ClosestPoints& c) { return c.face; },
          "(N) int64, index into that mesh's faces, or into scene.points.");
  py::class_<RayHits>(m, "RayHits", "What N rays meet first; rows without a hit hold infinity, 0 and -1.")
      .def_property_readonly(
          "hit", [](const RayHits& h) { return h.hit; }, "(N) bool.")
      .def_property_readonly(
          "distances", [](const RayHits& h) { return h.distances; }, "(N) float32, metres along the ray.")
      .def_property_readonly(
          "points", [](const RayHits& h) { return h.points; }, "(N, 3) float32, metres.")
      .def_property_readonly(
          "normals", [](const RayHits& h) { return h.normals; }, "(N, 3) float32, unit normals.")
      .def_property_readonly(
          "mesh", [](const RayHits& h) { return h.mesh; }, "(N) int64, index into scene.meshes.")
      .def_property_readonly(
          "face", [](const RayHits& h) { return h.face; }, "(N) int64, index into that mesh's faces.");
}

void add_scene_query(py::module_& m) {
  py::class_<SceneQuery, SharedQuery>(m, "SceneQuery",
                                      "Where a scene's surfaces are, asked many points at a time: points are (N, 3) "
                                      "metres, world. Later changes of the\n"
                                      "scene are not seen. Safe to use from several threads.")
      .def(py::init(
               [](const Scene& scene) { return released([scene] { return std::make_shared<SceneQuery>(scene); }); }),
           "scene"_a)
      .def(
          "closest",
          [](const SceneQuery& query, const Floats& points) {
            points_checked(points, "points");
            return released([&] { return query.closest(points); });
          },
          "points"_a, "The nearest places of the surfaces and the cloud.")
      .def(
          "signed_distance",
          [](const SceneQuery& query, const Floats& points) {
            points_checked(points, "points");
            return released([&] { return query.signed_distance(points); });
          },
          "points"_a, "(N) float32, metres to the nearest surface, negative inside.")
      .def(
          "inside",
          [](const SceneQuery& query, const Floats& points) {
            points_checked(points, "points");
            return released([&] { return query.inside(points); });
          },
          "points"_a, "(N) bool: by winding numbers, so that open and overlapping meshes have an inside too.")
      .def(
          "cast",
          [](const SceneQuery& query, const Floats& origins, const Floats& directions, double max_distance) {
            points_checked(origins, "origins");
            if (points_checked(directions, "directions").size(0) != origins.size(0))
              throw Error("directions", "are not one for each origin");
            return released([&] { return query.cast(origins, directions, max_distance); });
          },
          "origins"_a, "directions"_a, "max_distance"_a = std::numeric_limits<double>::infinity(),
          "First hits from origins (N, 3) along directions (N, 3) of any length. Rays see triangles only.")
      .def(
          "occupancy",
          [](const SceneQuery& query, const Point& center, double heading, const std::array<int, 3>& cells,
             double cell) {
            return released([&] {
              return occupancy_grid(query.solid(), {center[0], center[1], center[2]}, heading, {cells, cell});
            });
          },
          "center"_a, "heading"_a = 0.0, "cells"_a = std::array<int, 3>{48, 24, 48}, "cell"_a = 0.1,
          "A grid of cubes of edge `cell` (metres) around `center`, turned by `heading` (radians about +Y): float32, 1 "
          "where\n"
          "the scene fills the cell, -1 where it is free. Axes: to the left, up, ahead.")
      .def(
          "basis_point_offsets",
          [](const SceneQuery& query, const Floats& anchors) {
            if (anchors.dim() < 2 || anchors.size(-1) != 3) throw Error("anchors", "are not (..., A, 3)");
            return released([&] { return basis_point_offsets(query, anchors); });
          },
          "anchors"_a,
          "From every anchor (..., A, 3), metres, to the nearest point of the scene (Prokudin et al. 2019).");
  py::class_<Field>(
      m, "DistanceField",
      "Signed distances on a grid, interpolated between its corners: for who asks often, or needs a gradient.")
      .def(py::init([](const SharedQuery& query, const Point& lower, const Point& upper, double cell) {
             const Eigen::AlignedBox3d box(Eigen::Vector3d(lower[0], lower[1], lower[2]),
                                           Eigen::Vector3d(upper[0], upper[1], upper[2]));
             return released([&] { return new Field{query, DistanceField(*query, box, cell)}; });
           }),
           py::arg("query").none(false), "lower"_a, "upper"_a, "cell"_a = 0.05,
           "query: a SceneQuery; lower, upper: corners of the box that the grid covers, metres; cell: edge, metres.")
      .def(
          "distance",
          [](const Field& field, const Floats& points) {
            return released([&] { return field_at(field, points).first; });
          },
          "points"_a, "(N) float32, metres, negative inside, of points (N, 3).")
      .def(
          "gradient",
          [](const Field& field, const Floats& points) {
            return released([&] { return field_at(field, points).second; });
          },
          "points"_a, "(N, 3) float32, of distance(); it jumps from cell to cell.");
  py::class_<CloudQuery>(m, "CloudQuery", "Nearest neighbours in a point cloud (M, 3), by a k-d tree built once.")
      .def(py::init([](const Floats& cloud) {
             points_checked(cloud, "cloud");
             return std::make_unique<CloudQuery>(cloud);
           }),
           "cloud"_a)
      .def(
          "nearest",
          [](const CloudQuery& query, const Floats& points, int64_t count) {
            points_checked(points, "points");
            const Neighbours found = released([&] { return query.nearest(points, count); });
            return std::pair(found.indices, found.distances);
          },
          "points"_a, "count"_a = 1,
          "Indices (N, count) int64 and distances (N, count), metres, of the nearest points of the cloud, nearest "
          "first.");
}

}  // namespace

void add_queries(py::module_& m) {
  add_results(m);
  add_scene_query(m);
  m.def(
      "contact_map",
      [](const Floats& joints, const Floats& points, double sigma) {
        points_checked(points, "points");
        if (joints.dim() < 2 || joints.size(-1) != 3) throw Error("joints", "are not (..., J, 3)");
        if (!(sigma > 0)) throw Error("sigma", "is not over 0");
        return released([&] { return contact_map(joints, points, sigma); });
      },
      "joints"_a, "points"_a, "sigma"_a = 0.2,
      "Contact maps (..., J, N) of joints (..., J, 3) and scene points (N, 3): exp(-d^2 / (2 sigma^2)), 1 where a "
      "joint\n"
      "touches a point (forecasting paper, Eq. 2). sigma: metres.");
  m.def(
      "sample_points",
      [](const Scene& scene, int64_t count, uint64_t seed, const std::optional<Floats>& near, double radius) {
        if (count < 1) throw Error("count", "is under 1");
        std::mt19937_64 random(seed);
        return released([&, scene] {
          return near ? sample_points_near(scene, *near, radius, count, random) : sample_points(scene, count, random);
        });
      },
      "scene"_a, "count"_a, "seed"_a = 1, py::kw_only(), "near"_a = py::none(), "radius"_a = 2.5,
      "`count` points (count, 3), metres, spread evenly over the scene's surfaces, or over what lies within `radius` "
      "metres\n"
      "of `near` (3).");
  m.def(
      "find_path",
      [](const Scene& scene, const std::array<double, 2>& start, const std::array<double, 2>& end, double margin) {
        return released([&, scene] { return path_between(scene, start, end, margin); });
      },
      "scene"_a, "start"_a, "end"_a, "margin"_a = 0.3,
      "A smooth path over the floor y = 0 from start (x, z) to end (x, z) that keeps about `margin` metres from "
      "everything:\n"
      "(K, 2) float32, points 2 cm apart; None where there is none.");
  m.def(
      "floor_height",
      [](const Clip& clip, const SceneQuery& query) {
        if (clip.skeleton.names != standard_joint_names())
          throw Error("clip", "is not on the standard skeleton: retarget it");
        return released([&, clip] { return floor_under(clip, query); });
      },
      "clip"_a, "query"_a, "Height of what a person's feet stand on in a scene, metres.");
}

}  // namespace inhabit::python
