#include "inhabit/metrics/penetration.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "inhabit/body/joint_limits.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/interruption.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/placed_body.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/query.h"

namespace inhabit {
namespace {

constexpr double kSpacing = 0.03;
constexpr int64_t kDepthFrames = 256;

}  // namespace

torch::Tensor capsule_depths(const Clip& clip, const BodyModel& body, const SceneQuery& query) {
  if (clip.frames() > kDepthFrames) {
    std::vector<torch::Tensor> parts;
    for (int64_t first = 0; first < clip.frames(); first += kDepthFrames) {
      interruption_point();
      parts.push_back(capsule_depths(slice(clip, first, std::min(first + kDepthFrames, clip.frames())), body, query));
    }
    return torch::cat(parts);
  }
  const CapsulePoints capsules = capsule_points(clip, body, kSpacing);
  const torch::Tensor distance = query.signed_distance(capsules.points.reshape({-1, 3}).contiguous())
                                     .view({clip.frames(), capsules.points.size(1)});
  std::vector<torch::Tensor> depths;
  for (size_t i = 0; i < capsules.radii.size(); ++i)
    depths.push_back(capsules.radii[i] -
                     std::get<0>(distance.slice(1, capsules.first[i], capsules.first[i + 1]).min(1)));
  return torch::stack(depths, 1);
}

std::vector<std::string> supporting_objects(const Clip& clip, const Scene& scene) {
  const int64_t T = clip.frames();
  std::vector<std::string> out(static_cast<size_t>(T));
  if (!clip.contact.defined()) return out;
  // Going down or up, where actions tell. A clip may end or begin so.
  const torch::Tensor transitions = [&] {
    torch::Tensor any = torch::zeros({T}, torch::kBool);
    for (const char* name : {"sit_down", "stand_up"})
      for (size_t a = 0; a < clip.action_names.size(); ++a)
        if (clip.action.defined() && clip.action_names[a] == name) any |= clip.action == static_cast<int64_t>(a);
    return any;
  }();
  const torch::Tensor sits = clip.contact.index_select(1, torch::tensor({0, 1, 2, 3, 6, 9})).gt(0.5).any(1);
  for (const int64_t t : {int64_t{0}, T - 1}) sits[t].logical_or_(transitions[t]);
  const torch::Tensor frames = sits.nonzero().flatten();
  if (frames.numel() == 0) return out;
  const Scene solid = obstacles_of(scene);
  if (solid.meshes.empty()) return out;
  // The nearest below or behind: a little under the root, where a seat is.
  const torch::Tensor probe = clip.joints.select(1, 0).index_select(0, frames) - torch::tensor({0.F, 0.08F, 0.F});
  const torch::Tensor mesh = SceneQuery(solid).closest(probe.contiguous()).mesh;
  for (int64_t i = 0; i < frames.numel(); ++i) {
    const int64_t m = mesh[i].item<int64_t>();
    if (m >= 0)
      out[static_cast<size_t>(frames[i].item<int64_t>())] = object_of_mesh(solid.meshes[static_cast<size_t>(m)].name);
  }
  const bool* in_transition = transitions.data_ptr<bool>();
  for (int64_t t = 1; t < T; ++t)
    if (out[t].empty() && in_transition[t]) out[t] = out[t - 1];
  for (int64_t t = T - 2; t >= 0; --t)
    if (out[t].empty() && in_transition[t]) out[t] = out[t + 1];
  return out;
}

Penetration deepest_penetration(const Clip& clip, const BodyModel& body, const Scene& scene) {
  Penetration out;
  const std::vector<std::string> supports = supporting_objects(clip, scene);
  std::map<std::string, std::vector<int64_t>> frames_with;  // by what is left out
  for (size_t t = 0; t < supports.size(); ++t) frames_with[supports[t]].push_back(static_cast<int64_t>(t));
  for (const auto& [object, frames] : frames_with) {
    const Scene solid = obstacles_of(scene, object);
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
  if (!clip.rotations.defined()) return out;
  const JointLimits limits = joint_limits(body);
  const int64_t joints = std::min<int64_t>(clip.rotations.size(1), body.joints());
  const torch::Tensor rotations = clip.rotations.to(torch::kDouble).contiguous();
  const auto r = rotations.accessor<double, 3>();
  for (int64_t t = 0; t < clip.frames(); ++t)
    for (int64_t j = 1; j < joints; ++j) {  // the root may rotate as it likes
      const double over =
          limits.beyond(static_cast<size_t>(j), {r[t][j][0], r[t][j][1], r[t][j][2]}).cwiseAbs().maxCoeff();
      if (over > out.radians) out = {over, t, static_cast<int>(j)};
    }
  return out;
}

HandContact hand_contact(const Clip& clip, const BodyModel& body, const Scene& scene) {
  HandContact out;
  if (!clip.hand_targets.defined()) return out;
  const Scene solid = obstacles_of(scene);
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
    const torch::Tensor places = skin(body, clip.betas, axis_angle_to_matrix(clip.rotations.index_select(0, frames)),
                                      clip.trans.index_select(0, frames))
                                     .index_select(1, own);
    const torch::Tensor distance =
        query->closest(places.reshape({-1, 3}).contiguous()).distances.view({frames.numel(), own.numel()});
    out.hand_gap = std::max(out.hand_gap, std::get<0>(distance.min(1)).max().item<double>());
  }
  return out;
}

}  // namespace inhabit
