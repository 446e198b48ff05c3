#include "inhabit/metrics/penetration.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "inhabit/body/capsules.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "inhabit/scene/query.h"

namespace inhabit {
namespace {

constexpr double kSpacing = 0.03;

Scene without(const Scene& scene, const std::string& object) {
  Scene out;
  out.name = scene.name;
  for (const Mesh& mesh : scene.meshes) {
    const std::string name = object_of_mesh(mesh.name);
    if (name != "floor" && name != "rug" && (object.empty() || name != object)) out.meshes.push_back(mesh);
  }
  return out;
}

}  // namespace

std::string object_of_mesh(const std::string& mesh_name) {
  const size_t dot = mesh_name.rfind('.');
  if (dot == std::string::npos || dot + 1 == mesh_name.size()) return mesh_name;
  const bool number = std::all_of(mesh_name.begin() + static_cast<long>(dot) + 1, mesh_name.end(),
                                  [](char c) { return c >= '0' && c <= '9'; });
  return number ? mesh_name.substr(0, dot) : mesh_name;
}

torch::Tensor capsule_depths(const Clip& clip, const BodyModel& body, const SceneQuery& query) {
  if (!clip.rotations.defined() || !clip.trans.defined()) throw Error("capsules need a clip with joint rotations");
  const int64_t T = clip.frames();
  const Pose pose = forward_kinematics(clip.skeleton.parents, clip.skeleton.offsets,
                                       axis_angle_to_matrix(clip.rotations), clip.trans);
  std::vector<torch::Tensor> points;
  std::vector<int64_t> samples;
  std::vector<float> radii;
  for (const Capsule& c : shaped_capsules(body, clip.betas)) {
    radii.push_back(c.radius);
    const torch::Tensor a = torch::tensor({c.a[0], c.a[1], c.a[2]}), b = torch::tensor({c.b[0], c.b[1], c.b[2]});
    const int64_t n = 1 + static_cast<int64_t>(std::ceil((b - a).norm().item<double>() / kSpacing));
    const torch::Tensor own = a + torch::linspace(0, 1, n).unsqueeze(1) * (b - a);  // (n, 3)
    const torch::Tensor turned = torch::matmul(pose.rotations.select(1, c.joint), own.t()).transpose(1, 2);
    points.push_back(turned + pose.positions.select(1, c.joint).unsqueeze(1));
    samples.push_back(n);
  }
  const torch::Tensor all = torch::cat(points, 1);
  const torch::Tensor distance = query.signed_distance(all.reshape({-1, 3}).contiguous()).view({T, all.size(1)});
  std::vector<torch::Tensor> depths;
  int64_t first = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    depths.push_back(radii[i] - std::get<0>(distance.slice(1, first, first + samples[i]).min(1)));
    first += samples[i];
  }
  return torch::stack(depths, 1);
}

std::vector<std::string> supporting_objects(const Clip& clip, const Scene& scene) {
  const int64_t T = clip.frames();
  std::vector<std::string> out(static_cast<size_t>(T));
  if (!clip.contact.defined()) return out;
  // On the way down and up, where actions tell. A clip may end or begin on the way.
  const torch::Tensor way = [&] {
    torch::Tensor any = torch::zeros({T}, torch::kBool);
    for (const char* name : {"sit_down", "stand_up"})
      for (size_t a = 0; a < clip.action_names.size(); ++a)
        if (clip.action.defined() && clip.action_names[a] == name) any |= clip.action == static_cast<int64_t>(a);
    return any;
  }();
  const torch::Tensor sits = clip.contact.index_select(1, torch::tensor({0, 1, 2, 3, 6, 9})).gt(0.5).any(1);
  for (const int64_t t : {int64_t{0}, T - 1}) sits[t].logical_or_(way[t]);
  const torch::Tensor frames = sits.nonzero().flatten();
  if (frames.numel() == 0) return out;
  const Scene solid = without(scene, "");
  if (solid.meshes.empty()) return out;
  // The nearest below or behind: a little under the root, where a seat is.
  const torch::Tensor probe = clip.joints.select(1, 0).index_select(0, frames) - torch::tensor({0.F, 0.08F, 0.F});
  const torch::Tensor mesh = SceneQuery(solid).closest(probe.contiguous()).mesh;
  for (int64_t i = 0; i < frames.numel(); ++i) {
    const int64_t m = mesh[i].item<int64_t>();
    if (m >= 0)
      out[static_cast<size_t>(frames[i].item<int64_t>())] = object_of_mesh(solid.meshes[static_cast<size_t>(m)].name);
  }
  const bool* on_way = way.data_ptr<bool>();
  for (int64_t t = 1; t < T; ++t)
    if (out[t].empty() && on_way[t]) out[t] = out[t - 1];
  for (int64_t t = T - 2; t >= 0; --t)
    if (out[t].empty() && on_way[t]) out[t] = out[t + 1];
  return out;
}

Penetration deepest_penetration(const Clip& clip, const BodyModel& body, const Scene& scene) {
  Penetration out;
  const std::vector<std::string> supports = supporting_objects(clip, scene);
  std::map<std::string, std::vector<int64_t>> frames_with;  // by what is left out
  for (size_t t = 0; t < supports.size(); ++t) frames_with[supports[t]].push_back(static_cast<int64_t>(t));
  for (const auto& [object, frames] : frames_with) {
    const Scene solid = without(scene, object);
    if (solid.meshes.empty()) continue;
    const torch::Tensor index = torch::tensor(frames);
    Clip part;
    part.skeleton = clip.skeleton;
    part.rate = clip.rate;
    part.joints = clip.joints.index_select(0, index);
    part.rotations = clip.rotations.index_select(0, index);
    part.betas = clip.betas;
    part.trans = clip.trans.index_select(0, index);
    const SceneQuery query(solid);
    const torch::Tensor depths = capsule_depths(part, body, query);
    const double depth = depths.max().item<double>();
    if (depth <= out.depth) continue;
    const int64_t at = depths.argmax().item<int64_t>();
    out.depth = depth;
    out.frame = frames[static_cast<size_t>(at / depths.size(1))];
    out.joint = body.capsules[static_cast<size_t>(at % depths.size(1))].joint;
    const torch::Tensor where = part.joints[at / depths.size(1)][out.joint].view({1, 3});
    const int64_t mesh = query.closest(where.contiguous()).mesh[0].item<int64_t>();
    if (mesh >= 0) out.object = solid.meshes[static_cast<size_t>(mesh)].name;
  }
  return out;
}

LimitExcess beyond_limits(const Clip& clip, const BodyModel& body) {
  LimitExcess out;
  if (!clip.rotations.defined() || !body.joint_limits.defined()) return out;
  const int64_t J = std::min<int64_t>(clip.rotations.size(1), body.joint_limits.size(0));
  const torch::Tensor r = clip.rotations.slice(1, 1, J);  // the root may turn as it likes
  const torch::Tensor limits = body.joint_limits.slice(0, 1, J);
  const torch::Tensor excess = torch::maximum(limits.select(2, 0) - r, r - limits.select(2, 1));
  const int64_t at = excess.argmax().item<int64_t>();
  out.radians = std::max(0.0, excess.max().item<double>());
  out.frame = at / ((J - 1) * 3);
  out.joint = static_cast<int>(at / 3 % (J - 1)) + 1;
  return out;
}

HandContact hand_contact(const Clip& clip, const BodyModel& body, const Scene& scene) {
  HandContact out;
  if (!clip.hand_targets.defined()) return out;
  const Scene solid = without(scene, "");
  if (solid.meshes.empty()) return out;
  std::unique_ptr<SceneQuery> query;
  for (int hand = 0; hand < 2; ++hand) {
    const torch::Tensor label = clip.hand_targets.select(1, hand);
    const torch::Tensor frames = label.select(1, 3).gt(0.5).nonzero().flatten();
    if (frames.numel() == 0) continue;
    out.contacts += frames.numel();
    if (query == nullptr) query = std::make_unique<SceneQuery>(solid);
    const torch::Tensor target = label.index_select(0, frames).slice(1, 0, 3).contiguous();
    out.target_gap = std::max(out.target_gap, query->closest(target).distances.max().item<double>());
    if (!clip.rotations.defined()) continue;
    // The skin that hangs on the wrist.
    const torch::Tensor own = body.skin_weights.select(1, 20 + hand).gt(0.5).nonzero().flatten();
    if (own.numel() == 0) continue;
    const torch::Tensor skin_points =
        skin(body, clip.betas, axis_angle_to_matrix(clip.rotations.index_select(0, frames)),
             clip.trans.index_select(0, frames))
            .index_select(1, own);
    const torch::Tensor distance =
        query->closest(skin_points.reshape({-1, 3}).contiguous()).distances.view({frames.numel(), own.numel()});
    out.hand_gap = std::max(out.hand_gap, std::get<0>(distance.min(1)).max().item<double>());
  }
  return out;
}

}  // namespace inhabit
