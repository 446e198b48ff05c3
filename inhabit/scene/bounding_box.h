#pragma once
#include <Eigen/Geometry>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// The box around all meshes and points of a scene, metres; empty where there are none.
Eigen::AlignedBox3d bounding_box(const Scene& scene);

/// A box as seen from above, (x, z).
inline Eigen::AlignedBox2d on_ground(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return {};
  return {Eigen::Vector2d(box.min().x(), box.min().z()), Eigen::Vector2d(box.max().x(), box.max().z())};
}

}  // namespace inhabit
