#pragma once
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit::interact {

/// Something to sit on, and how one sits on it.
struct Chair {
  std::string name;  ///< the object's, "armchair_0"
  Mesh mesh;         ///< world, metres
  /// Of the seat to the world, a rotation about +Y: the origin is on the floor below where the pelvis comes to rest, +Z
  /// the way a seated person faces, +X to their left.
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  double seat_height = 0;  ///< metres over the floor
  double right_end = 0;    ///< metres along +X to where one can sit just as well; 0 on seats narrower than 1 m
  double left_end = 0;     ///< likewise, to the other side; not under right_end

  double heading() const;  ///< of a seated person, radians from +Z towards +X
  /// Where the pelvis comes to rest, on the seat's surface: the goal of sitting down.
  Eigen::Vector3d seat() const;
  /// From the place on the seat that is nearest to a pelvis (world) to the pelvis: metres, in the axes of `frame`.
  Eigen::Vector3d off(const Eigen::Vector3d& pelvis) const;
};

/// Seats are this high over the floor, metres.
inline constexpr double kLowestSeat = 0.25,  ///< at least
    kHighestSeat = 0.75;                     ///< at most

/// The chair of this name in a scene. Its seat is the nearly level area that holds the largest disc, seen from above; a
/// seated person faces away from what is higher behind it, or, without a back rest, the side with most free floor.
/// @param force takes seats of any height. Throws Error(scene, ...) where there is no such object, naming those there
/// are, and Error(name, ...) where it has no seat, where it is too low or too high, or upside down.
/// "chair" stands for "chair.001" as well where that is the only copy; of several Error names them.
Chair find_chair(const Scene& scene, const std::string& name, bool force = false);

/// The same chair, sat on as near to a place (x, z) as one can: seats wider than 1 m are sat on to the side of their
/// middle as well, at least 0.35 m from their ends.
Chair nearest_place(const Chair& chair, const Eigen::Vector2d& to);

/// All that can be sat on, in the scene's order: seats of 0.3 to 0.6 m. Low tables and what else has another name are
/// left out where there is a seat beside.
std::vector<Chair> find_chairs(const Scene& scene);

/// The chair below a point (metres, world) with its place and heading given: any part of a sofa or bed. Throws Error
/// where nothing is there, or too high or low.
Chair chair_at(const Scene& scene, const Eigen::Vector3d& point, double heading, bool force = false);

/// The chair that the person of a recording sits on first, its seat where the pelvis rests: the object that
/// Clip::object_pose places gives the heading, else the person does. Nothing where nobody sits (Clip::contact of the
/// pelvis).
std::optional<Chair> chair_of(const Clip& clip, const Scene& scene);

}  // namespace inhabit::interact
