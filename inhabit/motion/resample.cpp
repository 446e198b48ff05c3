#include "inhabit/motion/resample.h"

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/catmull_rom.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

// Old frames around each new one: between `before` and before + 1 with this weight of the latter.
struct Times {
  std::vector<int64_t> before;
  std::vector<double> weight;
  int64_t last;  // old frame

  Times(int64_t frames, const std::vector<double>& at_frames) : last(frames - 1) {
    for (const double at_frame : at_frames) {
      const double at = std::clamp(at_frame, 0.0, static_cast<double>(last));
      const auto frame = std::min(static_cast<int64_t>(at + 1e-9), std::max<int64_t>(last - 1, 0));
      before.push_back(frame);
      weight.push_back(std::clamp(at - static_cast<double>(frame), 0.0, 1.0));
    }
  }
  torch::Tensor nearest() const {
    std::vector<int64_t> frames;
    for (size_t k = 0; k < before.size(); ++k) frames.push_back(std::min(last, before[k] + (weight[k] >= 0.5 ? 1 : 0)));
    return torch::tensor(frames, torch::kLong);
  }
  torch::Tensor index(int64_t shift) const {
    std::vector<int64_t> frames;
    for (const int64_t frame : before) frames.push_back(std::clamp<int64_t>(frame + shift, 0, last));
    return torch::tensor(frames, torch::kLong);
  }
  // Shaped to multiply tensors of `dims` dimensions.
  torch::Tensor weights(int64_t dims) const {
    std::vector<int64_t> shape(static_cast<size_t>(dims), 1);
    shape[0] = -1;
    return torch::tensor(weight, torch::kDouble).reshape(shape);
  }
};

// Catmull-Rom along dimension 0; beyond the ends the path goes on as a parabola, or a line where there are two frames.
torch::Tensor cubic(const torch::Tensor& values, const Times& times) {
  const torch::Tensor v = values.to(torch::kDouble);
  if (times.last == 0) return values.index_select(0, times.index(0));
  const int64_t n = times.last;
  const torch::Tensor head = n >= 2 ? 3 * v[0] - 3 * v[1] + v[2] : 2 * v[0] - v[1];
  const torch::Tensor tail = n >= 2 ? 3 * v[n] - 3 * v[n - 1] + v[n - 2] : 2 * v[n] - v[n - 1];
  const torch::Tensor longer = torch::cat({head.unsqueeze(0), v, tail.unsqueeze(0)});
  const torch::Tensor at = times.index(0), u = times.weights(v.dim());
  const auto after = [&](int64_t frames) { return longer.index_select(0, at + frames); };
  return catmull_rom<torch::Tensor>(after(0), after(1), after(2), after(3), u).to(values.dtype());
}

torch::Tensor linear(const torch::Tensor& values, const Times& times) {
  const torch::Tensor a = values.index_select(0, times.index(0)).to(torch::kDouble),
                      b = values.index_select(0, times.index(1)).to(torch::kDouble);
  return (a + times.weights(values.dim()) * (b - a)).to(values.dtype());
}

// Axis-angle (T, N, 3) by slerp.
torch::Tensor slerped(const torch::Tensor& axis_angle, const Times& times) {
  const torch::Tensor from = axis_angle.to(torch::kCPU, torch::kDouble).contiguous();
  const int64_t n = from.size(1);
  torch::Tensor out = torch::empty({static_cast<int64_t>(times.before.size()), n, 3});
  const double* data = from.data_ptr<double>();
  float* to = out.data_ptr<float>();
  const auto read = [&](int64_t frame, int64_t j) {
    const double* p = data + (frame * n + j) * 3;
    return quaternion_of({p[0], p[1], p[2]});
  };
  for (size_t k = 0; k < times.before.size(); ++k)
    for (int64_t j = 0; j < n; ++j, to += 3) {
      const int64_t next = std::min(times.before[k] + 1, times.last);
      const Eigen::Vector3d v = axis_angle_of(read(times.before[k], j).slerp(times.weight[k], read(next, j)));
      Eigen::Map<Eigen::Vector3f>(to, 3) = v.cast<float>();
    }
  return out;
}

// A target that only one neighbour holds is taken from that one.
torch::Tensor hand_targets(const torch::Tensor& targets, const Times& times) {
  torch::Tensor out = linear(targets, times);
  const torch::Tensor a = targets.index_select(0, times.index(0)), b = targets.index_select(0, times.index(1));
  const torch::Tensor held_a = a.slice(2, 3) > 0.5, held_b = b.slice(2, 3) > 0.5;
  out = torch::where(held_a & ~held_b, a, out);
  out = torch::where(held_b & ~held_a, b, out);
  const torch::Tensor nearest = targets.index_select(0, times.nearest());
  return torch::cat({out.slice(2, 0, 3), nearest.slice(2, 3)}, 2);
}

}  // namespace

Clip resample(const Clip& clip, double rate, const std::string& subject) {
  int64_t at = 0;
  return resample_through(clip, rate, 0, at, subject);
}

Clip resample_through(const Clip& clip, double rate, int64_t frame, int64_t& at, const std::string& subject) {
  if (!(rate > 0 && rate <= 1000)) throw Error(subject, "frame rate " + std::to_string(rate) + " is not in (0, 1000]");
  validate(clip, subject);
  at = frame;
  if (rate == clip.rate) return clip;
  at = static_cast<int64_t>(std::floor(static_cast<double>(frame) * rate / clip.rate + 1e-6));
  const double first = static_cast<double>(frame) - static_cast<double>(at) * clip.rate / rate;
  const double span = static_cast<double>(clip.frames() - 1) - first;
  const auto count = static_cast<int64_t>(std::floor(span * rate / clip.rate + 1e-6)) + 1;
  if (count > 50'000'000 / clip.skeleton.size())
    throw Error(subject, "has too many frames at " + std::to_string(rate) + " frames a second");
  std::vector<double> frames;
  for (int64_t k = 0; k < count; ++k) frames.push_back(first + static_cast<double>(k) * clip.rate / rate);
  Clip out = at_frames(clip, frames);
  out.rate = rate;
  return out;
}

torch::Tensor at_frames(const torch::Tensor& places, const std::vector<double>& frames) {
  return cubic(places, Times(places.size(0), frames));
}

Clip at_frames(const Clip& clip, const std::vector<double>& frames) {
  const Times times(clip.frames(), frames);
  Clip out = clip;
  if (clip.rotations.defined() && clip.trans.defined()) {
    Clip posed = clip;
    set_pose(posed, pose_track(clip));
    const torch::Tensor beside = clip.joints.to(torch::kCPU, torch::kFloat) - posed.joints;
    out.rotations = slerped(clip.rotations, times);
    out.trans = cubic(clip.trans, times);
    if (clip.translations.defined()) out.translations = cubic(clip.translations, times);
    set_pose(out, pose_track(out));
    out.joints = out.joints + linear(beside, times);
  } else {
    out.joints = cubic(clip.joints, times);
    if (clip.trans.defined()) out.trans = cubic(clip.trans, times);
    if (clip.rotations.defined()) out.rotations = slerped(clip.rotations, times);
  }
  if (clip.action.defined()) out.action = clip.action.index_select(0, times.nearest());
  if (clip.contact.defined()) out.contact = clip.contact.index_select(0, times.nearest());
  if (clip.hand_targets.defined()) out.hand_targets = hand_targets(clip.hand_targets, times);
  if (clip.object_pose.defined())
    out.object_pose =
        torch::cat({linear(clip.object_pose.slice(2, 0, 3), times), slerped(clip.object_pose.slice(2, 3), times)}, 2);
  return out;
}

}  // namespace inhabit
