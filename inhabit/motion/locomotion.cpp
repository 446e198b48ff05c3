#include "inhabit/motion/locomotion.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/math/quantile.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

constexpr double kRigid = 2e-5;  // metres within which a joint counts as rigid: what six digits of a file leave
constexpr double kStanding = 1e-4;

// Joints from the root to `joint`, both among them.
std::vector<int> path_from_root(const std::vector<int>& parents, int joint) {
  std::vector<int> out;
  for (int j = joint; j >= 0; j = parents[static_cast<size_t>(j)]) out.push_back(j);
  std::reverse(out.begin(), out.end());
  return out;
}

// Diagonal of the box around points (T, 3).
double extent(const torch::Tensor& points) {
  return (std::get<0>(points.max(0)) - std::get<0>(points.min(0))).norm().item<double>();
}

// Forward kinematics in double precision.
void place_joints(Clip& clip) {
  const auto precise = [](const torch::Tensor& t) { return t.defined() ? t.to(torch::kDouble) : t; };
  clip.joints = joint_positions(clip.skeleton, precise(clip.rotations), precise(clip.trans), precise(clip.translations))
                    .to(torch::kFloat);
}

// Whether a joint is elsewhere than in the first frame.
bool translates(const torch::Tensor& places, int64_t joint) {
  return (places.select(1, joint) - places[0][joint]).abs().max().item<double>() > kRigid;
}

}  // namespace

int body_joint(const Skeleton& skeleton) {
  try {
    return find_landmarks(skeleton, "skeleton").pelvis;
  } catch (const Error&) {
    std::vector<int> children(skeleton.parents.size(), 0);
    for (int j = 1; j < skeleton.size(); ++j) ++children[static_cast<size_t>(skeleton.parents[static_cast<size_t>(j)])];
    // Branches alone count: a target of inverse kinematics beside the hips is a joint without children.
    std::vector<std::vector<int>> branches(children.size());
    for (int j = 1; j < skeleton.size(); ++j)
      if (children[static_cast<size_t>(j)] > 0)
        branches[static_cast<size_t>(skeleton.parents[static_cast<size_t>(j)])].push_back(j);
    int joint = 0;
    while (branches[static_cast<size_t>(joint)].size() == 1) joint = branches[static_cast<size_t>(joint)][0];
    return children[static_cast<size_t>(joint)] > 1 ? joint : 0;
  }
}

void set_translations(Clip& clip, torch::Tensor places) {
  const torch::Tensor apart = (places - clip.skeleton.offsets).abs().amax({0, 2});  // (J)
  clip.translations = torch::Tensor();
  if (apart.slice(0, 1).gt(kRigid).any().item<bool>()) {
    // Joints that stay are put to their bones exactly, so that who writes them knows them for rigid.
    const torch::Tensor rigid = apart.le(kRigid).view({1, -1, 1});
    clip.translations = torch::where(rigid, clip.skeleton.offsets.unsqueeze(0), places).contiguous();
    clip.translations.select(1, 0).copy_(clip.skeleton.offsets[0].expand({places.size(0), 3}));
  }
  place_joints(clip);
}

int carry_by_root(Clip& clip) {
  if (!clip.translations.defined() || !clip.rotations.defined() || !clip.trans.defined()) return -1;
  const std::vector<int> chain = path_from_root(clip.skeleton.parents, body_joint(clip.skeleton));
  int carrier = -1;
  for (size_t k = 1; k < chain.size(); ++k)
    if (translates(clip.translations, chain[k])) carrier = chain[k];
  if (carrier < 0) return -1;
  const PoseTrack track = pose_track(clip);
  const std::vector<Eigen::Quaterniond> global = global_rotations(track, clip.skeleton.parents);
  const auto joints = static_cast<size_t>(track.joints);
  const auto place_of = [&](size_t frame, int joint) -> const Eigen::Vector3d& {
    return track.places[frame * joints + static_cast<size_t>(joint)];
  };
  const auto rotation = [&](size_t frame, int joint) -> const Eigen::Quaterniond& {
    return global[frame * joints + static_cast<size_t>(joint)];
  };
  if (extent(clip.joints.select(1, carrier) - clip.joints.select(1, 0)) <= extent(clip.joints.select(1, 0))) return -1;

  // Bones from the root to the carrier, rigid from now on.
  const auto frames = static_cast<size_t>(track.frames());
  torch::Tensor offsets = clip.skeleton.offsets.clone(), places = clip.translations.clone();
  const std::vector<int> moved = path_from_root(clip.skeleton.parents, carrier);
  std::vector<Eigen::Vector3d> root(frames);  // where the root comes
  const auto at = [&](const torch::Tensor& rows, size_t row) {
    const float* p = rows.data_ptr<float>() + 3 * row;
    return Eigen::Vector3d(p[0], p[1], p[2]);
  };
  const torch::Tensor before = clip.joints.contiguous();
  for (size_t t = 0; t < frames; ++t) root[t] = at(before, t * joints + static_cast<size_t>(carrier));
  for (size_t k = 1; k < moved.size(); ++k) {
    const int joint = moved[k], parent = moved[k - 1];
    float* bone = offsets.data_ptr<float>() + 3 * joint;
    if (translates(clip.translations, joint)) {
      const Eigen::Vector3d up = rotation(0, parent).conjugate() * Eigen::Vector3d::UnitY();
      std::vector<double> heights(frames);
      for (size_t t = 0; t < frames; ++t) heights[t] = up.dot(place_of(t, joint));
      Eigen::Map<Eigen::Vector3f>(bone, 3) = (up * median(std::move(heights))).cast<float>();
    }
    const Eigen::Vector3d offset(bone[0], bone[1], bone[2]);
    for (size_t t = 0; t < frames; ++t) root[t] -= rotation(t, parent) * offset;
    places.select(1, joint).copy_(offsets[joint].expand({track.frames(), 3}));
  }
  clip.file.carrier = carrier;
  clip.file.root = {};
  const bool alone =
      std::none_of(moved.begin() + 1, moved.end() - 1, [&](int joint) { return translates(clip.translations, joint); });
  const bool stood = alone && extent(clip.joints.select(1, 0)) < kStanding;
  if (stood)
    for (size_t k = 0; k < 3; ++k) clip.file.root[k] = clip.joints[0][0][static_cast<int64_t>(k)].item<double>();
  else
    clip.file.carrier = -1;

  // The chain's other children stay where they were.
  std::vector<Eigen::Vector3d> old_at(moved.size()), new_at(moved.size());
  float* p = places.data_ptr<float>();
  clip.trans = torch::empty({track.frames(), 3});
  float* trans = clip.trans.data_ptr<float>();
  for (size_t t = 0; t < frames; ++t) {
    new_at[0] = root[t];
    for (size_t k = 1; k < moved.size(); ++k)
      new_at[k] = new_at[k - 1] + rotation(t, moved[k - 1]) * at(offsets, static_cast<size_t>(moved[k]));
    for (size_t k = 0; k + 1 < moved.size(); ++k) {
      old_at[k] = at(before, t * joints + static_cast<size_t>(moved[k]));
      for (size_t j = 1; j < joints; ++j) {
        if (clip.skeleton.parents[j] != moved[k] || static_cast<int>(j) == moved[k + 1]) continue;
        const Eigen::Vector3d place =
            place_of(t, static_cast<int>(j)) + rotation(t, moved[k]).conjugate() * (old_at[k] - new_at[k]);
        Eigen::Map<Eigen::Vector3f>(p + 3 * (t * joints + j), 3) = place.cast<float>();
      }
    }
    Eigen::Map<Eigen::Vector3f>(trans + 3 * t, 3) = (root[t] - at(offsets, 0)).cast<float>();
  }
  clip.skeleton.offsets = offsets;
  set_translations(clip, places);
  return carrier;
}

Clip restore_trajectory(const Clip& clip) {
  const int carrier = clip.file.carrier;
  if (carrier < 1 || carrier >= clip.skeleton.size() || !clip.rotations.defined() || !clip.trans.defined()) return clip;
  Clip out = clip;
  const PoseTrack track = pose_track(clip);
  const std::vector<Eigen::Quaterniond> global = global_rotations(track, clip.skeleton.parents);
  // The joints between root and carrier stay on their bones; what else hangs on them moves the other way.
  const std::vector<int> chain = path_from_root(clip.skeleton.parents, carrier);
  std::vector<std::pair<int64_t, size_t>> moved;  // joint, its parent
  for (int64_t j = 1; j < clip.skeleton.size(); ++j) {
    const int parent = clip.skeleton.parents[static_cast<size_t>(j)];
    const auto in_chain = std::find(chain.begin(), chain.end() - 1, parent);
    if (in_chain == chain.end() - 1 || (*(in_chain + 1) == j && j != carrier)) continue;
    moved.emplace_back(j, static_cast<size_t>(parent));
  }
  const Eigen::Vector3d stands(clip.file.root[0], clip.file.root[1], clip.file.root[2]);
  const torch::Tensor offsets = clip.skeleton.offsets.contiguous();
  torch::Tensor places =
      clip.translations.defined() ? clip.translations.clone() : offsets.unsqueeze(0).repeat({track.frames(), 1, 1});
  const float* o = offsets.data_ptr<float>();
  const Eigen::Vector3d rest(o[0], o[1], o[2]);
  auto rows = places.accessor<float, 3>();
  for (int64_t t = 0; t < track.frames(); ++t) {
    const Eigen::Vector3d gone = track.trans[static_cast<size_t>(t)] + rest - stands;
    for (const auto& [joint, parent] : moved) {
      const Eigen::Vector3d by = global[static_cast<size_t>(t * track.joints) + parent].conjugate() * gone;
      for (int k = 0; k < 3; ++k) rows[t][joint][k] += static_cast<float>(by[k]);
    }
  }
  const Eigen::Vector3d trans = stands - rest;
  out.trans = torch::tensor({trans.x(), trans.y(), trans.z()}, torch::kFloat).repeat({track.frames(), 1});
  set_translations(out, places);
  return out;
}

}  // namespace inhabit
