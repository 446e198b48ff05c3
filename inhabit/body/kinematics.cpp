#include "inhabit/body/kinematics.h"

#include "inhabit/error.h"
#include "inhabit/math/rotation.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// Joints by depth: every joint of a level hangs on the level before it, so a level is one batched product.
std::vector<std::vector<int64_t>> levels_of(const std::vector<int>& parents) {
  std::vector<size_t> depth(parents.size(), 0);
  std::vector<std::vector<int64_t>> levels;
  for (size_t j = 0; j < parents.size(); ++j) {
    if (parents[j] >= static_cast<int>(j)) throw Error("skeleton", "a joint comes before its parent");
    depth[j] = parents[j] < 0 ? 0 : depth[parents[j]] + 1;
    if (depth[j] >= levels.size()) levels.resize(depth[j] + 1);
    levels[depth[j]].push_back(static_cast<int64_t>(j));
  }
  return levels;
}

/// The plain loop, for CPU tensors that need no gradient.
template <typename Scalar>
void pose_frames(const std::vector<int>& parents, const Tensor& offsets, const Tensor& rotations, const Tensor& trans,
                 Tensor& positions, Tensor& globals) {
  const int64_t joints = static_cast<int64_t>(parents.size()), frames = trans.numel() / 3;
  const bool one_skeleton = offsets.dim() == 2;
  const Scalar *o = offsets.data_ptr<Scalar>(), *r = rotations.data_ptr<Scalar>(), *t = trans.data_ptr<Scalar>();
  Scalar *p = positions.data_ptr<Scalar>(), *g = globals.data_ptr<Scalar>();
  for (int64_t frame = 0; frame < frames; ++frame) {
    const Scalar* frame_offsets = one_skeleton ? o : o + frame * joints * 3;
    const Scalar* local = r + frame * joints * 9;
    Scalar* position = p + frame * joints * 3;
    Scalar* global = g + frame * joints * 9;
    for (int64_t j = 0; j < joints; ++j) {
      const int parent = parents[j];
      if (parent < 0) {
        std::copy(local + 9 * j, local + 9 * j + 9, global + 9 * j);
        for (int i = 0; i < 3; ++i) position[3 * j + i] = t[3 * frame + i] + frame_offsets[3 * j + i];
        continue;
      }
      const Scalar *a = global + 9 * parent, *b = local + 9 * j, *x = frame_offsets + 3 * j;
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
          global[9 * j + 3 * i + k] = a[3 * i] * b[k] + a[3 * i + 1] * b[3 + k] + a[3 * i + 2] * b[6 + k];
        position[3 * j + i] = position[3 * parent + i] + a[3 * i] * x[0] + a[3 * i + 1] * x[1] + a[3 * i + 2] * x[2];
      }
    }
  }
}

}  // namespace

Pose forward_kinematics(const std::vector<int>& parents, const Tensor& offsets, const Tensor& rotations,
                        const Tensor& trans) {
  const int64_t joints = static_cast<int64_t>(parents.size());
  if (rotations.dim() < 3 || rotations.size(-3) != joints || rotations.size(-2) != 3 || rotations.size(-1) != 3)
    throw Error("forward kinematics", "rotations are not (..., " + std::to_string(joints) + ", 3, 3)");
  if (offsets.dim() < 2 || offsets.size(-2) != joints || offsets.size(-1) != 3)
    throw Error("forward kinematics", "offsets are not (..., " + std::to_string(joints) + ", 3)");
  if (trans.dim() != rotations.dim() - 2 || trans.size(-1) != 3)
    throw Error("forward kinematics", "trans does not have the rotations' leading dimensions");
  const std::vector<std::vector<int64_t>> levels = levels_of(parents);

  const bool gradient =
      torch::GradMode::is_enabled() && (offsets.requires_grad() || rotations.requires_grad() || trans.requires_grad());
  const auto type = rotations.scalar_type();
  const bool plain = !gradient && rotations.device().is_cpu() && (type == torch::kFloat || type == torch::kDouble) &&
                     offsets.scalar_type() == type && trans.scalar_type() == type &&
                     (offsets.dim() == 2 || offsets.sizes() == rotations.sizes().slice(0, rotations.dim() - 1)) &&
                     trans.sizes().slice(0, trans.dim() - 1) == rotations.sizes().slice(0, rotations.dim() - 3);
  if (plain) {
    Pose pose{torch::empty(rotations.sizes().slice(0, rotations.dim() - 1), rotations.options()),
              torch::empty(rotations.sizes(), rotations.options())};
    if (type == torch::kFloat)
      pose_frames<float>(parents, offsets.contiguous(), rotations.contiguous(), trans.contiguous(), pose.positions,
                         pose.rotations);
    else
      pose_frames<double>(parents, offsets.contiguous(), rotations.contiguous(), trans.contiguous(), pose.positions,
                          pose.rotations);
    return pose;
  }

  const auto index_options = torch::TensorOptions(torch::kLong).device(rotations.device());
  std::vector<Tensor> level_rotations, level_positions;
  std::vector<int64_t> place(joints), order;
  for (const auto& level : levels) {
    std::vector<int64_t> above;
    above.reserve(level.size());
    for (int64_t j : level) above.push_back(parents[j] < 0 ? 0 : place[parents[j]]);
    for (size_t i = 0; i < level.size(); ++i) place[level[i]] = static_cast<int64_t>(i);
    order.insert(order.end(), level.begin(), level.end());
    const Tensor index = torch::tensor(level, index_options);
    const Tensor local = rotations.index_select(-3, index);
    const Tensor offset = offsets.index_select(-2, index);
    if (level_rotations.empty()) {
      level_rotations.push_back(local);
      level_positions.push_back(trans.unsqueeze(-2) + offset);
      continue;
    }
    const Tensor above_index = torch::tensor(above, index_options);
    const Tensor parent_rotation = level_rotations.back().index_select(-3, above_index);
    const Tensor parent_position = level_positions.back().index_select(-2, above_index);
    level_rotations.push_back(parent_rotation.matmul(local));
    level_positions.push_back(parent_position + parent_rotation.matmul(offset.unsqueeze(-1)).squeeze(-1));
  }
  std::vector<int64_t> back(joints);
  for (size_t i = 0; i < order.size(); ++i) back[order[i]] = static_cast<int64_t>(i);
  const Tensor back_index = torch::tensor(back, index_options);
  return {torch::cat(level_positions, -2).index_select(-2, back_index),
          torch::cat(level_rotations, -3).index_select(-3, back_index)};
}

Tensor joint_positions(const Skeleton& skeleton, const Tensor& rotations, const Tensor& trans,
                       const Tensor& translations) {
  const Tensor& offsets = translations.defined() ? translations : skeleton.offsets;
  return forward_kinematics(skeleton.parents, offsets.to(rotations.options()), axis_angle_to_matrix(rotations), trans)
      .positions;
}

}  // namespace inhabit
