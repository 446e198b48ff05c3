#pragma once
#include <cmath>
#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

/// Somebody of the built-in body who glides on at a constant velocity of `speed` m/s along `yaw` (from +Z towards +X),
/// starting at (x, z). `swing` scales the arms' and legs' motion; 0 holds one pose.
inline inhabit::Clip walker(int64_t frames, double speed, double yaw = 0, double swing = 0, double x = 0,
                            double z = 0) {
  inhabit::Clip clip;
  clip.skeleton = inhabit::builtin_body().skeleton;
  const torch::Tensor t = torch::arange(frames).to(torch::kFloat32) / clip.rate;
  clip.rotations = torch::zeros({frames, clip.skeleton.size(), 3});
  clip.rotations.select(1, 0).select(1, 1).fill_(yaw);
  const torch::Tensor swung = swing * torch::sin(6 * t);
  for (const auto& [joint, axis, rest, amplitude] :
       {std::tuple(1, 0, 0.1, 0.4), std::tuple(2, 0, 0.1, -0.4), std::tuple(4, 0, 0.3, 0.3),
        std::tuple(5, 0, 0.3, -0.3), std::tuple(16, 2, -1.2, 0.1), std::tuple(17, 2, 1.2, 0.1)})
    clip.rotations.select(1, joint).select(1, axis).copy_(rest + amplitude * swung);
  const torch::Tensor start = torch::tensor({x, 0.95, z}, torch::kFloat32);
  const torch::Tensor velocity = torch::tensor({speed * std::sin(yaw), 0.0, speed * std::cos(yaw)}, torch::kFloat32);
  clip.trans = start + t.unsqueeze(1) * velocity;
  clip.joints = inhabit::joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

/// A scan: floor, a wall and a table top as `count` points each, around the origin.
inline inhabit::Scene scanned_room(int64_t count) {
  torch::manual_seed(5);
  const torch::Tensor u = torch::rand({count, 3}) * 8 - 4;
  const auto layer = [&](int axis, double at, double size) {
    torch::Tensor points = u * size;
    points.select(1, axis).fill_(at);
    return points;
  };
  inhabit::Scene scene;
  scene.name = "scan";
  scene.points = torch::cat({layer(1, 0, 1), layer(0, 1.5, 1), layer(1, 0.7, 0.2)});
  return scene;
}
