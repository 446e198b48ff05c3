#include "inhabit/inbetween/features.h"

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr int64_t kChest = 9, kPelvis = 0;  // spine3 moves the skin of the chest

/// From the frontmost to the rearmost vertex of the skin that joint `part` moves most.
double depth_of(const BodyModel& model, const Tensor& vertices, int64_t part) {
  const Tensor z = vertices.select(1, 2).masked_select(model.skin_weights.argmax(1) == part);
  if (z.numel() == 0) throw Error(model.name, "has no skin at joint " + std::to_string(part));
  return (z.max() - z.min()).item<double>();
}

// Of features (B, 201, T) the rotations (B, 132, T), and of what is the same for a rotation's six numbers one (B, 22,
// T).
Tensor rotations_of(const Tensor& x) { return x.slice(1, kOrientFeature, kJointFeature); }
Tensor one_of_six(const Tensor& x) { return x.slice(1, kOrientFeature, kJointFeature, 6); }

/// Rotations as matrices (B, 22, T, 3, 3) and back, (B, 132, T) standardised.
struct Rotations {
  const FeatureScale& scale;

  Tensor matrices(const Tensor& features) const {
    const Tensor six = rotations_of(features * scale.deviation.view({1, -1, 1}) + scale.mean.view({1, -1, 1}));
    return rotation6d_to_matrix(six.unflatten(1, {kStandardJoints, 6}).transpose(2, 3));
  }
  Tensor features(const Tensor& matrices) const {
    const Tensor six = matrix_to_rotation6d(matrices).transpose(2, 3).flatten(1, 2);
    return (six - rotations_of(scale.mean.view({1, -1, 1}))) / rotations_of(scale.deviation.view({1, -1, 1}));
  }
};

/// Matrices (B, 22, T, 3, 3) of constrained frames, interpolated by slerp in the others.
Tensor between_keys(const Tensor& matrices, const KeyNeighbours& n) {
  const Tensor rotations = matrix_to_quaternion(matrices);
  const auto at = [&](const Tensor& frames) {
    return rotations.gather(2, one_of_six(frames).unsqueeze(3).expand(rotations.sizes()));
  };
  return quaternion_to_matrix(slerp(at(n.before), at(n.after), one_of_six(n.weight)));
}

}  // namespace

Tensor clip_features(const Clip& clip) {
  if (clip.joints.size(1) != kStandardJoints || !clip.rotations.defined())
    throw Error("in-betweening: needs rotations on the standard skeleton");
  const int64_t frames = clip.frames();
  const Tensor rotations = matrix_to_rotation6d(axis_angle_to_matrix(clip.rotations)).reshape({frames, -1});
  return torch::cat({clip.root_path(), rotations, clip.joints.reshape({frames, -1})}, 1);
}

Tensor feature_rotations(const Tensor& features) {
  std::vector<int64_t> shape = features.sizes().vec();
  shape.back() = kStandardJoints;
  shape.push_back(6);
  return rotation6d_to_matrix(features.slice(-1, kOrientFeature, kJointFeature).reshape(shape));
}

Tensor feature_joints(const Tensor& features, const Tensor& offsets) {
  // The root feature is the joint itself, so that the skeleton's own place of it does not count.
  const Tensor bones = torch::cat({torch::zeros_like(offsets.slice(-2, 0, 1)), offsets.slice(-2, 1)}, -2).unsqueeze(-3);
  return forward_kinematics(standard_parents(), bones, feature_rotations(features), features.slice(-1, 0, 3)).positions;
}

Clip clip_of_features(const Tensor& features, const Clip& like) {
  Clip out = person_of(like);
  out.rotations = matrix_to_axis_angle(feature_rotations(features)).contiguous();
  out.trans = (features.slice(1, 0, 3) - like.skeleton.offsets[0]).contiguous();
  out.joints = joint_positions(out.skeleton, out.rotations, out.trans);
  return out;
}

Tensor with_rest_frames_rotated(const Tensor& features, const Tensor& rotations, Tensor& bones) {
  std::vector<int64_t> parents(standard_parents().begin(), standard_parents().end());
  parents[0] = 0;
  Tensor before = rotations.index_select(0, torch::tensor(parents)).transpose(1, 2).clone();  // A_parent^T
  before[0].copy_(torch::eye(3));  // the root's parent is the world
  bones = torch::matmul(before, bones.unsqueeze(2)).squeeze(2);
  const Tensor rotated = torch::matmul(torch::matmul(before, feature_rotations(features)), rotations);
  return torch::cat({features.slice(1, 0, kOrientFeature), matrix_to_rotation6d(rotated).flatten(1),
                     features.slice(1, kJointFeature)},
                    1);
}

Tensor interpolated_baseline(const KeyConstraints& constraints, const FeatureScale& scale) {
  const Rotations rotations_in{scale};
  Tensor out = interpolate_keys(constraints);
  const Tensor arcs =
      rotations_in.features(between_keys(rotations_in.matrices(constraints.values), key_neighbours(constraints.mask)));
  rotations_of(out).copy_(torch::where((rotations_of(constraints.mask) > 0).any(2, true), arcs, rotations_of(out)));
  return out;
}

Tensor noisy_features(const Tensor& features, const Tensor& bones, double level, std::mt19937_64& random) {
  const int64_t inner = features.size(0) - 2;
  if (inner <= 0 || level == 0) return features;
  auto generator = at::detail::createCPUGenerator(random());
  Tensor middle = features.slice(0, 1, inner + 1).clone();
  middle.slice(1, 0, 3).add_(torch::randn({inner, 3}, generator), level / 100);
  const Tensor noise = torch::randn({inner, kStandardJoints, 3}, generator) * (level * M_PI / 180);
  const Tensor rotations = torch::matmul(feature_rotations(middle), axis_angle_to_matrix(noise));
  middle.slice(1, kOrientFeature, kJointFeature).copy_(matrix_to_rotation6d(rotations).reshape({inner, -1}));
  middle.slice(1, kJointFeature).copy_(feature_joints(middle, bones).reshape({inner, -1}));
  return torch::cat({features.slice(0, 0, 1), middle, features.slice(0, inner + 1)});
}

Tensor body_shape_features(const BodyModel& model, const Tensor& betas) {
  const torch::NoGradGuard no_gradients;
  const Tensor rest = shaped_skeleton(model, betas).rest_joints();
  Tensor vertices = model.template_vertices;
  if (betas.defined()) vertices = vertices + model.shape_dirs.slice(2, 0, betas.size(0)).matmul(betas);
  const auto apart = [&](int64_t a, int64_t b) { return (rest[a] - rest[b]).norm().item<double>(); };
  return torch::tensor({apart(0, 15), apart(16, 17), apart(16, 20), apart(1, 2), apart(0, 10),
                        depth_of(model, vertices, kChest), depth_of(model, vertices, kPelvis)},
                       torch::kFloat32);
}

}  // namespace inhabit::inbetween
