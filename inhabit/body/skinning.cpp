#include <ATen/Parallel.h>

#include "inhabit/body/kinematics.h"
#include "inhabit/body/skin_kernel.h"
#include "inhabit/error.h"

namespace inhabit {
namespace {

using torch::Tensor;

SparseWeights sparse_weights(const Tensor& dense) {
  const Tensor weights = dense.to(torch::kCPU, torch::kFloat).contiguous();
  const int64_t vertices = weights.size(0), joints = weights.size(1);
  const float* w = weights.data_ptr<float>();
  SparseWeights sparse;
  sparse.first.reserve(vertices + 1);
  sparse.first.push_back(0);
  for (int64_t v = 0; v < vertices; ++v) {
    for (int64_t j = 0; j < joints; ++j)
      if (w[v * joints + j] != 0) {
        sparse.joint.push_back(static_cast<int32_t>(j));
        sparse.weight.push_back(w[v * joints + j]);
      }
    sparse.first.push_back(static_cast<int32_t>(sparse.joint.size()));
  }
  return sparse;
}

/// Linear blend skinning of CPU floats without a gradient. rest (V, 3) for all frames or (N, V, 3).
Tensor skin_frames(const SparseWeights& weights, const Tensor& rest, const Tensor& rotations, const Tensor& shifts) {
  const int64_t frames = rotations.size(0), joints = rotations.size(1), vertices = rest.size(-2);
  Tensor out = torch::empty({frames, vertices, 3}, rest.options());
  const float *r = rotations.data_ptr<float>(), *s = shifts.data_ptr<float>(), *x = rest.data_ptr<float>();
  float* y = out.data_ptr<float>();
  const int64_t rest_stride = rest.dim() == 2 ? 0 : vertices * 3;
  at::parallel_for(0, frames, std::max<int64_t>(1, 20000 / std::max<int64_t>(1, vertices)),
                   [&](int64_t begin, int64_t end) {
                     std::vector<SkinTransform> transforms(static_cast<size_t>(joints));
                     for (int64_t f = begin; f < end; ++f) {
                       for (int64_t j = 0; j < joints; ++j) {
                         const float *rj = r + (f * joints + j) * 9, *sj = s + (f * joints + j) * 3;
                         auto& columns = transforms[static_cast<size_t>(j)].columns;
                         for (int row = 0; row < 3; ++row) {
                           for (int column = 0; column < 3; ++column) columns[column][row] = rj[3 * row + column];
                           columns[3][row] = sj[row];
                         }
                       }
                       skin_vertices(weights, transforms.data(), x + f * rest_stride, y + f * vertices * 3);
                     }
                   });
  return out;
}

}  // namespace

Tensor skin(const BodyModel& model, const Tensor& betas, const Tensor& rotations, const Tensor& trans) {
  const int64_t joints = model.joints();
  if (rotations.dim() < 3 || rotations.size(-3) != joints)
    throw Error("skinning", "rotations are not (..., " + std::to_string(joints) + ", 3, 3)");
  const auto options = rotations.options();
  Tensor rest = model.template_vertices.to(options), rest_joints = model.joint_template.to(options);
  if (betas.defined() && betas.numel() > 0) {
    if (betas.dim() != 1 || betas.size(0) > model.betas())
      throw Error("betas", "expected at most " + std::to_string(model.betas()) + " shape parameters");
    const Tensor b = betas.to(options);
    rest = rest + model.shape_dirs.narrow(2, 0, b.size(0)).to(options).matmul(b);
    rest_joints = rest_joints + model.joint_dirs.narrow(2, 0, b.size(0)).to(options).matmul(b);
  }
  if (model.pose_dirs.defined()) {
    const Tensor feature =
        (rotations.narrow(-3, 1, joints - 1) - torch::eye(3, options)).flatten(-3);  // (..., 9 (J-1))
    const Tensor moved = feature.matmul(model.pose_dirs.to(options).flatten(0, 1).t());
    rest = rest + moved.unflatten(-1, {rest.size(0), 3});
  }
  std::vector<int64_t> parent_index;
  for (int64_t j = 1; j < joints; ++j) parent_index.push_back(model.skeleton.parents[j]);
  const Tensor above = rest_joints.index_select(
      0, torch::tensor(parent_index, torch::TensorOptions(torch::kLong).device(rotations.device())));
  const Tensor offsets = torch::cat({rest_joints.narrow(0, 0, 1), rest_joints.narrow(0, 1, joints - 1) - above});

  const Pose pose = forward_kinematics(model.skeleton.parents, offsets, rotations, trans);
  // A vertex x at rest goes to sum_j w_j (R_j (x - rest_j) + p_j) = sum_j w_j (R_j x + shift_j).
  const Tensor shifts = pose.positions - pose.rotations.matmul(rest_joints.unsqueeze(-1)).squeeze(-1);

  const bool gradient = torch::GradMode::is_enabled() &&
                        (rest.requires_grad() || pose.rotations.requires_grad() || shifts.requires_grad());
  if (!gradient && rotations.device().is_cpu() && rotations.scalar_type() == torch::kFloat) {
    std::vector<int64_t> shape = trans.sizes().vec();
    shape.insert(shape.end() - 1, rest.size(-2));
    if (rest.dim() > 2) rest = rest.reshape({-1, rest.size(-2), 3});
    return skin_frames(sparse_weights(model.skin_weights), rest.contiguous(),
                       pose.rotations.reshape({-1, joints, 3, 3}).contiguous(),
                       shifts.reshape({-1, joints, 3}).contiguous())
        .view(shape);
  }
  const Tensor transforms = torch::cat({pose.rotations, shifts.unsqueeze(-1)}, -1).flatten(-2);    // (..., J, 12)
  const Tensor blended = model.skin_weights.to(options).matmul(transforms).unflatten(-1, {3, 4});  // (..., V, 3, 4)
  return blended.narrow(-1, 0, 3).matmul(rest.unsqueeze(-1)).squeeze(-1) + blended.select(-1, 3);
}

}  // namespace inhabit
