#include "inhabit/inbetween/residual.h"

#include <algorithm>
#include <cmath>

#include "inhabit/inbetween/scene_probe.h"
#include "inhabit/math/rotation.h"

namespace inhabit::inbetween {

using Eigen::Quaternionf;
using Eigen::Vector3f;
using torch::Tensor;

namespace {

constexpr double kLeastMove = 0.002, kLeastRotation = 0.01;  // metres, and of a rotation's 6D: least deviations
// What residuals at keys with noise of level 1 are divided by, in the same units: about half of the noise. That of a
// joint grows with the root of the number of rotations on the chain from the root to it.
constexpr float kNoisyMove = 0.005F, kNoisyRotation = 0.01F;
constexpr int64_t kSmoothedOver = 5;  // rows of a table

Quaternionf heading_rotation(float heading) { return Quaternionf(Eigen::AngleAxisf(heading, Vector3f::UnitY())); }

/// Which rows of a table lie around a distance, and how far it is between them.
struct TableRow {
  int64_t low;
  float part;
};
TableRow row_of(float bridge) {
  const float at = std::clamp(bridge, 0.0F, static_cast<float>(kScaleRows - 1));
  const auto low = std::min<int64_t>(static_cast<int64_t>(at), kScaleRows - 2);
  return {low, at - static_cast<float>(low)};
}

/// (22 x 22) 1 where joint k is on the chain from the root to joint j.
Tensor chains() {
  Tensor out = torch::zeros({kStandardJoints, kStandardJoints});
  for (int j = 0; j < kStandardJoints; ++j)
    for (int k = j; k > 0; k = standard_parents()[static_cast<size_t>(k)]) out[j][k] = 1;
  return out;
}

/// (135) what divides residuals at keys with noise of level 1.
std::vector<float> noise_scale() {
  std::vector<float> out(3, kNoisyMove);
  const Tensor rotations = 1 + chains().sum(1);
  for (int64_t j = 0; j < kStandardJoints; ++j)
    out.insert(out.end(), 6, kNoisyRotation * std::sqrt(rotations[j].item<float>()));
  return out;
}

Tensor parents_index(torch::Device device) {
  std::vector<int64_t> parents(standard_parents().begin(), standard_parents().end());
  parents[0] = 0;
  return torch::tensor(parents, device);
}

Tensor identity6d(torch::Device device) { return torch::tensor({1.F, 0.F, 0.F, 0.F, 1.F, 0.F}, device); }

/// Where residuals displace the root to, and by how much that rotates the body.
DisplacedRoots roots_of(const ResidualFrames& frames, const Tensor& residual) {
  return displaced(frames.detours, frames.root, (residual * frames.scale).slice(1, 0, 3).transpose(1, 2));
}

/// Rotations (B, T, N, 3, 3) of six numbers (B, T, N, 6) each, rotated with the detour.
Tensor rotations_of(const Tensor& numbers, const DisplacedRoots& roots) {
  const Tensor plain = rotation6d_to_matrix(numbers);
  return roots.yaw.defined() ? torch::matmul(yaw_matrix(roots.yaw).unsqueeze(2), plain) : plain;
}

/// (B, T, 22, 6) the first two columns of rotations relative to the baseline's, not yet orthogonal.
Tensor six_numbers(const ResidualFrames& frames, const Tensor& residual) {
  return (residual * frames.scale).slice(1, 3).transpose(1, 2).unflatten(2, {kStandardJoints, 6}) +
         identity6d(residual.device());
}

}  // namespace

Tensor residual_of(const Poses& motion, const Baseline& baseline) {
  const int64_t frames = motion.frames();
  Tensor out = torch::empty({frames, kResidualFeatures});
  float* to = out.data_ptr<float>();
  float ahead = 0;
  for (int64_t t = 0; t < frames; ++t) {
    const float heading = baseline.heading[static_cast<size_t>(t)];
    const Vector3f move = displacement_to(baseline.legs, baseline.poses, t, heading, motion.root(t), ahead);
    to = std::copy_n(move.data(), 3, to);
    const Quaternionf rotation = heading_rotation(heading),
                      back =
                          heading_rotation(-heading - displaced(baseline.legs, baseline.poses, t, heading, move).yaw);
    for (int64_t j = 0; j < kStandardJoints; ++j) {
      const size_t at = Poses::at(t, j);
      const Eigen::Matrix3f relative =
          (back * motion.rotations[at] * baseline.poses.rotations[at].conjugate() * rotation)
              .normalized()
              .toRotationMatrix() -
          Eigen::Matrix3f::Identity();
      to = std::copy_n(relative.data(), 6, to);  // column by column
    }
  }
  return out.t().contiguous();
}

Tensor residual_scale(const Baseline& baseline, const Tensor& table) {
  const int64_t frames = baseline.poses.frames();
  Tensor out = torch::empty({frames, kResidualFeatures});
  const Tensor plain = table.to(torch::kFloat32).contiguous();
  const auto rows = plain.accessor<float, 2>();
  auto to = out.accessor<float, 2>();
  static const std::vector<float> noisy = noise_scale();
  for (int64_t t = 0; t < frames; ++t) {
    const float level = baseline.noise[static_cast<size_t>(t)];
    const TableRow root = row_of(baseline.root_distance[static_cast<size_t>(t)].bridge()),
                   pose = row_of(baseline.pose_distance[static_cast<size_t>(t)].bridge());
    for (int64_t f = 0; f < kResidualFeatures; ++f) {
      const TableRow& row = f < 3 ? root : pose;
      const std::vector<KeyDistance>& keys = f < 3 ? baseline.root_distance : baseline.pose_distance;
      to[t][f] = keys[static_cast<size_t>(t)].after < 0
                     ? 0
                     : std::hypot(rows[row.low][f] + row.part * (rows[row.low + 1][f] - rows[row.low][f]),
                                  level * noisy[static_cast<size_t>(f)]);
    }
  }
  return out.t().contiguous();
}

void ResidualStatistics::add(const Tensor& residual, const Baseline& baseline) {
  const Tensor plain = residual.t().contiguous();
  const auto r = plain.accessor<float, 2>();
  auto squares = squares_.accessor<double, 2>(), counts = counts_.accessor<double, 2>();
  for (int64_t t = 0; t < plain.size(0); ++t) {
    if (baseline.pose_distance[static_cast<size_t>(t)].after < 0) break;
    const auto nearest = [](float bridge) { return std::min<int64_t>(std::lround(bridge), kScaleRows - 1); };
    const int64_t pose = nearest(baseline.pose_distance[static_cast<size_t>(t)].bridge()),
                  root = nearest(baseline.root_distance[static_cast<size_t>(t)].bridge());
    for (int64_t f = 0; f < kResidualFeatures; ++f) {
      const auto value = static_cast<double>(r[t][f]);
      squares[f < 3 ? root : pose][f] += value * value;
    }
    ++counts[pose][0];
    ++counts[root][1];
  }
}

Tensor ResidualStatistics::table() const {
  Tensor counts = torch::cat({counts_.select(1, 1).unsqueeze(1).expand({-1, 3}),
                              counts_.select(1, 0).unsqueeze(1).expand({-1, kResidualFeatures - 3})},
                             1);
  Tensor out = torch::zeros({kScaleRows, kResidualFeatures}, torch::kFloat64);
  for (int64_t row = 1; row < kScaleRows; ++row) {
    const int64_t from = std::max<int64_t>(1, row - kSmoothedOver / 2),
                  to = std::min(kScaleRows, row + kSmoothedOver / 2 + 1);
    const Tensor here = (squares_.slice(0, from, to).sum(0) / counts.slice(0, from, to).sum(0).clamp_min(1)).sqrt();
    out[row] = torch::maximum(here, out[row - 1]);
  }
  Tensor least = torch::full({kResidualFeatures}, kLeastRotation, torch::kFloat64);
  least.slice(0, 0, 3).fill_(kLeastMove);
  out.slice(0, 1).copy_(torch::maximum(out.slice(0, 1), least));
  return out.to(torch::kFloat32);
}

ResidualFrames ResidualFrames::to(torch::Device device) const {
  return {root.to(device),     bones.to(device), ends.to(device),
          rotation.to(device), scale.to(device), detours.to_device(device)};
}

ResidualFrames residual_frames(const std::vector<const Baseline*>& baselines, const Tensor& table) {
  std::vector<Tensor> roots, bones, ends, rotations, scales;
  std::vector<const DetourLegs*> legs;
  std::vector<const std::vector<float>*> headings;
  for (const Baseline* b : baselines) {
    legs.push_back(&b->legs);
    headings.push_back(&b->heading);
    const int64_t frames = b->poses.frames();
    Tensor root = torch::empty({frames, 3}), bone = torch::zeros({frames, kStandardJoints, 3}),
           end = torch::empty({frames, static_cast<int64_t>(kLimbEnds), 3}), heading = torch::empty({frames});
    float* to_end = end.data_ptr<float>();
    for (int64_t t = 0; t < frames; ++t) {
      const float yaw = b->heading[static_cast<size_t>(t)];
      const Quaternionf back = heading_rotation(-yaw);
      heading.data_ptr<float>()[t] = yaw;
      std::copy_n(b->poses.root(t).data(), 3, root.data_ptr<float>() + 3 * t);
      for (int64_t j = 1; j < kStandardJoints; ++j) {
        const Vector3f along = back * (b->poses.joints[Poses::at(t, j)] -
                                       b->poses.joints[Poses::at(t, standard_parents()[static_cast<size_t>(j)])]);
        std::copy_n(along.data(), 3, bone.data_ptr<float>() + 3 * (t * kStandardJoints + j));
      }
      for (const LimbEnd& limb : limb_ends()) {
        const Vector3f beyond = back * (b->poses.rotations[Poses::at(t, limb.joint)] * limb.offset);
        to_end = std::copy_n(beyond.data(), 3, to_end);
      }
    }
    roots.push_back(root);
    bones.push_back(bone);
    ends.push_back(end);
    rotations.push_back(yaw_matrix(heading));
    scales.push_back(residual_scale(*b, table));
  }
  return {torch::stack(roots),     torch::stack(bones),  torch::stack(ends),
          torch::stack(rotations), torch::stack(scales), detour_frames(legs, headings)};
}

Tensor residual_rotations(const ResidualFrames& frames, const Tensor& residual) {
  return rotations_of(six_numbers(frames, residual), roots_of(frames, residual));
}

Tensor residual_joints(const ResidualFrames& frames, const Tensor& residual) {
  const DisplacedRoots roots = roots_of(frames, residual);
  const Tensor relative =
      rotations_of(six_numbers(frames, residual), roots).index_select(2, parents_index(residual.device()));
  const Tensor bones = torch::matmul(relative, frames.bones.unsqueeze(4)).squeeze(4);  // (B, T, 22, 3)
  return torch::matmul(chains().to(residual.device()), bones) + roots.move.unsqueeze(2);
}

Tensor guarded_points(const ResidualFrames& frames, const Tensor& residual, const Tensor& joints) {
  std::vector<int64_t> last;
  for (const LimbEnd& limb : limb_ends()) last.push_back(limb.joint);
  const Tensor of = torch::tensor(last, joints.device());
  const Tensor rotations =
      rotations_of(six_numbers(frames, residual).index_select(2, of), roots_of(frames, residual));  // (B, T, 8, 3, 3)
  const Tensor ends = joints.index_select(2, of) + torch::matmul(rotations, frames.ends.unsqueeze(4)).squeeze(4);
  return torch::cat({body_points(joints), ends}, 2);
}

Tensor to_world(const ResidualFrames& frames, const Tensor& points) {
  return torch::matmul(points, frames.rotation.transpose(2, 3)) + frames.root.unsqueeze(2);
}

Poses motion_of(const Tensor& residual, const Tensor& scale, const Baseline& baseline) {
  Poses out = baseline.poses;
  const Tensor plain = (residual * scale).t().to(torch::kFloat32).contiguous();
  const auto r = plain.accessor<float, 2>();
  for (int64_t t = 0; t < plain.size(0); ++t) {
    const float heading = baseline.heading[static_cast<size_t>(t)];
    const DisplacedRoot root =
        displaced(baseline.legs, baseline.poses, t, heading, Vector3f(r[t][0], r[t][1], r[t][2]));
    const Quaternionf rotation = heading_rotation(heading + root.yaw), back = heading_rotation(-heading);
    out.joints[Poses::at(t, 0)] = root.place;
    for (int64_t j = 0; j < kStandardJoints; ++j) {
      const int64_t f = 3 + 6 * j;
      const Vector3f first = Vector3f(1 + r[t][f], r[t][f + 1], r[t][f + 2]).normalized();
      const Vector3f raw(r[t][f + 3], 1 + r[t][f + 4], r[t][f + 5]);
      const Vector3f second = (raw - raw.dot(first) * first).normalized();
      Eigen::Matrix3f relative;
      relative << first, second, first.cross(second);
      Quaternionf& q = out.rotations[Poses::at(t, j)];
      q = (rotation * Quaternionf(relative) * back * q).normalized();
    }
    place_joints(out, t);
  }
  return out;
}

}  // namespace inhabit::inbetween
