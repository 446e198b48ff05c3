#pragma once
#include <Eigen/Geometry>
#include <array>
#include <random>
#include <string>
#include <vector>

#include "inhabit/scene/scene.h"
#include "inhabit/synth/furniture.h"

namespace inhabit {

/// A furnished room: floor y = 0, walls around [-size.x/2, size.x/2] x [-size.z/2, size.z/2] with openings.
struct Room {
  Eigen::Vector2d size{4, 4};        ///< metres along x and z
  double height = 2.5;               ///< of the walls, metres
  std::vector<Box> walls;            ///< solid wall parts, world coordinates (openings left free)
  std::vector<Furniture> furniture;  ///< each with its place (Furniture::pose)
  std::vector<Mesh> decor;  ///< frames of openings and rugs, world coordinates: to look at, nothing one walks into
  std::array<float, 3> floor_color{0.45F, 0.30F, 0.18F};  ///< linear RGB
  std::array<float, 3> wall_color{0.80F, 0.77F, 0.70F};   ///< linear RGB

  /// Name of furniture[i] in the scene: its kind and its number among its kind, "chair_0".
  std::string object_name(size_t i) const;
  /// Floor, walls, furniture and decor as meshes. Names are "floor", "wall_0", ..., "chair_0", ...; further materials
  /// of a piece are "chair_0.1", "chair_0.2", ...
  Scene scene() const;
};

/// A random room, 3.5 to 8 m on a side: every piece of furniture is inside, none overlap, and one can walk to the
/// place before every seat from anywhere else on the floor.
Room make_room(std::mt19937_64& random);

/// A door or window in a wall of a room.
struct Opening {
  int side = 0;       ///< 0: the wall at -z, 1: +x, 2: +z, 3: -x
  double along = 0;   ///< metres along the wall from its middle to the opening's (see at_wall in layout.h)
  double half = 0;    ///< half its width, metres
  double low = 0;     ///< of its lower edge over the floor, metres
  double high = 0;    ///< of its upper edge
  bool door = false;  ///< else a window
};

/// Puts the four walls around `size` and the frames of their openings into `room`: one or two doors, one to three
/// windows.
std::vector<Opening> add_walls(Room& room, std::mt19937_64& random);
/// Random colours for floor and walls.
void paint(Room& room, std::mt19937_64& random);

}  // namespace inhabit
