#pragma once
#include <string>
#include <vector>

#include "inhabit/metrics/collision.h"

namespace inhabit {

/// What of a scene a body is deepest in.
struct Immersion {
  int64_t frame = 0;   ///< of the motion
  double depth = 0;    ///< metres that the deepest vertex that collides is inside; 0: none does
  std::string object;  ///< its name (scene/objects.h)

  /// "66 mm in table_0"; empty where depth is 0.
  std::string text() const;
};

/// For each of the frames the object that the deepest vertex that collides is in. Needs clip.rotations on the body's
/// joints.
std::vector<Immersion> immersions_of(const CollisionMeter& meter, const Clip& clip, const std::vector<int64_t>& frames);

/// For each stretch of frames in which the body is inside the scene, `collides` (T) bool, the deepest of some of them.
std::vector<Immersion> immersions_of_stretches(const CollisionMeter& meter, const Clip& clip,
                                               const torch::Tensor& collides);

}  // namespace inhabit
