#pragma once
#include <Eigen/Geometry>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// A solid box of a piece of furniture or a wall, axis-aligned in its owner's frame. Metres.
struct Box {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< its middle
  Eigen::Vector3d half = Eigen::Vector3d::Zero();    ///< half its sides
};

/// A horizontal rectangle that a person can use, in its owner's frame: a seat, an arm rest, a table top, a shelf board.
struct Surface {
  /// What it is for.
  enum class Kind { seat, arm_rest_left, arm_rest_right, table, shelf, bed };
  Kind kind = Kind::seat;                            ///< what it is for
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< a point on the surface, metres
  double half_width = 0;                             ///< along the owner's x, metres
  double half_depth = 0;                             ///< along the owner's z, metres
};

/// A piece of furniture in its own frame: origin on the floor under its middle, front (the side one sits or stands at)
/// +Z, left of a person who sits in it is +X.
struct Furniture {
  std::string kind;  ///< "chair", "armchair", "stool", "sofa", "office_chair", "solid_chair", "table", "bed",
                     ///< "shelf", "post", "plant", "box", "screen"
  Eigen::Isometry3d pose =
      Eigen::Isometry3d::Identity();  ///< own frame to world; a rotation about +Y and a shift on the floor
  std::vector<Box> boxes;             ///< what is solid: collisions and the mesh agree with these
  std::vector<Surface> surfaces;      ///< a sofa has one seat for each cushion
  double back_height = 0;             ///< height of the back rest's top above the floor; 0 without one
  double back_z = 0;                  ///< own-frame z of the back rest's front face
  std::vector<Mesh> meshes;           ///< own frame, one for each material

  /// Smallest box in the own frame around all that is solid.
  Eigen::AlignedBox3d bounds() const;
  /// Puts the origin at (x, z) on the floor and rotates the front from +Z towards +X by `yaw` radians.
  void place(double x, double z, double yaw);
  /// Stretches the piece along its own axes; bevels go along.
  void rescale(const Eigen::Vector3d& factors);
};

// Pieces of random size, style and colour, with their own origin. Heights may be asked for, in metres.
Furniture make_chair(std::mt19937_64& random, std::optional<double> seat_height = {});     ///< without arms
Furniture make_armchair(std::mt19937_64& random, std::optional<double> seat_height = {});  ///< with arm rests
/// A seat without back and arms, 0.42 to 0.50 m high where no height is asked for.
Furniture make_stool(std::mt19937_64& random, std::optional<double> seat_height = {});
/// A seat on a column with five castors, some with arm rests and a rest for the head.
Furniture make_office_chair(std::mt19937_64& random, double seat_height);
/// A seat on a closed body with a back up to 20 cm deep: tubs, blocks, cisterns.
Furniture make_solid_chair(std::mt19937_64& random, double seat_height);
/// @param seats number of cushions side by side.
Furniture make_sofa(std::mt19937_64& random, int seats, std::optional<double> seat_height = {});
/// @param width, depth of the top, metres.
Furniture make_table(std::mt19937_64& random, double width, double depth, double height);
/// @param height of the blanket, metres; drawn where it is not given.
Furniture make_bed(std::mt19937_64& random, std::optional<double> height = {});
/// Boards between two sides, some bare and some full; only the bare ones are surfaces.
Furniture make_shelf(std::mt19937_64& random, std::optional<double> board_height = {});
Furniture make_post(std::mt19937_64& random);    ///< a lamp, a coat stand, a column: thin and high
Furniture make_plant(std::mt19937_64& random);   ///< in a pot
Furniture make_box(std::mt19937_64& random);     ///< a chest or a crate
Furniture make_screen(std::mt19937_64& random);  ///< a room divider: as high as a person or higher, thin along z

}  // namespace inhabit
