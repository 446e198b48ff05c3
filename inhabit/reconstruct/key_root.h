#pragma once
#include <Eigen/Core>
#include <vector>

#include "inhabit/reconstruct/visible_body.h"
#include "inhabit/scene/scene.h"

namespace inhabit::reconstruct {

/// Standard deviations of the four losses of supplement 8.2.
struct KeyRootOptions {
  double near = 0.15;     ///< metres: regularisation, distance of the root from its estimate
  double contact = 0.01;  ///< metres: contact, vertices in contact from the surface, and others inside it
  double change = 3;      ///< m/s^2: temporal smoothness, the root's acceleration
  double depth = 0.01;    ///< metres: depth matching, what the mean Chamfer distance is known to
};

/// Key frames with better places.
struct KeyRoots {
  std::vector<Eigen::Vector3d> moved;  ///< (keys) metres, of the root
  int64_t contacts = 0;                ///< vertices that were taken to be in contact
};

/// Finds the root's translation at key frames (supplement 8.2): least sum of
///   regularisation   |g_k - g_k^0|^2,
///   contact          squared distance from surfaces of vertices in contact, and depth of others inside,
///   smoothness       |g_(k+1) - 2 g_k + g_(k-1)|^2,
///   depth matching   Chamfer distance of visible vertices and the person's points,
/// each over its variance. Vertices in contact face an upward surface within 6 cm and are slower than 0.3 m/s. Depth
/// alone brings the body near first; contacts are then found twice. @param clouds (keys) what is seen of the person; a
/// key whose cloud has no points goes by the other terms. @param scene its meshes: floor and objects.
KeyRoots optimise_key_roots(const BodyInFrames& body, const torch::Tensor& betas, double rate,
                            const std::vector<int64_t>& keys, const std::vector<refine::DepthCloud>& clouds,
                            const Scene& scene, const KeyRootOptions& options = {});

}  // namespace inhabit::reconstruct
