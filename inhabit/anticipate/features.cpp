#include "inhabit/anticipate/features.h"

#include "inhabit/motion/local_pose.h"

namespace inhabit::anticipate {

using torch::Tensor;

Tensor joint_features(const Tensor& joints) {
  return torch::cat({local_poses(joints).narrow(-2, 1, 21).flatten(-2), root_motion(joints)}, -1);
}

Tensor mirrored_features(const Tensor& features) {
  static const Tensor order = torch::tensor([] {  // standard joints 1 to 21
    std::vector<int64_t> out;
    for (const int64_t j : {2, 1, 3, 5, 4, 6, 8, 7, 9, 11, 10, 12, 14, 13, 15, 17, 16, 19, 18, 21, 20})
      out.push_back(j - 1);
    return out;
  }());
  const Tensor pose = features.narrow(-1, 0, kPoseFeatures).unflatten(-1, {21, 3}).index_select(-2, order) *
                      torch::tensor({-1.F, 1.F, 1.F});
  const Tensor motion = features.narrow(-1, kPoseFeatures, 4) * torch::tensor({-1.F, 1.F, -1.F, 1.F});
  return torch::cat({pose.flatten(-2), motion}, -1);
}

Tensor feature_poses(const Tensor& features) {
  const Tensor pose = features.narrow(-1, 0, kPoseFeatures).unflatten(-1, {21, 3});
  return torch::cat({torch::zeros_like(pose.narrow(-2, 0, 1)), pose}, -2);
}

Tensor feature_joints(const Tensor& features, const Tensor& root, const Tensor& heading) {
  return placed_poses(feature_poses(features), features.narrow(-1, kPoseFeatures, 4), root, heading);
}

FeatureScale feature_scale(const Tensor& features) {
  FeatureStatistics statistics;
  statistics.add(features);
  FeatureScale scale = statistics.scale();
  scale.deviation.narrow(0, 0, kPoseFeatures).clamp_min_(0.05);
  scale.deviation.narrow(0, kPoseFeatures, 4).clamp_min_(1e-3);
  return scale;
}

}  // namespace inhabit::anticipate
