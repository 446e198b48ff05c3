#pragma once
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/motion/clip.h"

namespace inhabit {

/// Joints alone of the recording that comes with the project: (90, 22, 3) at 30 Hz, and its room.
inline const Clip& walk() {
  static const Clip clip = [] {
    const Clip read = read_clip(INHABIT_SOURCE_DIR "/examples/data/walk.npz");
    Clip out;
    out.skeleton = read.skeleton;
    out.rate = read.rate;
    out.joints = read.joints;
    return out;
  }();
  return clip;
}
inline const Scene& walk_room() {
  static const Scene room = read_scene_file(INHABIT_SOURCE_DIR "/examples/data/walk_room.glb").scene;
  return room;
}
inline float largest_difference(const torch::Tensor& a, const torch::Tensor& b) {
  return (a - b).abs().max().item<float>();
}

}  // namespace inhabit
