#include "inhabit/interact/reseat_fit.h"

#include <algorithm>
#include <cmath>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/math/rotation.h"
#include "inhabit/metrics/penetration.h"
#include "inhabit/refine/trajectory.h"
#include "inhabit/scene/objects.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;

constexpr int64_t kBlock = 64;  // frames skinned at once

/// Skin (T, V, 3) of frames [first, last).
torch::Tensor skin_between(const Clip& clip, int64_t first, int64_t last) {
  return skin(builtin_body(), clip.betas, axis_angle_to_matrix(clip.rotations.slice(0, first, last)),
              clip.trans.slice(0, first, last));
}

/// Metres that the deepest vertex of the skin is inside, at most over all frames.
double deepest_skin(const Clip& clip, const Insides& insides) {
  double deepest = 0;
  for (int64_t first = 0; first < clip.frames(); first += kBlock) {
    const torch::Tensor places = skin_between(clip, first, std::min(first + kBlock, clip.frames()));
    deepest = std::max(deepest, insides.deepest(places.reshape({-1, 3}).contiguous()));
  }
  return deepest;
}

/// Metres between the seat and the skin that sits, at most over the frames in which the pelvis is in contact.
double seat_gap(const Clip& clip, const Insides& chair, const ChairStays& stays) {
  std::vector<int64_t> own;
  const std::vector<int> owner = skin_owners();
  for (size_t v = 0; v < owner.size(); ++v)
    if (sits_on(owner[v])) own.push_back(static_cast<int64_t>(v));
  double gap = 0;
  for (const Stay& stay : stays.stays)
    for (int64_t first = stay.first; first <= stay.last; first += kBlock) {
      const int64_t last = std::min(first + kBlock, stay.last + 1);
      const torch::Tensor places = skin_between(clip, first, last).index_select(1, torch::tensor(own)).contiguous();
      for (int64_t t = first; t < last; ++t)
        if (clip.contact[t][0].item<float>() > 0.5F) gap = std::max(gap, chair.least_distance(places[t - first]));
    }
  return gap;
}

double farthest_palm(const Clip& before, const refine::Poses& was, const refine::Poses& is, const ChairStays& stays) {
  double gap = 0;
  for (const Hold& hold : stays.holds) {
    if (!hold.to) continue;
    const auto wrist = 20 + static_cast<size_t>(hold.side);
    for (int64_t t = hold.first; t <= hold.last && t < before.frames(); ++t) {
      const auto i = static_cast<size_t>(t), k = static_cast<size_t>(t - hold.first);
      const Vector3d palm = was[i].rotations[wrist].conjugate() * (hold.points[k] - was[i].positions[wrist]);
      gap = std::max(gap, (is[i].positions[wrist] + is[i].rotations[wrist] * palm - hold.to->points[k]).norm());
    }
  }
  return gap;
}

}  // namespace

std::string ReseatFit::fault() const {
  if (!(hand_gap < 0.01)) return "a hand comes no nearer than 1 cm";
  if (!(pelvis_gap < 0.01)) return "the pelvis is over 1 cm above the seat";
  if (!(depth < 0.02)) return "over 2 cm deep in the chair";
  if (!(elsewhere < 0.01)) return "in other furniture";
  if (!(slide < 0.01)) return "a standing foot moves";
  if (!(beyond < 0.02)) return "a joint is beyond its limits";
  if (!(bent < 0.45)) return "the trunk is bent";
  return "";
}

ReseatFit measure_fit(const Clip& before, const Scene& scene, const Insides& chair, const ChairStays& stays,
                      const Reseated& out) {
  ReseatFit fit;
  const Bones bones = bones_of(before.skeleton);
  const refine::Poses was = refine::posed(bones, refine::trajectory_of(before)),
                      is = refine::posed(bones, refine::trajectory_of(out.clip));
  fit.hand_gap = farthest_palm(before, was, is, stays);
  fit.pelvis_gap = seat_gap(out.clip, chair, stays);
  fit.depth = deepest_skin(out.clip, chair);
  const Insides others(obstacles_of(scene, stays.chair));
  if (const double now = deepest_skin(out.clip, others); now > 0)
    fit.elsewhere = std::max(0.0, now - deepest_skin(before, others));
  const refine::Trajectory old = refine::trajectory_of(before), fresh = refine::trajectory_of(out.clip);
  for (size_t t = 0; t < is.size(); ++t)
    for (const size_t joint : {3, 6, 9, 12, 15})
      fit.bent = std::max(fit.bent, old[t].local[joint].angularDistance(fresh[t].local[joint]));
  for (size_t t = 0; t < is.size(); ++t)
    for (const int64_t joint : kFootJoints) {
      const auto j = static_cast<size_t>(joint);
      if (before.contact[static_cast<int64_t>(t)][joint].item<float>() > 0.5F)
        fit.slide = std::max(fit.slide, (is[t].positions[j] - was[t].positions[j]).norm());
    }
  const BodyModel& body = builtin_body();
  fit.beyond = std::max(0.0, beyond_limits(out.clip, body).radians - beyond_limits(before, body).radians);
  return fit;
}

}  // namespace inhabit::interact
