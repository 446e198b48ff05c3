#include "inhabit/io/smpl_model.h"

#include "inhabit/error.h"
#include "inhabit/math/furthest_points.h"

namespace inhabit {
namespace {

using torch::Tensor;

Tensor floats(const Npz& npz, const char* name, const std::string& subject) {
  const Tensor t = npz.at(name, subject).to(torch::kFloat32);
  if (!torch::isfinite(t).all().item<bool>())
    throw Error(subject, std::string("its array ") + name + " has a value that is not finite");
  return t;
}

void expect_shape(const Tensor& t, std::vector<int64_t> shape, const char* name, const std::string& subject) {
  if (t.sizes().vec() != shape) throw Error(subject, std::string("its array ") + name + " has the wrong shape");
}

std::vector<std::string> joint_names(int64_t joints) {
  std::vector<std::string> names = standard_joint_names();
  if (joints == 24) names.insert(names.end(), {"left_hand", "right_hand"});
  if (joints == 55) names.insert(names.end(), {"jaw", "left_eye", "right_eye"});
  if (joints == 52 || joints == 55)
    for (const char* side : {"left", "right"})
      for (const char* finger : {"index", "middle", "pinky", "ring", "thumb"})
        for (const char* knuckle : {"1", "2", "3"}) names.push_back(std::string(side) + "_" + finger + knuckle);
  return names;
}

}  // namespace

bool holds_smpl_model(const Npz& npz) { return npz.has("v_template") && npz.has("shapedirs"); }

BodyModel smpl_model_from_npz(const Npz& npz, const std::string& subject) {
  const torch::NoGradGuard no_gradient;
  BodyModel body;
  body.template_vertices = floats(npz, "v_template", subject);
  if (body.template_vertices.dim() != 2 || body.template_vertices.size(1) != 3 || body.template_vertices.size(0) < 4)
    throw Error(subject, "v_template is not (V, 3)");
  const int64_t V = body.template_vertices.size(0);
  const Tensor regressor = floats(npz, "J_regressor", subject);
  if (regressor.dim() != 2 || regressor.size(1) != V) throw Error(subject, "J_regressor is not (J, V)");
  const int64_t J = regressor.size(0);
  if (J != 24 && J != 52 && J != 55)
    throw Error(subject, "has " + std::to_string(J) + " joints: not SMPL (24), SMPL-H (52) or SMPL-X (55)");
  body.name = J == 24 ? "smpl" : J == 52 ? "smplh" : "smplx";

  Tensor shape = floats(npz, "shapedirs", subject);
  if (shape.dim() != 3 || shape.size(0) != V || shape.size(1) != 3 || shape.size(2) == 0)
    throw Error(subject, "shapedirs is not (V, 3, B)");
  if (J == 55 && shape.size(2) == 400) shape = shape.narrow(2, 0, 300);
  if (J == 55 && shape.size(2) == 20) shape = shape.narrow(2, 0, 10);
  body.shape_dirs = shape.contiguous();
  if (npz.has("posedirs")) {
    body.pose_dirs = floats(npz, "posedirs", subject);
    expect_shape(body.pose_dirs, {V, 3, 9 * (J - 1)}, "posedirs", subject);
  }
  body.skin_weights = floats(npz, "weights", subject);
  expect_shape(body.skin_weights, {V, J}, "weights", subject);
  const Tensor sums = body.skin_weights.sum(1);
  if (body.skin_weights.lt(-1e-4).any().item<bool>() || (sums - 1).abs().gt(0.05).any().item<bool>())
    throw Error(subject, "the skin weights of a vertex do not sum to 1");
  body.skin_weights = body.skin_weights / sums.unsqueeze(1);

  const Tensor faces = npz.at("f", subject);
  if (faces.dim() != 2 || faces.size(1) != 3 || faces.is_floating_point() || faces.size(0) == 0)
    throw Error(subject, "f is not (F, 3) whole numbers");
  body.faces = faces.to(torch::kInt64);
  if (body.faces.min().item<int64_t>() < 0 || body.faces.max().item<int64_t>() >= V)
    throw Error(subject, "a face names a vertex that does not exist");

  const Tensor tree = npz.at("kintree_table", subject).to(torch::kInt64);
  expect_shape(tree, {2, J}, "kintree_table", subject);
  for (int64_t j = 0; j < J; ++j) {
    // The root's parent is written as -1 or as 2^32 - 1.
    const int64_t parent = j == 0 ? -1 : tree[0][j].item<int64_t>();
    if (j > 0 && (parent < 0 || parent >= j)) throw Error(subject, "kintree_table is no tree of joints in order");
    body.skeleton.parents.push_back(static_cast<int>(parent));
  }
  body.skeleton.names = joint_names(J);
  if (!std::equal(standard_parents().begin(), standard_parents().end(), body.skeleton.parents.begin()))
    throw Error(subject, "its first 22 joints are not connected as SMPL's");

  body.joint_template = regressor.matmul(body.template_vertices);
  const int64_t B = body.shape_dirs.size(2);
  body.joint_dirs = regressor.matmul(body.shape_dirs.reshape({V, 3 * B})).view({J, 3, B});
  body.skeleton.offsets = body.joint_template.clone();
  for (int64_t j = 1; j < J; ++j)
    body.skeleton.offsets[j] -= body.joint_template[body.skeleton.parents[static_cast<size_t>(j)]];
  body.skeleton.validate(subject);

  body.joint_limits = torch::tensor({-3.2F, 3.2F}).repeat({J, 3, 1});
  body.joint_limits.narrow(0, 0, kStandardJoints).copy_(builtin_body().joint_limits);
  body.capsules = builtin_body().capsules;
  body.anchors = furthest_point_indices(body.template_vertices, std::min<int64_t>(64, V));
  return body;
}

BodyModel read_smpl_model(const std::string& path) {
  if (path.size() > 4 && path.compare(path.size() - 4, 4, ".pkl") == 0)
    throw Error(path, "is a pickle; the .npz form of the model is needed");
  const Npz npz = read_npz(path);
  if (!holds_smpl_model(npz) && npz.skipped.count("v_template") == 0 && !npz.has("v_template"))
    throw Error(path, "is no SMPL, SMPL-H or SMPL-X model file (no v_template and shapedirs)");
  return smpl_model_from_npz(npz, path);
}

}  // namespace inhabit
