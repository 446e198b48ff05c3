#include "inhabit/forecast/features.h"

#include <ATen/Parallel.h>

#include <array>
#include <cmath>
#include <vector>

#include "inhabit/body/skeleton.h"
#include "inhabit/forecast/contact_kernel.h"
#include "inhabit/math/dct.h"
#include "inhabit/scene/contact_map.h"

namespace inhabit::forecast {

using torch::Tensor;

namespace {

/// Rows [x y z 1] of the scene points `index` (B, ...) where `touching` (B, ...), else zeros.
Tensor pick_points(const Tensor& scene, const Tensor& index, const Tensor& touching) {
  const int64_t batch = scene.size(0);
  const Tensor picked = scene.gather(1, index.reshape({batch, -1, 1}).expand({batch, -1, 3}));
  std::vector<int64_t> shape = index.sizes().vec();
  shape.push_back(3);
  const Tensor flag = touching.to(scene.scalar_type()).unsqueeze(-1);
  return torch::cat({picked.view(shape) * flag, flag}, -1);
}

/// Calls work(sample, joint) for every sample and joint, on all threads.
template <class Work>
void for_each_joint(int64_t batch, int64_t joints, const Work& work) {
  at::parallel_for(0, batch * joints, 1, [&](int64_t first, int64_t last) {
    for (int64_t i = first; i < last; ++i) work(i / joints, i % joints);
  });
}

/// Coordinates by axis (B, 3, N) and joint paths (B, J, F, 3), as the kernels read them.
struct Arrays {
  Tensor points, paths;

  Arrays(const Tensor& scene, const Tensor& joints)
      : points(scene.to(torch::kFloat32).transpose(1, 2).contiguous()),
        paths(joints.to(torch::kFloat32).transpose(1, 2).contiguous()) {}
  std::array<const float*, 3> axes(int64_t b) const {
    const int64_t count = points.size(2);
    const float* first = points.data_ptr<float>() + b * 3 * count;
    return {first, first + count, first + 2 * count};
  }
  const float* path(int64_t b, int64_t j) const {
    return paths.data_ptr<float>() + (b * paths.size(1) + j) * paths.size(2) * 3;
  }
};

/// (B, L*J, N) coefficients basis (L, F) @ contact maps of joints (B, F, J, 3).
Tensor contact_coefficients(const Tensor& scene, const Tensor& joints, const Tensor& basis, const Config& config) {
  torch::NoGradGuard no_gradients;
  const int64_t batch = scene.size(0), count = scene.size(1), joint_count = joints.size(2), rows = basis.size(0);
  if (!scene.device().is_cpu()) {
    std::vector<Tensor> by_joint;
    for (int64_t j = 0; j < joint_count; ++j) {
      const Tensor map = contact_map(joints.slice(2, j, j + 1), scene, config.sigma).squeeze(2);
      by_joint.push_back(basis.to(scene.device()).matmul(map));
    }
    return torch::stack(by_joint, 2).view({batch, rows * joint_count, count});
  }
  const Arrays arrays(scene, joints);
  Tensor out = torch::empty({batch, rows * joint_count, count});
  for_each_joint(batch, joint_count, [&](int64_t b, int64_t j) {
    contact_coefficients_of_joint(arrays.axes(b).data(), count, arrays.path(b, j), joints.size(1),
                                  basis.data_ptr<float>(), rows, static_cast<float>(config.sigma),
                                  out.data_ptr<float>() + (b * rows * joint_count + j) * count, joint_count * count);
  });
  return out;
}

}  // namespace

Tensor contact_features(const Tensor& scene, const Tensor& past, const Config& config) {
  return contact_coefficients(scene, past, padded_dct_matrix(past.size(1), config.future, config.contact_coefficients),
                              config);
}

Tensor contact_targets(const Tensor& scene, const Tensor& joints, const Config& config) {
  return contact_coefficients(scene, joints, dct_matrix(joints.size(1), config.contact_coefficients), config);
}

Tensor contact_maps_from_dct(const Tensor& contact_dct, int64_t frames, int64_t joints) {
  const int64_t batch = contact_dct.size(0), count = contact_dct.size(2), coefficients = contact_dct.size(1) / joints;
  const Tensor idct = idct_matrix(frames, coefficients).to(contact_dct.device());
  // matmul() would turn both about and copy them.
  return idct.unsqueeze(0)
      .expand({batch, -1, -1})
      .bmm(contact_dct.reshape({batch, coefficients, joints * count}))
      .view({batch, frames, joints, count});
}

Tensor contact_points(const Tensor& scene, const Tensor& contact_dct, const Config& config) {
  torch::NoGradGuard no_gradients;
  const int64_t batch = contact_dct.size(0), count = contact_dct.size(2);
  const Tensor idct =
      idct_matrix(config.frames(), config.contact_coefficients).slice(0, config.past).to(contact_dct.device());
  const Tensor coefficients = contact_dct.reshape({batch, config.contact_coefficients, config.joints, count});
  if (!scene.device().is_cpu()) {
    std::vector<Tensor> values, indices;
    for (int64_t j = 0; j < config.joints; ++j) {  // joint by joint: (T, J, N) is never stored
      auto [value, index] = idct.matmul(coefficients.select(2, j)).max(2);
      values.push_back(value);
      indices.push_back(index);
    }
    return pick_points(scene, torch::stack(indices, 2), torch::stack(values, 2) > config.inference.contact_threshold);
  }
  const Tensor basis = idct.contiguous(), given = coefficients.contiguous();
  Tensor values = torch::empty({batch, config.joints, config.future});
  Tensor indices = torch::empty({batch, config.joints, config.future}, torch::kInt64);
  for_each_joint(batch, config.joints, [&](int64_t b, int64_t j) {
    const int64_t row = (b * config.joints + j) * config.future;
    largest_contact_of_joint(given.data_ptr<float>() + (b * config.contact_coefficients * config.joints + j) * count,
                             config.joints * count, count, basis.data_ptr<float>(), config.contact_coefficients,
                             config.future, static_cast<float>(config.inference.contact_threshold),
                             values.data_ptr<float>() + row, indices.data_ptr<int64_t>() + row);
  });
  return pick_points(scene, indices.transpose(1, 2).contiguous(),
                     values.transpose(1, 2) > config.inference.contact_threshold);
}

Tensor true_contact_points(const Tensor& scene, const Tensor& joints, const Config& config) {
  torch::NoGradGuard no_gradients;
  const auto pick = [&](const Tensor& squared, const Tensor& index) {
    return pick_points(
        scene, index,
        torch::exp(squared * (-0.5 / (config.sigma * config.sigma))) > config.inference.contact_threshold);
  };
  if (!scene.device().is_cpu()) {
    std::vector<Tensor> values, indices;
    for (int64_t j = 0; j < joints.size(2); ++j) {
      auto [value, index] = distance_map(joints.slice(2, j, j + 1), scene).square().squeeze(2).min(2);
      values.push_back(value);
      indices.push_back(index);
    }
    return pick(torch::stack(values, 2), torch::stack(indices, 2));
  }
  const int64_t batch = joints.size(0), frames = joints.size(1), count = joints.size(2);
  const Arrays arrays(scene, joints);
  Tensor squared = torch::empty({batch, count, frames});
  Tensor indices = torch::empty({batch, count, frames}, torch::kInt64);
  for_each_joint(batch, count, [&](int64_t b, int64_t j) {
    const int64_t row = (b * count + j) * frames;
    closest_point_of_joint(arrays.axes(b).data(), scene.size(1), arrays.path(b, j), frames,
                           squared.data_ptr<float>() + row, indices.data_ptr<int64_t>() + row);
  });
  return pick(squared.transpose(1, 2).contiguous(), indices.transpose(1, 2).contiguous());
}

Tensor foot_joints() {
  Tensor out = torch::zeros({kStandardJoints}, torch::kBool);
  for (const int64_t joint : kFootJoints) out[joint] = true;
  return out;
}

}  // namespace inhabit::forecast
