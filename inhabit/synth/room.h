#pragma once
#include <Eigen/Geometry>
#include <random>
#include <string>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// A solid box of a piece of furniture or a wall, axis-aligned in its owner's frame. Metres.
struct Box {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
};

/// A horizontal rectangle that a person can use, in its owner's frame: a seat, an arm rest, a table top, a shelf board.
struct Surface {
  enum class Kind { seat, arm_rest_left, arm_rest_right, table, shelf, bed };
  Kind kind = Kind::seat;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< a point on the surface, metres
  double half_width = 0;                             ///< along the owner's x, metres
  double half_depth = 0;                             ///< along the owner's z, metres
};

/// A piece of furniture in its own frame: origin on the floor under its middle, front (the side one sits or stands at)
/// +Z, left of a person who sits in it is +X.
struct Furniture {
  std::string kind;  ///< "chair", "armchair", "stool", "sofa", "table", "bed", "shelf"
  Eigen::Isometry3d pose =
      Eigen::Isometry3d::Identity();  ///< own frame to world; a turn about +Y and a shift on the floor
  std::vector<Box> boxes;             ///< what is solid: collisions and the mesh agree with these
  std::vector<Surface> surfaces;
  double back_height = 0;  ///< height of the back rest's top above the floor; 0 without one
  double back_z = 0;       ///< own-frame z of the back rest's front face
  Mesh mesh;               ///< world coordinates
};

/// A furnished room: floor y = 0, walls around [-size.x/2, size.x/2] x [-size.z/2, size.z/2] with openings.
struct Room {
  Eigen::Vector2d size{4, 4};  ///< metres along x and z
  double height = 2.5;
  std::vector<Box> walls;  ///< solid wall parts, world coordinates (openings left free)
  std::vector<Furniture> furniture;
  /// Floor, walls and furniture as meshes; mesh names are "floor", "wall_0", ..., "chair_0", ...
  Scene scene() const;
};

/// A random room: every piece of furniture inside, not overlapping, seats reachable on foot.
Room make_room(std::mt19937_64& random);

}  // namespace inhabit
