#include "inhabit/interact/insides.h"

#include <algorithm>
#include <cmath>

namespace inhabit::interact {
namespace {

constexpr double kCell = 0.025, kMostCells = 2e6, kAroundScene = 0.05;  // metres, and a bound on memory

torch::Tensor chosen_rows(const torch::Tensor& points, const std::vector<int64_t>& rows) {
  return points.index_select(0, torch::tensor(rows)).contiguous();
}

}  // namespace

Insides::Insides(const Scene& scene) {
  Scene solid;
  for (const Mesh& mesh : scene.meshes)
    if (mesh.faces.numel() > 0) solid.meshes.push_back(mesh);
  if (solid.meshes.empty()) return;
  query_ = std::make_unique<SceneQuery>(solid);
  for (const Mesh& mesh : solid.meshes) {
    const torch::Tensor low = std::get<0>(mesh.vertices.min(0)).contiguous(),
                        high = std::get<0>(mesh.vertices.max(0)).contiguous();
    box_.extend(Eigen::Map<const Eigen::Vector3f>(low.data_ptr<float>()));
    box_.extend(Eigen::Map<const Eigen::Vector3f>(high.data_ptr<float>()));
  }
  Eigen::AlignedBox3d grown = box_.cast<double>();
  grown.min().array() -= kAroundScene;
  grown.max().array() += kAroundScene;
  field_ = std::make_unique<DistanceField>(*query_, grown, std::max(kCell, std::cbrt(grown.volume() / kMostCells)));
}

Insides::Deep Insides::deep(const torch::Tensor& points) const {
  Deep out;
  if (query_ == nullptr) return out;
  std::vector<int64_t> maybe;
  const float* p = points.data_ptr<float>();
  for (int64_t i = 0; i < points.size(0); ++i, p += 3) {
    const Eigen::Map<const Eigen::Vector3f> point(p);
    if (box_.contains(Eigen::Vector3f(point)) && field_->inside(point) != false) maybe.push_back(i);
  }
  if (maybe.empty()) return out;
  const torch::Tensor near = chosen_rows(points, maybe);
  const torch::Tensor distance = query_->signed_distance(near).contiguous();
  const ClosestPoints closest = query_->closest(near);
  const float *d = distance.data_ptr<float>(), *q = closest.points.data_ptr<float>();
  for (size_t i = 0; i < maybe.size(); ++i) {
    if (d[i] >= 0) continue;
    out.rows.push_back(maybe[i]);
    out.depths.push_back(-static_cast<double>(d[i]));
    out.places.emplace_back(Eigen::Map<const Eigen::Vector3f>(q + 3 * i).cast<double>());
  }
  return out;
}

double Insides::deepest(const torch::Tensor& points) const {
  double most = 0;
  for (const double depth : deep(points).depths) most = std::max(most, depth);
  return most;
}

double Insides::least_distance(const torch::Tensor& points) const {
  constexpr size_t kAsked = 12;
  std::vector<std::pair<double, int64_t>> near;
  const float* p = points.data_ptr<float>();
  for (int64_t i = 0; i < points.size(0); ++i, p += 3)
    near.emplace_back(field_->distance(Eigen::Map<const Eigen::Vector3f>(p).cast<double>()), i);
  const size_t count = std::min(kAsked, near.size());
  std::partial_sort(near.begin(), near.begin() + static_cast<int64_t>(count), near.end());
  std::vector<int64_t> rows;
  for (size_t i = 0; i < count; ++i) rows.push_back(near[i].second);
  return query_->signed_distance(chosen_rows(points, rows)).min().item<double>();
}

}  // namespace inhabit::interact
