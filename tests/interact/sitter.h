#pragma once
#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"
#include "inhabit/scene/shapes.h"

/// A scene with a box to sit on, 0.5 m wide, 0.45 m high, its middle at (0, 0), with a back rest behind it: one sits on
/// it facing +Z.
inline inhabit::Scene seat_scene() {
  inhabit::MeshBuilder builder;
  builder.box({0, 0.225, 0}, {0.25, 0.225, 0.25});
  builder.box({0, 0.65, -0.28}, {0.25, 0.2, 0.03});
  inhabit::Scene scene = inhabit::floor_scene();
  scene.name = "seat.glb";
  scene.meshes.push_back(builder.mesh("chair_0", {0.5F, 0.4F, 0.3F}));
  return scene;
}

/// Somebody of one stiff pose, 30 frames a second, who comes along +Z's opposite to that seat, turns half round on the
/// way, is lowered onto it, stays, is raised and goes off along +X:
///   0-59 walk (the last ten on the spot), 60-89 sit_down, 90-149 sit, 150-179 stand_up, 180-239 walk.
/// Feet come down every 15 frames while walking, the left one first, at frame 10. From 75 to 119 the left hand is at
/// the point it will touch from 90 to 119; from 60 to 75 it goes there along a line. Seated, the pelvis rests at (0,
/// -0.05).
struct Sitter {
  static constexpr int64_t kFrames = 240;
  inhabit::Clip clip;
  Eigen::Vector3f touch{0.3F, 0.45F, 0.1F};

  Sitter() {
    clip.skeleton = inhabit::builtin_body().skeleton;
    clip.rotations = torch::zeros({kFrames, 22, 3});
    clip.trans = torch::zeros({kFrames, 3});
    clip.contact = torch::zeros({kFrames, 22});
    clip.hand_targets = torch::zeros({kFrames, 2, 4});
    clip.action_names = {"stand", "walk", "sit_down", "sit", "stand_up"};
    clip.action = torch::zeros({kFrames}, torch::kInt64);
    for (int64_t t = 0; t < kFrames; ++t) {
      const auto u = [&](int64_t from, int64_t to) {
        return std::clamp(static_cast<double>(t - from) / static_cast<double>(to - from), 0.0, 1.0);
      };
      const double low = u(60, 90) - u(150, 180), step = u(0, 50), off = u(180, 240);
      put(t, {static_cast<float>(2.4 * off), static_cast<float>(0.95 - 0.4 * low),
              static_cast<float>(1.95 - 1.6 * step - 0.4 * low)});
      clip.rotations[t][0][1] = M_PI * (1 - step) + M_PI / 2 * off;
      clip.action[t] = t < 60 ? 1 : t < 90 ? 2 : t < 150 ? 3 : t < 180 ? 4 : 1;
      clip.contact[t][0] = t >= 90 && t < 150 ? 1 : 0;
      for (int side = 0; side < 2; ++side) {
        const bool walks = t < 60 || t >= 180;
        const int64_t since = (t + 30 - 10 - 15 * side) % 30;  // each foot stands 20 of 30 frames
        clip.contact[t][7 + side] = !walks || since < 20 ? 1 : 0;
      }
      if (t >= 90 && t < 120) clip.hand_targets[t][0] = torch::tensor({touch.x(), touch.y(), touch.z(), 1.F});
    }
    clip.joints = inhabit::joint_positions(clip.skeleton, clip.rotations, clip.trans);
    // The left wrist goes its own way.
    const torch::Tensor from = clip.joints[60][20].clone(), to = torch::tensor({touch.x(), touch.y(), touch.z()});
    for (int64_t t = 61; t < 120; ++t)
      clip.joints[t][20] = from + std::min(1.0, static_cast<double>(t - 60) / 15) * (to - from);
  }

 private:
  void put(int64_t t, const std::array<float, 3>& root) {
    const torch::Tensor place = torch::tensor({root[0], root[1], root[2]});
    clip.trans[t] = place - clip.skeleton.offsets[0];
  }
};
