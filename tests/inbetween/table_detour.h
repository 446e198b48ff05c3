#pragma once
#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/shapes.h"

namespace inhabit::inbetween {

using torch::Tensor;

// Metres, the table about the origin.
inline constexpr double kTableWidth = 1.2, kTableDepth = 0.7, kTableTop = 0.75, kTopThickness = 0.04;
inline constexpr double kAway = 1.2;  // of the person from the table's middle, along z

inline Scene table_room() {
  Scene room = floor_scene();
  MeshBuilder table;
  const double w = kTableWidth / 2, d = kTableDepth / 2, t = kTopThickness / 2;
  table.box({0, kTableTop - t, 0}, {w, t, d});
  for (const double x : {-w + 0.05, w - 0.05})
    for (const double z : {-d + 0.05, d - 0.05}) table.box({x, kTableTop / 2 - t, z}, {0.03, kTableTop / 2 - t, 0.03});
  room.meshes.push_back(table.mesh("table", {0.5F, 0.35F, 0.2F}));
  return room;
}

struct Detour {
  Clip ends;   // the first and the last frame count
  Scene room;  // floor and table
};

/// Somebody stands before a table and, when the clip ends, behind it: the straight path is blocked.
inline Detour table_detour(int64_t frames, double rate) {
  Detour out;
  out.room = table_room();
  Clip& clip = out.ends;
  clip.skeleton = builtin_body().skeleton;
  clip.rate = rate;
  clip.rotations = torch::zeros({frames, clip.skeleton.size(), 3});
  clip.rotations.select(1, 16).select(1, 2).fill_(-1.25);  // arms hang
  clip.rotations.select(1, 17).select(1, 2).fill_(1.25);
  clip.trans = torch::zeros({frames, 3});
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  // The ball of a standing foot is 2 cm above the floor.
  const double up = 0.02 - clip.joints[0][10][1].item<double>();
  const Tensor along = torch::linspace(-kAway, kAway, frames);
  clip.trans = torch::stack({torch::zeros({frames}), torch::full({frames}, up), along}, 1);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return out;
}

/// The clip with everybody moved by `detours` (T, 2) along x and z.
inline Clip walked_along(Clip clip, const Tensor& detours) {
  clip.joints = clip.joints.clone();
  clip.joints.select(2, 0).add_(detours.select(1, 0).unsqueeze(1));
  clip.joints.select(2, 2).add_(detours.select(1, 1).unsqueeze(1));
  return clip;
}

/// Whether the root comes over the table in any frame.
inline bool crosses_table(const Clip& clip) {
  const Tensor root = clip.root_path().abs();
  return ((root.select(1, 0) < kTableWidth / 2) & (root.select(1, 2) < kTableDepth / 2)).any().item<bool>();
}

}  // namespace inhabit::inbetween
