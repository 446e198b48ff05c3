#pragma once
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "inhabit/reconstruct/depth_map.h"
#include "inhabit/scene/scene.h"

namespace inhabit::reconstruct {

/// From an object's own axes to the world: x -> scale R_y(yaw) x + shift, yaw from +Z towards +X.
struct Placement {
  double scale = 1;                                 ///< metres a unit of the object's own
  double yaw = 0;                                   ///< radians
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< metres, where the object's own origin is in the world

  /// A point of the object in the world.
  Eigen::Vector3d place(const Eigen::Vector3d& own) const;
};

/// An object mesh with its place in the room.
struct PlacedObject {
  std::string name;          ///< as it was given
  std::vector<Mesh> meshes;  ///< in the world, named as the object
  Placement placement;       ///< of the meshes as they were given; yaw in [-pi, pi]
  double distance = 0;       ///< metres, from the object's points to its surface, median
  int64_t points = 0;        ///< of the object that were seen
};

/// An object as it is seen: its mask in some views.
struct ObjectViews {
  std::vector<const View*> views;    ///< frames that there is a mask of, or the mean of a standing camera's; metric
  std::vector<torch::Tensor> masks;  ///< (views) (height, width) bool
};

/// Scale, rotation about gravity and shift of an object's meshes (own axes, +Y up, any unit) that bring its surface to
/// the points P seen of it in metric depth: least Chamfer distance d(V, P) (supplement 8.1), V the points of the
/// surface that the cameras see, with a loss that outliers do not bear on. Points of V behind something nearer than
/// they are tell nothing. An object whose lowest point comes near the floor stands on it: that distance counts as much
/// as either side of the Chamfer distance, and nothing where it is large. Gauss-Newton from every 15 degrees and up to
/// three first scales, the best of which go on to the end. The same input gives the same place. @param floor metres,
/// height. Throws Error(name, ...) where fewer than 25 points of the object are seen or a mesh has no surface.
PlacedObject place_object(const std::string& name, const std::vector<Mesh>& meshes, const ObjectViews& seen,
                          const Camera& camera, double floor);

}  // namespace inhabit::reconstruct
