#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/scene.h"

namespace inhabit::python {
namespace {

using torch::Tensor;

Mesh make_mesh(const Floats& vertices, const Longs& faces, const std::string& name,
               const std::optional<std::array<float, 3>>& color) {
  if (vertices.dim() != 2 || vertices.size(1) != 3) throw Error("vertices", "are not (V, 3)");
  if (faces.dim() != 2 || faces.size(1) != 3) throw Error("faces", "are not (F, 3)");
  if (!torch::isfinite(vertices).all().item<bool>()) throw Error("vertices", "have a value that is not finite");
  if (faces.numel() > 0 && (faces.min().item<int64_t>() < 0 || faces.max().item<int64_t>() >= vertices.size(0)))
    throw Error("faces", "name a vertex that is not there");
  Mesh out;
  out.name = name;
  out.vertices = vertices;
  out.faces = faces;
  if (color) out.color = *color;
  return out;
}

void set_points(Scene& scene, const std::optional<Floats>& points) {
  if (points && (points->dim() != 2 || points->size(1) != 3)) throw Error("points", "are not (N, 3)");
  if (points && !torch::isfinite(*points).all().item<bool>()) throw Error("points", "have a value that is not finite");
  scene.points = points && points->size(0) > 0 ? Tensor(*points) : Tensor();
}

Scene make_scene(std::vector<Mesh> meshes, const std::optional<Floats>& points, const std::string& name) {
  Scene out{name, std::move(meshes), {}};
  set_points(out, points);
  return out;
}

std::string text_of_scene(const Scene& scene) {
  return "<inhabit.Scene: " + std::to_string(scene.meshes.size()) + " meshes, " +
         std::to_string(scene.points.defined() ? scene.points.size(0) : 0) + " points>";
}

}  // namespace

void add_scenes(py::module_& m) {
  py::class_<Mesh>(m, "Mesh", "A triangle mesh in world coordinates, metres, +Y up.")
      .def(py::init(&make_mesh), "vertices"_a, "faces"_a, py::kw_only(), "name"_a = "mesh", "color"_a = py::none(),
           "vertices: (V, 3) metres; faces: (F, 3) indices, counter-clockwise seen from outside; name: of the object,\n"
           "where 'floor' is what nothing collides with; color: linear RGB, 0 to 1.")
      .def_readonly("name", &Mesh::name, "Name of the object it is part of.")
      .def_property_readonly(
          "vertices", [](const Mesh& mesh) { return mesh.vertices; }, "(V, 3) float32, metres.")
      .def_property_readonly(
          "faces", [](const Mesh& mesh) { return mesh.faces; }, "(F, 3) int64.")
      .def_readonly("color", &Mesh::color, "Linear RGB.")
      .def("__repr__", [](const Mesh& mesh) {
        return "<inhabit.Mesh '" + mesh.name + "': " + std::to_string(mesh.vertices.size(0)) + " vertices, " +
               std::to_string(mesh.faces.size(0)) + " faces>";
      });
  py::class_<Scene>(m, "Scene", "What a person moves in: meshes, points of a scan, or both. Metres, world, +Y up.")
      .def(py::init(&make_scene), "meshes"_a = std::vector<Mesh>(), py::kw_only(), "points"_a = py::none(),
           "name"_a = "", "meshes: list of Mesh; points: (N, 3) metres of a point cloud.")
      .def_readwrite("name", &Scene::name, "What errors call it.")
      .def_readwrite("meshes", &Scene::meshes, "The meshes, as a list; assign a list to change it.")
      .def_property(
          "points", [](const Scene& scene) { return scene.points; }, &set_points,
          "(N, 3) float32, metres, or None where there is no point cloud.")
      .def_property_readonly("empty", &Scene::empty, "Whether there is neither a mesh nor a point.")
      .def_property_readonly(
          "objects",
          [](const Scene& scene) {
            std::vector<std::string> names;
            for (const Mesh& mesh : scene.meshes)
              if (const std::string name = object_of_mesh(mesh.name);
                  std::find(names.begin(), names.end(), name) == names.end())
                names.push_back(name);
            return names;
          },
          "Names of the objects: 'chair_0' is all meshes called so, or 'chair_0.1', 'chair_0.2', ...")
      .def("__repr__", &text_of_scene);
  m.def("floor_scene", &floor_scene, "size"_a = 12.0, "x"_a = 0.0, "z"_a = 0.0,
        "A flat floor, y = 0, `size` metres on a side around (x, z): what is assumed where no scene is given.");
}

}  // namespace inhabit::python
