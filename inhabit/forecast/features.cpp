#include "inhabit/forecast/features.h"

#include <ATen/Parallel.h>

#include <cmath>
#include <vector>

#include "inhabit/error.h"
#include "inhabit/math/dct.h"

namespace inhabit {

using torch::Tensor;

namespace {

/// (B, T, J, N) squared distances, for devices without loops of our own.
Tensor squared_distances(const Tensor& scene, const Tensor& joints) {
  const auto axis = [&](int64_t i) {
    return (joints.select(3, i).unsqueeze(3) - scene.select(2, i).unsqueeze(1).unsqueeze(1)).square();
  };
  return axis(0) + axis(1) + axis(2);
}

/// Rows [x y z 1] of the scene points `index` (B, ...) where `touching` (B, ...), else zeros.
Tensor pick_points(const Tensor& scene, const Tensor& index, const Tensor& touching) {
  const int64_t batch = scene.size(0);
  const Tensor picked = scene.gather(1, index.reshape({batch, -1, 1}).expand({batch, -1, 3}));
  std::vector<int64_t> shape = index.sizes().vec();
  shape.push_back(3);
  const Tensor flag = touching.to(scene.scalar_type()).unsqueeze(-1);
  return torch::cat({picked.view(shape) * flag, flag}, -1);
}

}  // namespace

Tensor contact_features(const Tensor& scene, const Tensor& past, const ForecastConfig& config) {
  torch::NoGradGuard no_gradients;
  const int64_t batch = scene.size(0), joints = past.size(2);
  const Tensor dct = padded_dct_matrix(past.size(1), config.future, config.contact_coefficients).to(scene.device());
  std::vector<Tensor> rows;
  for (int64_t j = 0; j < joints; ++j) {
    const Tensor map = torch::exp(squared_distances(scene, past.slice(2, j, j + 1)).squeeze(2) *
                                  (-0.5 / (config.sigma * config.sigma)));
    rows.push_back(dct.matmul(map));
  }
  return torch::stack(rows, 2).view({batch, config.contact_coefficients * joints, scene.size(1)});
}

Tensor contact_maps_from_dct(const Tensor& contact_dct, const ForecastConfig& config) {
  const int64_t batch = contact_dct.size(0), count = contact_dct.size(2);
  const Tensor idct = idct_matrix(config.frames(), config.contact_coefficients).to(contact_dct.device());
  return idct.matmul(contact_dct.reshape({batch, config.contact_coefficients, config.joints * count}))
      .view({batch, config.frames(), config.joints, count});
}

Tensor contact_points(const Tensor& scene, const Tensor& contact_dct, const ForecastConfig& config) {
  torch::NoGradGuard no_gradients;
  const int64_t batch = contact_dct.size(0), count = contact_dct.size(2);
  const Tensor idct =
      idct_matrix(config.frames(), config.contact_coefficients).slice(0, config.past).to(contact_dct.device());
  const Tensor coefficients = contact_dct.reshape({batch, config.contact_coefficients, config.joints, count});
  std::vector<Tensor> values, indices;
  for (int64_t j = 0; j < config.joints; ++j) {  // joint by joint: (T, J, N) is never stored
    const Tensor map = idct.matmul(coefficients.select(2, j));
    auto [value, index] = map.max(2);
    values.push_back(value);
    indices.push_back(index);
  }
  return pick_points(scene, torch::stack(indices, 2), torch::stack(values, 2) > config.contact_threshold);
}

Tensor true_contact_points(const Tensor& scene, const Tensor& joints, const ForecastConfig& config) {
  torch::NoGradGuard no_gradients;
  std::vector<Tensor> values, indices;
  for (int64_t j = 0; j < joints.size(2); ++j) {
    auto [value, index] = squared_distances(scene, joints.slice(2, j, j + 1)).squeeze(2).min(2);
    values.push_back(value);
    indices.push_back(index);
  }
  const Tensor contact = torch::exp(torch::stack(values, 2) * (-0.5 / (config.sigma * config.sigma)));
  return pick_points(scene, torch::stack(indices, 2), contact > config.contact_threshold);
}

}  // namespace inhabit
