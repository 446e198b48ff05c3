#include "inhabit/motion/pose_track.h"

#include "inhabit/body/bones.h"
#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"

namespace inhabit {

PoseTrack pose_track(const Clip& clip) {
  if (!clip.rotations.defined() || !clip.trans.defined()) throw Error("the motion has no rotations, only positions");
  PoseTrack track;
  track.joints = clip.skeleton.size();
  const int64_t frames = clip.rotations.size(0);
  track.local.reserve(static_cast<size_t>(frames * track.joints));
  track.trans.reserve(static_cast<size_t>(frames));
  const torch::Tensor rotations = clip.rotations.to(torch::kCPU, torch::kDouble).contiguous();
  const torch::Tensor trans = clip.trans.to(torch::kCPU, torch::kDouble).contiguous();
  const double* r = rotations.data_ptr<double>();
  const double* p = trans.data_ptr<double>();
  for (int64_t k = 0; k < frames * track.joints; ++k, r += 3) track.local.push_back(quaternion_of({r[0], r[1], r[2]}));
  for (int64_t t = 0; t < frames; ++t, p += 3) track.trans.emplace_back(p[0], p[1], p[2]);
  if (clip.translations.defined()) {
    const torch::Tensor places = clip.translations.to(torch::kCPU, torch::kDouble).contiguous();
    const double* x = places.data_ptr<double>();
    track.places.reserve(track.local.size());
    for (size_t k = 0; k < track.local.size(); ++k, x += 3) track.places.emplace_back(x[0], x[1], x[2]);
  }
  return track;
}

void set_pose(Clip& clip, const PoseTrack& track) {
  const int64_t frames = track.frames(), joints = track.joints;
  clip.rotations = torch::empty({frames, joints, 3});
  clip.joints = torch::empty({frames, joints, 3});
  clip.trans = torch::empty({frames, 3});
  float* r = clip.rotations.data_ptr<float>();
  float* p = clip.joints.data_ptr<float>();
  float* root = clip.trans.data_ptr<float>();
  clip.translations = track.places.empty() ? torch::Tensor() : torch::empty({frames, joints, 3});
  float* x = track.places.empty() ? nullptr : clip.translations.data_ptr<float>();
  Bones bones = bones_of(clip.skeleton);
  BonesPose pose;
  std::vector<Eigen::Quaterniond> local(static_cast<size_t>(joints));
  for (int64_t t = 0; t < frames; ++t, root += 3) {
    const auto first = track.local.begin() + t * joints;
    std::copy(first, first + joints, local.begin());
    if (x != nullptr) {
      const auto place = track.places.begin() + t * joints;
      std::copy(place, place + joints, bones.offsets.begin());
      for (int64_t j = 0; j < joints; ++j, x += 3) Eigen::Map<Eigen::Vector3f>(x, 3) = place[j].cast<float>();
    }
    pose_bones(bones, local, track.trans[static_cast<size_t>(t)], pose);
    Eigen::Map<Eigen::Vector3f>(root, 3) = track.trans[static_cast<size_t>(t)].cast<float>();
    for (size_t j = 0; j < static_cast<size_t>(joints); ++j, r += 3, p += 3) {
      Eigen::Map<Eigen::Vector3f>(r, 3) = axis_angle_of(local[j]).cast<float>();
      Eigen::Map<Eigen::Vector3f>(p, 3) = pose.positions[j].cast<float>();
    }
  }
}

void interpolate_between(PoseTrack& track, int64_t from, int64_t to) {
  const auto a = static_cast<size_t>(from), b = static_cast<size_t>(to);
  for (int64_t t = from + 1; t < to; ++t) {
    const double u = static_cast<double>(t - from) / static_cast<double>(to - from);
    track.trans[static_cast<size_t>(t)] = (1 - u) * track.trans[a] + u * track.trans[b];
    for (int j = 0; j < track.joints; ++j) track.at(t, j) = track.at(from, j).slerp(u, track.at(to, j));
  }
}

std::vector<Eigen::Quaterniond> global_rotations(const PoseTrack& track, const std::vector<int>& parents) {
  std::vector<Eigen::Quaterniond> global(track.local.size());
  for (int64_t t = 0; t < track.frames(); ++t)
    for (int j = 0; j < track.joints; ++j) {
      const auto k = static_cast<size_t>(t * track.joints + j);
      const int parent = parents[static_cast<size_t>(j)];
      global[k] = parent < 0 ? track.local[k] : global[static_cast<size_t>(t * track.joints + parent)] * track.local[k];
    }
  return global;
}

PoseTrack mixed(PoseTrack a, const PoseTrack& b, const std::vector<double>& weights) {
  for (int64_t t = 0; t < a.frames(); ++t) {
    const auto frame = static_cast<size_t>(t);
    a.trans[frame] += weights[frame] * (b.trans[frame] - a.trans[frame]);
    for (int j = 0; j < a.joints; ++j) {
      a.at(t, j) = a.at(t, j).slerp(weights[frame], b.at(t, j));
      const size_t at = frame * static_cast<size_t>(a.joints) + static_cast<size_t>(j);
      if (!a.places.empty() && !b.places.empty()) a.places[at] += weights[frame] * (b.places[at] - a.places[at]);
    }
  }
  return a;
}

Clip mixed(const Clip& a, const Clip& b, const std::vector<double>& weights) {
  Clip out = a;
  set_pose(out, mixed(pose_track(a), pose_track(b), weights));
  return out;
}

}  // namespace inhabit
