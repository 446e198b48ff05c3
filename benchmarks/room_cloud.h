#pragma once
#include <torch/torch.h>

#include <cmath>
#include <vector>

/// (1, N, 3) points of a furnished room within `radius` metres of the origin, a standing person's pelvis: floor, two
/// walls, a table, a chair.
inline torch::Tensor room_cloud(int64_t count, double radius = 2.5) {
  std::vector<torch::Tensor> parts;
  int64_t have = 0;
  while (have < count) {
    torch::Tensor cloud = torch::rand({4 * count, 3});
    auto p = cloud.accessor<float, 2>();
    for (int64_t i = 0; i < cloud.size(0); ++i) {
      const float which = std::fmod(static_cast<float>(i) * 0.618034F, 1.0F);
      const float x = 5 * p[i][0] - 2.5F, y = 2.5F * p[i][1] - 0.9F, z = 5 * p[i][2] - 2.5F, u = p[i][1];
      const auto set = [&](float a, float b, float c) { p[i][0] = a, p[i][1] = b, p[i][2] = c; };
      if (which < 0.45F)
        set(x, -0.9F, z);  // floor
      else if (which < 0.6F)
        set(-2.0F, y, z);  // wall
      else if (which < 0.75F)
        set(x, y, 1.8F);  // wall
      else if (which < 0.85F)
        set(0.6F + 0.2F * x, -0.45F, 0.2F * z);  // seat
      else if (which < 0.95F)
        set(0.6F + 0.2F * x, -0.9F + 0.9F * u, 0.5F);  // back rest
      else
        set(-0.8F + 0.3F * x, -0.15F, -1.2F + 0.3F * z);  // table
    }
    parts.push_back(cloud.index({cloud.norm(2, 1) < radius}));
    have += parts.back().size(0);
  }
  return torch::cat(parts).slice(0, 0, count).unsqueeze(0).contiguous();
}

/// (1, frames, joints, 3) joints of somebody about 1.8 m tall who drifts through the middle of it.
inline torch::Tensor somebody(int64_t frames, int64_t joints) {
  const torch::Tensor body = torch::randn({1, 1, joints, 3}) * torch::tensor({0.2F, 0.4F, 0.15F});
  return body + torch::cumsum(torch::randn({1, frames, 1, 3}) * 0.02, 1);
}
