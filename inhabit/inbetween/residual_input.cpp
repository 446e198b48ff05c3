#include "inhabit/inbetween/residual_input.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/heading.h"

namespace inhabit::inbetween {

using Eigen::Vector3f;
using torch::Tensor;

namespace {

constexpr float kSoon = 6, kLong = 60, kFarthest = 120;  // frames

float* put_timing(const KeyDistance& d, float* to) {
  const auto frames = [](int count) { return count < 0 ? kFarthest : std::min(static_cast<float>(count), kFarthest); };
  const float before = frames(d.before), after = frames(d.after), bridge = d.bridge();
  for (const float value : {bridge == 0 ? 1.0F : 0.0F, std::exp(-before / kSoon), std::exp(-after / kSoon),
                            before / kLong, after / kLong, bridge / (kLong / 2)})
    *to++ = value;
  return to;
}

}  // namespace

Tensor static_features(const Baseline& baseline, const Tensor& fan, double rate) {
  const Poses& poses = baseline.poses;
  const int64_t frames = poses.frames();
  Tensor out = torch::empty({frames, kStaticFeatures});
  const Tensor scene = fan.contiguous(), targets = baseline.targets.contiguous();
  const auto per_second = static_cast<float>(rate);
  float* to = out.data_ptr<float>();
  for (int64_t t = 0; t < frames; ++t) {
    const int64_t next = std::min(t + 1, frames - 1), from = std::max<int64_t>(next - 1, 0);
    const float yaw = baseline.heading[static_cast<size_t>(t)];
    const Eigen::AngleAxisf back(-yaw, Vector3f::UnitY());
    const auto put = [&](const Vector3f& v) { to = std::copy_n(v.data(), 3, to); };
    for (int64_t j = 1; j < kStandardJoints; ++j) put(back * (poses.joints[Poses::at(t, j)] - poses.root(t)));
    *to++ = poses.root(t).y();
    put(back * (poses.root(next) - poses.root(from)) * per_second);
    *to++ = static_cast<float>(wrapped(static_cast<double>(baseline.heading[static_cast<size_t>(next)] -
                                                           baseline.heading[static_cast<size_t>(from)]))) *
            per_second;
    to = put_timing(baseline.pose_distance[static_cast<size_t>(t)], to);
    to = put_timing(baseline.root_distance[static_cast<size_t>(t)], to);
    to = std::copy_n(targets.data_ptr<float>() + t * kTargetFeatures, kTargetFeatures, to);
    to = std::copy_n(scene.data_ptr<float>() + t * kFanFeatures, kFanFeatures, to);
    *to++ = baseline.noise[static_cast<size_t>(t)];
  }
  return out.t().contiguous();
}

Tensor body_features(const ResidualFrames& frames, const std::vector<SceneDistances>& scenes, const Tensor& predicted) {
  const torch::NoGradGuard no_gradients;
  const Tensor points = body_points(to_world(frames, residual_joints(frames, predicted)));
  return point_features(probe(scenes, points), frames.rotation).transpose(1, 2);
}

Tensor denoiser_channels(const Tensor& x, const Tensor& before, const Tensor& fixed, const Tensor& body) {
  return torch::cat({x, before, fixed, body}, 1);
}

Tensor bone_lengths(const Poses& poses) {
  Tensor out = torch::empty({kBoneFeatures});
  for (size_t j = 1; j < kStandardJoints; ++j) out.data_ptr<float>()[j - 1] = poses.offsets[j].norm();
  return out;
}

}  // namespace inhabit::inbetween
