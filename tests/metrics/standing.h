#pragma once
#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/shapes.h"

namespace inhabit {

/// The built-in body at rest, arms along x, feet on the floor, for some frames.
inline Clip standing(int64_t frames) {
  const BodyModel& body = builtin_body();
  Clip clip;
  clip.skeleton = shaped_skeleton(body, {});
  clip.rotations = torch::zeros({frames, kStandardJoints, 3});
  clip.trans = torch::zeros({frames, 3});
  clip.trans.select(1, 1).fill_(-body.template_vertices.select(1, 1).min().item<float>());
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

/// A box of `half` its size to each side.
inline Mesh block(const std::string& name, const Eigen::Vector3d& center, const Eigen::Vector3d& half) {
  MeshBuilder builder;
  builder.box(center, half);
  return builder.mesh(name, {1, 1, 1});
}

}  // namespace inhabit
