#include "inhabit/scene/surface_place.h"

#include "inhabit/scene/point_rows.h"

namespace inhabit {

std::vector<SurfacePlace> nearest_places(const SceneQuery& surface, const std::vector<Eigen::Vector3d>& points) {
  std::vector<SurfacePlace> out;
  if (points.empty()) return out;
  const ClosestPoints closest = surface.closest(point_rows(points));
  const float* distance = closest.distances.data_ptr<float>();
  out.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    out.push_back({row_point(closest.points, i), row_point(closest.normals, i), distance[i]});
  return out;
}

}  // namespace inhabit
