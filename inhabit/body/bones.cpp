#include "inhabit/body/bones.h"

#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"

namespace inhabit {

Bones bones_of(const Skeleton& skeleton) {
  Bones bones;
  bones.parents = skeleton.parents;
  const torch::Tensor offsets = skeleton.offsets.detach().to(torch::kCPU, torch::kDouble).contiguous();
  const double* p = offsets.data_ptr<double>();
  for (int j = 0; j < skeleton.size(); ++j) bones.offsets.emplace_back(p[3 * j], p[3 * j + 1], p[3 * j + 2]);
  return bones;
}

void pose_bones(const Bones& bones, const std::vector<Eigen::Quaterniond>& local, const Eigen::Vector3d& trans,
                BonesPose& out) {
  const size_t n = bones.parents.size();
  if (local.size() != n)
    throw Error("pose", std::to_string(local.size()) + " rotations for " + std::to_string(n) + " joints");
  out.positions.resize(n);
  out.rotations.resize(n);
  for (size_t j = 0; j < n; ++j) {
    const int parent = bones.parents[j];
    if (parent < 0) {
      out.rotations[j] = local[j];
      out.positions[j] = trans + bones.offsets[j];
    } else {
      out.rotations[j] = out.rotations[parent] * local[j];
      out.positions[j] = out.positions[parent] + out.rotations[parent] * bones.offsets[j];
    }
  }
}

std::vector<Eigen::Quaterniond> local_quaternions(const torch::Tensor& axis_angle) {
  if (axis_angle.dim() != 2 || axis_angle.size(1) != 3) throw Error("pose", "expected axis-angle (J, 3)");
  const torch::Tensor rows = axis_angle.detach().to(torch::kCPU, torch::kDouble).contiguous();
  const double* p = rows.data_ptr<double>();
  std::vector<Eigen::Quaterniond> local;
  for (int64_t j = 0; j < rows.size(0); ++j)
    local.push_back(quaternion_of(Eigen::Vector3d(p[3 * j], p[3 * j + 1], p[3 * j + 2])));
  return local;
}

}  // namespace inhabit
