#include "inhabit/body/joint_limits.h"

#include <algorithm>

namespace inhabit {

JointLimits joint_limits(const BodyModel& model, int64_t most) {
  const auto joints = static_cast<size_t>(std::min<int64_t>(model.joints(), most));
  JointLimits out;
  out.low.assign(joints, Eigen::Vector3d::Constant(-6.3));
  out.high.assign(joints, Eigen::Vector3d::Constant(6.3));
  if (!model.joint_limits.defined()) return out;
  const torch::Tensor limits = model.joint_limits.to(torch::kCPU, torch::kDouble).contiguous();
  const auto l = limits.accessor<double, 3>();
  for (size_t j = 0; j < joints; ++j)
    for (int i = 0; i < 3; ++i) {
      out.low[j][i] = l[static_cast<int64_t>(j)][i][0];
      out.high[j][i] = l[static_cast<int64_t>(j)][i][1];
    }
  return out;
}

}  // namespace inhabit
