#include "inhabit/inbetween/keyed_clip.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/pose_track.h"
#include "inhabit/motion/retarget.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr int64_t kSeam = 15;  // frames of a loop in which the end of its motion is blended into its start

std::vector<int64_t> asked_keys(const Clip& clip, const Options& options) {
  if (clip.frames() < 2) throw Error(options.name, "has fewer than two frames");
  if (options.keys.empty()) return {0, clip.frames() - 1};
  const auto& keys = options.keys;
  if (keys.size() < 2) throw Error(options.keys_name, "are fewer than two");
  if (keys.front() != 0 || keys.back() != clip.frames() - 1)
    throw Error(options.keys_name, "the first and the last frame must be among them");
  for (size_t i = 1; i < keys.size(); ++i)
    if (keys[i] <= keys[i - 1]) throw Error(options.keys_name, "are not in order");
  return keys;
}

Clip on_standard_skeleton(const Clip& clip, const std::string& name) {
  const bool standard = clip.skeleton.parents == standard_parents() && clip.rotations.defined() && clip.trans.defined();
  Clip out = standard ? clip : retarget(clip, name);
  out.file = {};
  if (out.translations.defined()) {  // the model knows rigid bones
    out.translations = Tensor();
    out.joints = joint_positions(out.skeleton, out.rotations, out.trans);
  }
  return out;
}

/// What moves the first pose of a clip to where the last stands.
std::pair<GroundTransform, GroundTransform> first_to_last(const Clip& standard) {
  return {canonical_transform(standard, 0), canonical_transform(standard, standard.frames() - 1).inverse()};
}

/// Whether a contact is where somebody can be between the first and the last pose, at a sprint and with a stretched
/// arm. In other units (a place in centimetres) it is not, and a body drawn there could end up anywhere.
bool can_be_at(const JointContact& contact, const Clip& clip) {
  constexpr double kSprint = 10, kStretch = 2;  // m/s, metres
  const torch::Tensor roots = clip.root_path().to(torch::kFloat64).contiguous();
  const auto reaches = [&](int64_t frame, double seconds) {
    const double* root = roots.data_ptr<double>() + 3 * frame;
    return (contact.place - Eigen::Vector3d(root[0], root[1], root[2])).norm() <= kStretch + kSprint * seconds;
  };
  const double last = static_cast<double>(clip.frames() - 1) / clip.rate;
  return reaches(0, contact.from) && reaches(clip.frames() - 1, std::max(0.0, last - contact.to));
}

Eigen::Vector3d moved(const Eigen::Vector3d& place, const GroundTransform& by) {
  return Eigen::AngleAxisd(by.yaw, Eigen::Vector3d::UnitY()) * place + by.shift;
}

}  // namespace

KeyedClip keyed_clip(const Clip& clip, const Options& options, double rate) {
  const std::vector<int64_t> asked = asked_keys(clip, options);
  check(options.controls, asked.size(), static_cast<double>(clip.frames() - 1) / clip.rate);
  Clip source = clip, standard = on_standard_skeleton(clip, options.name);
  if (options.controls.loop) {
    source = with_looped_end(source, standard);
    standard = with_looped_end(standard, standard);
  }
  KeyedClip out;
  out.controls = options.controls;
  std::vector<double>& weights = out.controls.key_weights;
  weights.clear();
  std::vector<int64_t> frames;
  for (size_t k = 0; k < asked.size(); ++k) {
    const int64_t frame = asked[k], key = std::llround(static_cast<double>(frame) * rate / clip.rate);
    if (!out.keys.empty() && key == out.keys.back()) {
      if (frame + 1 < clip.frames() || out.keys.size() == 1) continue;
      out.keys.pop_back();
      frames.pop_back();
      if (!weights.empty()) weights.pop_back();
    }
    out.keys.push_back(key);
    frames.push_back(frame);
    if (!options.controls.key_weights.empty()) weights.push_back(options.controls.key_weights[k]);
  }
  if (out.keys.size() < 2)
    throw Error(options.name, fmt::format("is shorter than two frames of the model's, 1/{:g} s each", rate));
  std::vector<int64_t> pose_of;
  for (size_t k = 0; k + 1 < out.keys.size(); ++k)
    pose_of.insert(pose_of.end(), static_cast<size_t>(out.keys[k + 1] - out.keys[k]), frames[k]);
  pose_of.push_back(frames.back());
  out.clip = frames_at(standard, pose_of);
  out.clip.rate = rate;
  out.source = poses_of(source, standard, asked, frames, out.keys);
  for (const Tensor& t : {out.clip.joints, out.clip.rotations, out.clip.trans})
    if (!t.index_select(0, torch::tensor(out.keys)).isfinite().all().item<bool>())
      throw Error(options.name, "a key pose is not finite");
  std::erase_if(out.controls.contacts, [&](const JointContact& contact) { return !can_be_at(contact, out.clip); });
  return out;
}

KeyedClip twice(const KeyedClip& keyed) {
  const auto [to_origin, from_origin] = first_to_last(keyed.clip);
  const Clip next = transformed(transformed(keyed.clip, to_origin), from_origin);
  const int64_t frames = keyed.clip.frames();
  KeyedClip out = keyed;
  for (Tensor Clip::*part : {&Clip::joints, &Clip::rotations, &Clip::trans})
    out.clip.*part = torch::cat({keyed.clip.*part, (next.*part).slice(0, 1)});
  for (size_t k = 1; k < keyed.keys.size(); ++k) out.keys.push_back(keyed.keys[k] + frames - 1);
  Controls& c = out.controls;
  const double seconds = static_cast<double>(frames - 1) / keyed.clip.rate;
  if (!c.key_weights.empty())
    c.key_weights.insert(c.key_weights.end(), keyed.controls.key_weights.begin() + 1, keyed.controls.key_weights.end());
  for (JointContact contact : keyed.controls.contacts) {
    contact.from += seconds;
    contact.to += seconds;
    contact.place = moved(moved(contact.place, to_origin), from_origin);
    c.contacts.push_back(contact);
  }
  for (const PathPoint& point : keyed.controls.root_path) {
    const Eigen::Vector3d place = moved(moved({point.place.x(), 0, point.place.y()}, to_origin), from_origin);
    c.root_path.push_back({point.seconds + seconds, {place.x(), place.z()}});
  }
  return out;
}

Clip folded(const Clip& filled) {
  const int64_t frames = (filled.frames() + 1) / 2;
  const Clip first = slice(filled, 0, frames), second = slice(filled, frames - 1, filled.frames());
  const auto [to_origin, from_origin] = first_to_last(first);
  const Clip back = transformed(transformed(second, from_origin.inverse()), to_origin.inverse());
  std::vector<double> weights;  // of the second, whose start is what follows on the first's end
  for (int64_t t = 0; t < frames; ++t) {
    const double gone = std::min(1.0, static_cast<double>(t) / static_cast<double>(std::min(kSeam, frames - 1)));
    weights.push_back(1 - gone * gone * (3 - 2 * gone));
  }
  return mixed(first, back, weights);
}

}  // namespace inhabit::inbetween
