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
  Eigen::Vector2d size{4, 4};  ///< metres along x and z
  double height = 2.5;
  std::vector<Box> walls;  ///< solid wall parts, world coordinates (openings left free)
  std::vector<Furniture> furniture;
  std::vector<Mesh> decor;  ///< frames of openings and rugs, world coordinates: to look at, nothing one walks into
  std::array<float, 3> floor_color{0.45F, 0.30F, 0.18F};
  std::array<float, 3> wall_color{0.80F, 0.77F, 0.70F};

  /// Name of furniture[i] in the scene: its kind and its number among its kind, "chair_0".
  std::string object_name(size_t i) const;
  /// Floor, walls, furniture and decor as meshes. Names are "floor", "wall_0", ..., "chair_0", ...; further materials
  /// of a piece are "chair_0.1", "chair_0.2", ...
  Scene scene() const;
};

/// A random room, 3.5 to 8 m on a side: every piece of furniture is inside, none overlap, and one can walk to the
/// place before every seat from anywhere else on the floor.
Room make_room(std::mt19937_64& random);

/// The four walls around `size` with at least one door and one window, and their frames, into `room`. Doors are at
/// `doors`, when it is not null: the point on the floor in the middle of each opening.
void add_walls(Room& room, std::mt19937_64& random, std::vector<Eigen::Vector2d>* doors = nullptr);

}  // namespace inhabit
