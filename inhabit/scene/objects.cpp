#include "inhabit/scene/objects.h"

#include <Eigen/Core>
#include <algorithm>
#include <mutex>
#include <utility>

#include "inhabit/lower_case.h"
#include "inhabit/scene/query.h"

namespace inhabit {
namespace {

bool is_number(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// Lower and upper corner of what its vertices span.
std::pair<Eigen::Vector3f, Eigen::Vector3f> box_of(const Mesh& mesh) {
  const torch::Tensor vertices = mesh.vertices.contiguous();
  const Eigen::Map<const Eigen::Matrix3Xf> columns(vertices.data_ptr<float>(), 3, vertices.size(0));
  return {columns.rowwise().minCoeff(), columns.rowwise().maxCoeff()};
}

}  // namespace

std::string object_of_mesh(const std::string& mesh_name) {
  const size_t dot = mesh_name.rfind('.');
  if (dot == std::string::npos || !is_number(mesh_name.substr(dot + 1))) return mesh_name;
  // "chair.001" is how modellers call a copy, which is another chair.
  const bool copy = mesh_name.size() - dot - 1 >= 3;
  return copy ? mesh_name : mesh_name.substr(0, dot);
}

bool is_floor(const std::string& mesh_name) {
  const size_t dot = mesh_name.rfind('.');
  const bool numbered = dot != std::string::npos && is_number(mesh_name.substr(dot + 1));
  const std::string object = lower_case(numbered ? mesh_name.substr(0, dot) : mesh_name);
  return object == "floor" || object == "rug" || object == "ground" || object == "carpet";
}

std::vector<std::string> object_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const Mesh& mesh : scene.meshes) {
    const std::string name = object_of_mesh(mesh.name);
    if (!is_floor(mesh.name) && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

Scene obstacles_of(const Scene& scene, const std::string& without) {
  Scene out;
  out.name = scene.name;
  for (const Mesh& mesh : scene.meshes)
    if (!is_floor(mesh.name) && (without.empty() || object_of_mesh(mesh.name) != without)) out.meshes.push_back(mesh);
  return out;
}

Scene rooms_looking_in(Scene scene, const torch::Tensor& people) {
  const std::vector<size_t> turned = Rooms(scene).turned_for(people);
  return turned_inside_out(std::move(scene), turned);
}

Scene turned_inside_out(Scene scene, const std::vector<size_t>& meshes) {
  for (const size_t m : meshes) {
    torch::Tensor& faces = scene.meshes[m].faces;
    faces = faces.index_select(1, torch::tensor({0, 2, 1})).contiguous();
  }
  return scene;
}

/// A mesh as large as a room.
struct Rooms::Room {
  size_t number = 0;        // among the scene's meshes
  Scene alone;              // it and nothing else
  torch::Tensor low, high;  // (3) corners of its box
  std::once_flag asked;
  std::unique_ptr<SceneQuery> query;

  bool holds_most_of(const torch::Tensor& people) {
    const auto most_of = [](const torch::Tensor& flags) {
      return flags.to(torch::kFloat32).mean().item<double>() > 0.5;
    };
    if (!most_of(torch::logical_and(people > low, people < high).all(1))) return false;
    std::call_once(asked, [&] { query = std::make_unique<SceneQuery>(alone); });
    return most_of(query->inside(people));
  }
};

Rooms::Rooms(const Scene& scene) {
  for (size_t m = 0; m < scene.meshes.size(); ++m) {
    const Mesh& mesh = scene.meshes[m];
    if (mesh.vertices.numel() == 0 || mesh.faces.numel() == 0) continue;
    const auto [lower, upper] = box_of(mesh);
    if (!((upper - lower).array() > Eigen::Array3f(1.5F, 1.8F, 1.5F)).all()) continue;
    const auto row = [](const Eigen::Vector3f& p) { return torch::tensor({p.x(), p.y(), p.z()}); };
    auto room = std::make_unique<Room>();
    room->number = m;
    room->alone.meshes.push_back(mesh);
    room->low = row(lower);
    room->high = row(upper);
    rooms_.push_back(std::move(room));
  }
}

Rooms::~Rooms() = default;

std::vector<size_t> Rooms::turned_for(const torch::Tensor& people) const {
  std::vector<size_t> out;
  for (const std::unique_ptr<Room>& room : rooms_)
    if (room->holds_most_of(people)) out.push_back(room->number);
  return out;
}

Scene without_ground(Scene scene, double floor) {
  constexpr float kGround = 0.04F, kUp = 0.7F;
  const float ground = static_cast<float>(floor) + kGround;
  for (Mesh& mesh : scene.meshes) {
    if (mesh.faces.numel() == 0) continue;
    const torch::Tensor corners =
        mesh.vertices.index_select(0, mesh.faces.flatten()).view({-1, 3, 3});  // (F, corner, xyz)
    const torch::Tensor normal =
        torch::cross(corners.select(1, 1) - corners.select(1, 0), corners.select(1, 2) - corners.select(1, 0), 1);
    const torch::Tensor up = normal.select(1, 1) > kUp * normal.norm(2, 1),
                        low = std::get<0>(corners.select(2, 1).max(1)) < ground;
    const torch::Tensor dropped = torch::logical_and(up, low);
    if (dropped.any().item<bool>())
      mesh.faces = mesh.faces.index_select(0, torch::logical_not(dropped).nonzero().flatten());
  }
  if (scene.points.defined() && scene.points.numel() > 0)
    scene.points = scene.points.index_select(0, (scene.points.select(1, 1) >= ground).nonzero().flatten());
  return scene;
}

}  // namespace inhabit
