#include "inhabit/body/body_model.h"
#include "inhabit/body/builtin_body_data.h"
#include "inhabit/body/proportions.h"
#include "inhabit/error.h"

namespace inhabit {
namespace {

using torch::Tensor;

Tensor tensor_of(const std::array<Eigen::Vector3d, kStandardJoints>& points) {
  Tensor t = torch::empty({kStandardJoints, 3});
  auto a = t.accessor<float, 2>();
  for (int j = 0; j < kStandardJoints; ++j)
    for (int i = 0; i < 3; ++i) a[j][i] = static_cast<float>(points[j][i]);
  return t;
}

Skeleton skeleton_of(const Tensor& joints, const std::vector<std::string>& names, const std::vector<int>& parents) {
  Skeleton skeleton{names, parents, joints.clone()};
  for (size_t j = 0; j < parents.size(); ++j)
    if (parents[j] >= 0) skeleton.offsets[static_cast<int64_t>(j)] -= joints[parents[j]];
  return skeleton;
}

struct Range {
  float low, high;
};

/// (22, 3, 2) radians. Ranges of single axes follow the clinical ranges of motion (docs/body.md); since the components
/// of an axis-angle vector mix when a joint rotates about several axes at once, they are widened to hold the
/// combinations met in walking, sitting and reaching.
Tensor builtin_joint_limits() {
  using Axes = std::array<Range, 3>;
  std::array<Axes, kStandardJoints> limits;
  const Axes spine{{{-0.6F, 1.25F}, {-0.7F, 0.7F}, {-0.6F, 0.6F}}};
  limits[0] = {{{-6.3F, 6.3F}, {-6.3F, 6.3F}, {-6.3F, 6.3F}}};
  limits[3] = limits[6] = limits[9] = spine;
  limits[12] = limits[15] = {{{-0.9F, 0.9F}, {-1.1F, 1.1F}, {-0.8F, 0.8F}}};
  // Of the left side; flexing a hip forwards is negative about x, bending a knee positive, pointing the toes positive.
  limits[1] = {{{-2.5F, 0.9F}, {-1.2F, 1.2F}, {-0.9F, 1.2F}}};
  limits[4] = {{{-0.2F, 2.8F}, {-0.7F, 0.7F}, {-0.7F, 0.7F}}};
  limits[7] = {{{-1.1F, 1.1F}, {-0.8F, 0.8F}, {-0.7F, 0.7F}}};
  limits[10] = {{{-1.2F, 1.1F}, {-0.4F, 0.4F}, {-0.4F, 0.4F}}};
  // Arms hang about -1.3 about z from the T-pose and swing forwards negative about y; elbows bend negative about y.
  limits[13] = {{{-0.6F, 0.6F}, {-0.8F, 0.8F}, {-0.6F, 0.8F}}};
  limits[16] = {{{-2.2F, 2.2F}, {-2.5F, 1.6F}, {-2.2F, 2.2F}}};
  limits[18] = {{{-1.9F, 1.9F}, {-2.8F, 0.5F}, {-1.4F, 1.4F}}};
  limits[20] = {{{-1.7F, 1.7F}, {-1.1F, 1.1F}, {-1.6F, 1.6F}}};
  for (int left : {1, 4, 7, 10, 13, 16, 18, 20}) {
    // Mirrored in the x = 0 plane: rotations about y and z change sign.
    const Axes& a = limits[left];
    limits[left + 1] = {{a[0], {-a[1].high, -a[1].low}, {-a[2].high, -a[2].low}}};
  }
  Tensor t = torch::empty({kStandardJoints, 3, 2});
  auto a = t.accessor<float, 3>();
  for (int j = 0; j < kStandardJoints; ++j)
    for (int i = 0; i < 3; ++i) {
      a[j][i][0] = limits[j][i].low;
      a[j][i][1] = limits[j][i].high;
    }
  return t;
}

std::vector<Capsule> builtin_capsules() {
  const auto rest = builtin_rest_joints();
  std::vector<Capsule> capsules;
  // From `joint` to a point given relative to `joint`.
  const auto add = [&](int joint, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius) {
    const Eigen::Vector3f af = a.cast<float>(), bf = b.cast<float>();
    capsules.push_back({joint, {af.x(), af.y(), af.z()}, {bf.x(), bf.y(), bf.z()}, static_cast<float>(radius)});
  };
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  add(0, {-0.075, -0.02, 0}, {0.075, -0.02, 0}, 0.095);
  add(0, {-0.065, -0.065, -0.058}, {0.065, -0.065, -0.058}, 0.080);  // what one sits on
  add(3, {-0.055, 0.03, 0.03}, {0.055, 0.03, 0.03}, 0.095);
  add(6, {-0.060, 0.02, 0.02}, {0.060, 0.02, 0.02}, 0.100);
  add(9, {-0.065, 0.08, 0}, {0.065, 0.08, 0}, 0.100);
  add(12, zero, rest[15] - rest[12], 0.055);
  add(15, {0, 0.05, 0.005}, {0, 0.095, 0.005}, 0.090);
  for (int side = 0; side < 2; ++side) {
    const double x = side == 0 ? 1 : -1;
    add(1 + side, zero, 0.97 * (rest[4] - rest[1]).cwiseProduct(Eigen::Vector3d(x, 1, 1)), 0.068);
    add(4 + side, zero, 0.97 * (rest[7] - rest[4]).cwiseProduct(Eigen::Vector3d(x, 1, 1)), 0.048);
    add(7 + side, {0, -0.045, -0.025}, {x * 0.012, -0.050, 0.120}, 0.034);
    add(10 + side, {-x * 0.010, -0.002, 0.010}, {x * 0.008, -0.002, 0.055}, 0.023);
    add(13 + side, zero, (rest[16] - rest[13]).cwiseProduct(Eigen::Vector3d(x, 1, 1)), 0.055);
    add(16 + side, zero, (rest[18] - rest[16]).cwiseProduct(Eigen::Vector3d(x, 1, 1)), 0.044);
    add(18 + side, zero, (rest[20] - rest[18]).cwiseProduct(Eigen::Vector3d(x, 1, 1)), 0.034);
    add(20 + side, {x * 0.02, 0, 0}, {x * 0.150, -0.005, 0.005}, 0.026);
  }
  return capsules;
}

BodyModel build() {
  BodyModel body;
  body.name = "inhabit";
  body.joint_template = tensor_of(builtin_rest_joints());
  std::vector<Tensor> directions;
  directions.reserve(kBuiltinBetas);
  for (int b = 0; b < kBuiltinBetas; ++b)
    directions.push_back(tensor_of(builtin_joint_direction(static_cast<BuiltinBeta>(b))));
  body.joint_dirs = torch::stack(directions, -1);
  body.skeleton = skeleton_of(body.joint_template, standard_joint_names(), standard_parents());
  const BuiltinSkin skin = builtin_skin_from(builtin_body_file());
  body.template_vertices = skin.vertices;
  body.faces = skin.faces;
  body.skin_weights = skin.weights;
  body.shape_dirs = skin.shape_dirs;
  body.anchors = skin.anchors;
  body.joint_limits = builtin_joint_limits();
  body.capsules = builtin_capsules();
  return body;
}

}  // namespace

const BodyModel& builtin_body() {
  static const BodyModel body = [] {
    const torch::NoGradGuard no_gradient;
    return build();
  }();
  return body;
}

BodyModel body_on(const Skeleton& skeleton) {
  if (skeleton.size() != kStandardJoints) throw Error("body", "needs bones of the standard 22 joints");
  BodyModel body = builtin_body();
  body.skeleton = skeleton;
  body.joint_template = skeleton.rest_joints();
  body.joint_dirs = torch::zeros_like(body.joint_dirs);
  return body;
}

Skeleton shaped_skeleton(const BodyModel& model, const Tensor& betas) {
  if (!betas.defined() || betas.numel() == 0) return model.skeleton;
  if (betas.dim() != 1 || betas.size(0) > model.joint_dirs.size(2))
    throw Error("betas", "expected at most " + std::to_string(model.joint_dirs.size(2)) + " shape parameters");
  const Tensor b = betas.to(model.joint_dirs.options());
  const Tensor joints = model.joint_template + model.joint_dirs.narrow(2, 0, b.size(0)).matmul(b);
  return skeleton_of(joints, model.skeleton.names, model.skeleton.parents);
}

}  // namespace inhabit
