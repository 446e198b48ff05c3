#pragma once
#include "forecast/walker.h"
#include "inhabit/inbetween/evaluate.h"
#include "inhabit/math/random.h"

/// Windows of people who walk at different speeds, swings and headings, without a scene.
inline std::vector<inhabit::inbetween::Window> walking_windows(int64_t count, uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::vector<inhabit::inbetween::Window> out;
  for (int64_t i = 0; i < count; ++i) {
    inhabit::inbetween::Window window;
    window.name = "walk " + std::to_string(i);
    const double speed = inhabit::uniform(random, 0.2, 1.5), yaw = inhabit::uniform(random, -3, 3),
                 swing = inhabit::uniform(random, 0.2, 1);
    window.truth = walker(inhabit::inbetween::kFeatureFrames, speed, yaw, swing, inhabit::uniform(random, -2, 2));
    out.push_back(window);
  }
  return out;
}

inline torch::Tensor joints_of(const std::vector<inhabit::inbetween::Window>& windows) {
  std::vector<torch::Tensor> out;
  for (const inhabit::inbetween::Window& window : windows) out.push_back(window.truth.joints);
  return torch::stack(out);
}
