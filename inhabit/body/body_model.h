#pragma once
#include <torch/types.h>

#include <array>
#include <string>
#include <vector>

#include "inhabit/body/skeleton.h"

namespace inhabit {

/// A capsule fixed to a joint's frame, for collisions. Metres, in the joint's frame of the mean shape.
struct Capsule {
  int joint = 0;             ///< whose frame it is in
  std::array<float, 3> a{};  ///< one end of its axis
  std::array<float, 3> b{};  ///< the other end
  float radius = 0;          ///< around the axis and both ends
};

/// A skinned body with linear shape space. The built-in body and SMPL, SMPL-H and SMPL-X files all become one of these.
struct BodyModel {
  std::string name;                 ///< "inhabit", "smpl", "smplh", "smplx"
  Skeleton skeleton;                ///< of the mean shape; the first 22 joints are the standard ones
  torch::Tensor template_vertices;  ///< (V, 3) metres, mean shape at rest
  torch::Tensor shape_dirs;         ///< (V, 3, B) metres per unit of betas
  torch::Tensor joint_template;     ///< (J, 3) metres, rest joints of the mean shape
  torch::Tensor joint_dirs;         ///< (J, 3, B) metres per unit of betas
  torch::Tensor pose_dirs;          ///< (V, 3, 9 (J-1)) pose blend shapes; undefined where the model has none
  torch::Tensor skin_weights;       ///< (V, J), rows sum to 1
  torch::Tensor faces;              ///< (F, 3) int64, counter-clockwise seen from outside
  torch::Tensor joint_limits;       ///< (J, 3, 2) radians: lowest and highest of each axis-angle component
  torch::Tensor anchors;            ///< (64) int64 vertex indices by furthest point sampling at rest
  std::vector<Capsule> capsules;    ///< the body's volume, coarsely; a file's body has those of the built-in one

  /// J.
  int joints() const { return skeleton.size(); }
  /// B, the number of shape parameters.
  int64_t betas() const { return shape_dirs.size(2); }
};

/// The body that ships with inhabit: 22 standard joints, a watertight mesh, shape parameters for stature, limb lengths
/// and girth (docs/body.md says which beta is which). Built once, then shared.
const BodyModel& builtin_body();

/// The built-in body on the bones of a standard skeleton, which betas do not change. Throws Error for other skeletons.
BodyModel body_on(const Skeleton& skeleton);

/// The skeleton of `model` with shape `betas` (B'), B' <= B; an undefined tensor means the mean shape.
Skeleton shaped_skeleton(const BodyModel& model, const torch::Tensor& betas);

}  // namespace inhabit
