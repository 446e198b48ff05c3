#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "inhabit/scene/scene.h"

namespace inhabit {

/// All triangles of a scene in one list, and what is inside them. Scenes found in the wild have open parts, parts that
/// run into each other, and faces with the wrong orientation; this decides which side of each face is outside:
/// - Faces that share an edge are made to agree; the larger part of a connected part's area decides for all of it.
/// - A closed part whose faces all look inwards is flipped, with two exceptions. One as large as a room
///   (1.5 x 1.8 x 1.5 m) stays: people walk about in it. One that lies in another part stays: it is a cavity.
/// A point is inside when the winding number around it exceeds one half for one *body*: a closed part with its
/// cavities, or all open parts of one mesh together. So bodies that overlap are one solid. A box without a lid holds
/// what is in it: seen from there, the lid would be less than half of all directions. A floor or a room's walls, which
/// look towards the people, hold nothing.
struct Solid {
  std::vector<Eigen::Vector3f> vertices;       ///< metres, world
  std::vector<std::array<uint32_t, 3>> faces;  ///< into vertices
  std::vector<int64_t> first_face;             ///< of each mesh of the scene, then one past the last
  std::vector<int8_t> outward;                 ///< a face: +1 its normal (right-hand rule) points out, -1 it points in
  std::vector<int32_t> body;                   ///< a face: number of its body
  int32_t bodies = 0;                          ///< how many there are
  std::vector<Eigen::Vector3f> points;         ///< the scene's point cloud; nothing is inside it

  /// Corner k (0 to 2) of a face, metres.
  Eigen::Vector3f corner(size_t face, size_t k) const { return vertices[faces[face][k]]; }
  /// True where a winding number exceeds one half: `windings` is the sum of what looks along `directions` directions
  /// counted for one body.
  static bool holds(int windings, int directions) { return 2 * windings > directions; }
  /// Not normalised: twice the face's area long.
  Eigen::Vector3f normal(size_t face) const {
    return (corner(face, 1) - corner(face, 0)).cross(corner(face, 2) - corner(face, 0));
  }
};

/// The solid of a scene: all its meshes and points, which are copied.
Solid make_solid(const Scene& scene);

}  // namespace inhabit
