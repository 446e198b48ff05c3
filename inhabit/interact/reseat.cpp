#include "inhabit/interact/reseat.h"

#include "inhabit/error.h"
#include "inhabit/interact/reseat_fit.h"
#include "inhabit/interact/reseat_problem.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/scene/objects.h"

namespace inhabit::interact {
namespace {

/// The clip's scene with the new chair in place of the old one.
Scene with_new_chair(const Scene& scene, const ChairPair& chairs) {
  Scene out = obstacles_of(scene, chairs.old.name);
  for (const Mesh& mesh : scene.meshes)
    if (is_floor(mesh.name)) out.meshes.push_back(mesh);
  for (const Mesh& mesh : chairs.fresh_scene.meshes) out.meshes.push_back(mesh);
  out.name = scene.name;
  return out;
}

/// Contacts of the hands: what is carried over at its new place, what is not no more.
void put_contacts(const ChairStays& stays, Clip& clip) {
  for (const Hold& hold : stays.holds) {
    torch::Tensor rows = clip.hand_targets.slice(0, hold.first, hold.last + 1).select(1, hold.side);
    rows.zero_();
    if (!hold.to) {
      clip.contact.slice(0, hold.first, hold.last + 1).select(1, 20 + hold.side).zero_();
      continue;
    }
    for (size_t k = 0; k < hold.to->points.size(); ++k) {
      torch::Tensor row = rows[static_cast<int64_t>(k)];
      for (int i = 0; i < 3; ++i) row[i] = hold.to->points[k][i];
      row[3] = 1;
    }
  }
}

/// Where the new chair stands: below the middle of its box, turned as one sits on it.
void put_object(const ChairPair& chairs, Clip& clip) {
  for (size_t o = 0; o < clip.object_names.size(); ++o) {
    if (clip.object_names[o] != chairs.fresh.name) continue;
    const torch::Tensor low = std::get<0>(chairs.fresh.mesh.vertices.min(0)),
                        high = std::get<0>(chairs.fresh.mesh.vertices.max(0));
    torch::Tensor pose = torch::zeros({6});
    pose[0] = (low[0] + high[0]) / 2;
    pose[1] = low[1];
    pose[2] = (low[2] + high[2]) / 2;
    pose[4] = chairs.fresh.heading();
    clip.object_pose = clip.object_pose.clone();
    clip.object_pose.select(1, static_cast<int64_t>(o)).copy_(pose.expand({clip.frames(), 6}));
  }
}

}  // namespace

Reseated reseat(const Clip& clip, const Scene& scene, const Scene& chairs, const std::string& chair,
                const ReseatChoices& choices) {
  const torch::NoGradGuard no_gradient;
  validate(clip, "clip");
  if (clip.skeleton.size() != kStandardJoints || !clip.rotations.defined() || !clip.contact.defined())
    throw Error("clip", "needs rotations and contacts on the standard skeleton");
  const auto old = chair_of(clip, scene);
  if (!old) throw Error("clip", "nobody sits in it");
  const ChairPair pair = pair_chairs(*old, chairs, chair);
  ChairStays stays = stays_on(pair, clip);
  if (stays.stays.empty()) throw Error("clip", "nobody sits in it");
  Reseated out;
  const torch::Tensor joints = clip.joints.to(torch::kDouble).contiguous();
  for (Hold& hold : stays.holds) {
    const double* pose = joints.data_ptr<double>() + (hold.first + hold.last) / 2 * 3 * kStandardJoints;
    const auto at = [&](int joint) { return Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(pose + 3 * joint)); };
    hold.to = carry_touch(pair, hold.points, {at(20 + hold.side), {at(1), at(2)}, {at(4), at(5)}});
    ++(hold.to ? out.contacts : out.lost);
  }
  if (out.lost > 0 && !choices.lose_contacts) throw Error(chair, "has no place for what a hand touches");
  out.scene = with_new_chair(scene, pair);
  const Insides insides(pair.fresh_scene);
  ReseatProblem problem(pair, insides, clip, out.scene, stays, choices.frame_by_frame);
  out.clip = refine::clip_of(problem.solve(), clip);
  out.clip.contact = clip.contact.clone();
  if (clip.hand_targets.defined()) out.clip.hand_targets = clip.hand_targets.clone();
  put_contacts(stays, out.clip);
  put_object(pair, out.clip);
  out.fit = measure_fit(clip, scene, insides, stays, out);
  return out;
}

}  // namespace inhabit::interact
