#include "inhabit/interact/voxels.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

#include "inhabit/math/heading.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"

namespace inhabit::interact {
namespace {

using Eigen::AlignedBox3f;
using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

AlignedBox3f box_of(const torch::Tensor& vertices) {
  AlignedBox3f box;
  const torch::Tensor points = vertices.contiguous();
  const float* p = points.data_ptr<float>();
  for (int64_t i = 0; i < points.size(0); ++i, p += 3) box.extend(Vector3f(p[0], p[1], p[2]));
  return box;
}

torch::Tensor rows_of(const std::vector<Vector3f>& points) {
  torch::Tensor out = torch::empty({static_cast<int64_t>(points.size()), 3});
  float* o = out.data_ptr<float>();
  for (const Vector3f& p : points) {
    Eigen::Map<Vector3f>(o, 3) = p;
    o += 3;
  }
  return out;
}

}  // namespace

ChairGrid sense_chair(const Chair& chair, const Config& config) {
  ChairGrid grid;
  const Vector3d at = chair.frame.translation(), ahead = chair.frame.linear().col(2);
  grid.seat = {Vector2f(static_cast<float>(at.x()), static_cast<float>(at.z())),
               Vector2f(static_cast<float>(ahead.x()), static_cast<float>(ahead.z()))};
  const Eigen::Isometry3f world = chair.frame.cast<float>(), own = world.inverse();
  AlignedBox3f box;
  const torch::Tensor vertices = chair.mesh.vertices.contiguous();
  const float* v = vertices.data_ptr<float>();
  for (int64_t i = 0; i < vertices.size(0); ++i, v += 3) box.extend(own * Vector3f(v[0], v[1], v[2]));
  // What lies on a side of the box lies in a cell.
  box = AlignedBox3f(box.min() - Vector3f::Constant(0.001F), box.max() + Vector3f::Constant(0.001F));
  const int n = config.chair_grid;
  const Vector3f cell = box.sizes() / static_cast<float>(n);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      for (int z = 0; z < n; ++z) {
        const Vector3f step(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, static_cast<float>(z) + 0.5F);
        grid.centres.emplace_back(world * (box.min() + cell.cwiseProduct(step)));
      }
  Scene scene;
  scene.meshes = {chair.mesh};
  const SceneQuery query(scene);
  const torch::Tensor centres = rows_of(grid.centres);
  const torch::Tensor nearest = query.closest(centres).points.contiguous(),
                      inside = query.inside(centres).to(torch::kFloat).contiguous();
  const float* p = nearest.data_ptr<float>();
  for (size_t i = 0; i < grid.centres.size(); ++i, p += 3) {
    const Vector3f apart = world.linear().transpose() * (Vector3f(p[0], p[1], p[2]) - grid.centres[i]);
    const bool within = (apart.cwiseAbs().array() < 0.5F * cell.array() - 1e-5F).all();
    const float value = within ? std::max(0.F, 1 - apart.norm() / cell.maxCoeff()) : 0.F;
    grid.values.push_back(inside.data_ptr<float>()[i] > 0.5F ? 1.F : value);
  }
  return grid;
}

void chair_around(const ChairGrid& grid, const Place& root, float* out) {
  for (size_t i = 0; i < grid.centres.size(); ++i, out += 4) {
    Eigen::Map<Vector3f>(out, 3) = root.in(grid.centres[i]);
    out[3] = grid.values[i];
  }
}

struct Surroundings::Impl {
  Scene scene;
  std::vector<AlignedBox3f> objects;
  std::unique_ptr<SceneQuery> query;
  std::unique_ptr<DistanceField> field;
  mutable std::once_flag asked;
  mutable FreeSpace floor;
};

Surroundings::Surroundings(const Scene& scene, double cell) {
  auto impl = std::make_shared<Impl>();
  impl->scene = without_ground(obstacles_of(scene));
  Eigen::AlignedBox3d all;
  for (const Mesh& mesh : impl->scene.meshes) {
    if (mesh.faces.numel() == 0) continue;
    impl->objects.push_back(box_of(mesh.vertices));
    all.extend(impl->objects.back().cast<double>());
  }
  if (!impl->objects.empty()) {
    impl->query = std::make_unique<SceneQuery>(impl->scene);
    const Vector3d margin = Vector3d::Constant(0.3);
    impl->field = std::make_unique<DistanceField>(*impl->query,
                                                  Eigen::AlignedBox3d(all.min() - margin, all.max() + margin), cell);
  }
  impl_ = std::move(impl);
}

Surroundings::~Surroundings() = default;
Surroundings::Surroundings(Surroundings&&) noexcept = default;
Surroundings& Surroundings::operator=(Surroundings&&) noexcept = default;

Surroundings Surroundings::mirrored() const { return Surroundings(impl_, -side_); }

float Surroundings::distance(const Vector3f& point, float reach) const {
  const float limit = reach * reach;
  const Vector3f at(side_ * point.x(), point.y(), point.z());
  for (const AlignedBox3f& box : impl_->objects) {
    if (box.squaredExteriorDistance(at) >= limit) continue;
    return std::clamp(static_cast<float>(impl_->field->distance(at.cast<double>())), 0.F, reach);
  }
  return reach;
}

void Surroundings::prepare(const std::function<bool()>& stopped) const {
  constexpr double kBody = 2, kReach = 0.3;  // metres over the floor, and from a surface
  for (const AlignedBox3f& object : impl_->objects) {
    Eigen::AlignedBox3d box = object.cast<double>();
    box.min().array() -= kReach;
    box.max().array() += kReach;
    box.max().y() = std::min(box.max().y(), kBody);
    impl_->field->sample(box, stopped);
  }
}

const FreeSpace& Surroundings::floor() const {
  std::call_once(impl_->asked, [this] { impl_->floor = free_space(impl_->scene); });
  return impl_->floor;
}

bool Surroundings::anything_near(const Vector2f& position, float radius) const {
  const float at = side_ * position.x();
  return std::any_of(impl_->objects.begin(), impl_->objects.end(), [&](const AlignedBox3f& box) {
    const float x = std::max({box.min().x() - at, at - box.max().x(), 0.F});
    const float z = std::max({box.min().z() - position.y(), position.y() - box.max().z(), 0.F});
    return x * x + z * z < radius * radius;
  });
}

EgoGrid::EgoGrid(const Config& config) {
  const double spacing = kSize / (config.ego_rings - 1) / 2;
  radius_ = static_cast<float>(spacing * std::numbers::sqrt2 / 2);
  reach_ = static_cast<float>(kSize / 2) + radius_;
  for (int layer = 0; layer < config.ego_layers; ++layer)
    for (int ring = 0; ring < config.ego_rings; ++ring) {
      const long count = std::lround(2 * std::numbers::pi * ring);
      for (long k = 0; k < count; ++k) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(count);
        const Eigen::Vector2d at = spacing * ring * ahead_of(angle);
        points_.emplace_back(Vector3d(at.x(), spacing * layer, at.y()).cast<float>());
      }
    }
}

void EgoGrid::sense(const Surroundings& around, const Place& root, float* out) const {
  if (!around.anything_near(root.position, reach_)) {
    std::fill(out, out + points_.size(), 0.F);
    return;
  }
  for (const Vector3f& point : points_) *out++ = 1 - around.distance(root.out(point), radius_) / radius_;
}

}  // namespace inhabit::interact
