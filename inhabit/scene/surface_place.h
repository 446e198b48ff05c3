#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

#include "inhabit/scene/query.h"

namespace inhabit {

/// A place on a surface, near to a point.
struct SurfacePlace {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();            ///< metres, world
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();           ///< unit, of the face, as the file has it
  double distance = std::numeric_limits<double>::infinity();  ///< metres from that point, not negative
};

/// The places of a surface nearest to each of `points` (world, metres).
std::vector<SurfacePlace> nearest_places(const SceneQuery& surface, const std::vector<Eigen::Vector3d>& points);

}  // namespace inhabit
