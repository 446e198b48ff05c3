#include "inhabit/serve/frames.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "inhabit/interact/labels.h"
#include "inhabit/interact/live_person.h"

namespace inhabit::serve {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are sent as they lie in memory");

template <typename T>
void append(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_pose(std::string& to, const Frame& frame) {
  for (int a = 0; a < 3; ++a) append(to, frame.trans[a]);
  for (const Eigen::Quaternionf& q : frame.rotation)
    for (int k = 0; k < 4; ++k)
      append(to, static_cast<int16_t>(std::lround(32767 * std::clamp(q.coeffs()[k], -1.F, 1.F))));
}

}  // namespace

Frame frame_of(const interact::SettledPose& pose) {
  Frame out;
  for (size_t j = 0; j < out.rotation.size(); ++j) out.rotation[j] = pose.local[j].cast<float>().normalized();
  out.trans = pose.trans.cast<float>();
  return out;
}

interact::SettledPose pose_of(const Frame& frame) {
  interact::SettledPose out;
  for (const Eigen::Quaternionf& q : frame.rotation) out.local.push_back(q.cast<double>().normalized());
  out.trans = frame.trans.cast<double>();
  return out;
}

Frame frame_of(const Clip& clip, int64_t index) {
  Frame out;
  const std::vector<Eigen::Quaterniond> local = local_quaternions(clip.rotations[index].slice(0, 0, kStandardJoints));
  for (size_t j = 0; j < out.rotation.size(); ++j) out.rotation[j] = local[j].cast<float>();
  const torch::Tensor trans = clip.trans[index].to(torch::kFloat32).contiguous();
  out.trans = Eigen::Map<const Eigen::Vector3f>(trans.data_ptr<float>());
  return out;
}

Clip clip_of(const std::vector<Frame>& frames, const Clip& person) {
  std::vector<interact::SettledPose> poses;
  poses.reserve(frames.size());
  for (const Frame& frame : frames) poses.push_back(pose_of(frame));
  Clip clip = interact::clip_of(poses, person, 30);
  const auto count = static_cast<int64_t>(frames.size());
  clip.action_names = interact::kActionNames;
  clip.action = torch::zeros({count}, torch::kInt64);
  clip.hand_targets = torch::zeros({count, 2, 4});
  float* target = clip.hand_targets.data_ptr<float>();
  for (size_t t = 0; t < frames.size(); ++t) {
    clip.action.data_ptr<int64_t>()[t] = frames[t].action;
    for (size_t hand = 0; hand < 2; ++hand, target += 4) {
      if (!frames[t].reaching[hand]) continue;
      std::copy_n(frames[t].contact[hand].data(), 3, target);
      target[3] = 1;
    }
  }
  return clip;
}

Frame blended(const Frame& from, const Frame& to, double weight) {
  Frame out = to;
  const auto u = static_cast<float>(weight);
  for (size_t j = 0; j < out.rotation.size(); ++j) out.rotation[j] = from.rotation[j].slerp(u, to.rotation[j]);
  out.trans = from.trans + u * (to.trans - from.trans);
  return out;
}

std::string pose_bytes(const Frame& frame, const Status& status) {
  std::string out;
  out.reserve(208);
  append<uint8_t>(out, 1);
  append<uint8_t>(out,
                  static_cast<uint8_t>((status.seated ? 1 : 0) | (status.recording ? 2 : 0) | (status.filling ? 4 : 0) |
                                       (frame.reaching[0] ? 8 : 0) | (frame.reaching[1] ? 16 : 0)));
  append(out, frame.action);
  append<uint8_t>(out, 0);
  append(out, status.index);
  append(out, status.number);
  for (const float distance : status.distance) append(out, distance);
  append_pose(out, frame);
  return out;
}

std::string ghost_bytes(int kind, const std::vector<Ghost>& ghosts) {
  std::string out;
  append<uint8_t>(out, 2);
  append(out, static_cast<uint8_t>(kind));
  append(out, static_cast<uint16_t>(ghosts.size()));
  for (const Ghost& ghost : ghosts) {
    append(out, ghost.seconds);
    append(out, ghost.track);
    out.append(3, '\0');
    append_pose(out, ghost.frame);
  }
  return out;
}

}  // namespace inhabit::serve
