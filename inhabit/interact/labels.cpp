#include "inhabit/interact/labels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "inhabit/interact/seated.h"
#include "inhabit/math/heading.h"
#include "inhabit/motion/canonical.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
enum : int64_t { kIdle, kWalk, kSit };

constexpr double kWalking = 0.3;       // m/s of the root
constexpr double kReachSeconds = 1.5;  // that a reach lasts at most
constexpr double kMoving = 0.15;       // m/s: slower is a hand at rest

Vector2d floor_place(const torch::Tensor& joints, int64_t frame) {
  const float* p = joints.data_ptr<float>() + frame * joints.size(1) * 3;
  return {static_cast<double>(p[0]), static_cast<double>(p[2])};
}

/// Metres a second of a joint (T), smoothed over five frames.
std::vector<double> smooth_speed(const torch::Tensor& joints, int64_t joint, double rate) {
  const torch::Tensor path = joints.select(1, joint).to(torch::kDouble);
  const int64_t frames = path.size(0);
  std::vector<double> speed(static_cast<size_t>(frames), 0.0);
  if (frames < 2) return speed;
  const torch::Tensor step = (path.slice(0, 1) - path.slice(0, 0, frames - 1)).norm(2, 1).contiguous() * rate;
  const double* s = step.data_ptr<double>();
  for (int64_t t = 0; t < frames; ++t) {
    double sum = 0;
    int count = 0;
    for (int64_t k = std::max<int64_t>(t - 2, 0); k <= std::min(t + 2, frames - 2); ++k, ++count) sum += s[k];
    speed[static_cast<size_t>(t)] = count > 0 ? sum / count : s[frames - 2];
  }
  return speed;
}

/// One of the three actions (T) for each frame.
std::vector<int64_t> plain_actions(const Clip& clip, const torch::Tensor& joints, const std::vector<Stay>& stays) {
  const std::set<std::string> walking{"walk", "turn"};
  std::vector<int64_t> out(static_cast<size_t>(clip.frames()), kIdle);
  const std::vector<double> speed = smooth_speed(joints, 0, clip.rate);
  const int64_t* action = clip.action.defined() ? clip.action.data_ptr<int64_t>() : nullptr;
  for (size_t t = 0; t < out.size(); ++t) {
    const bool named =
        action != nullptr && action[t] >= 0 && action[t] < static_cast<int64_t>(clip.action_names.size());
    const bool walks =
        named ? walking.contains(clip.action_names[static_cast<size_t>(action[t])]) : speed[t] > kWalking;
    if (walks) out[t] = kWalk;
  }
  for (const Stay& stay : stays)
    for (int64_t t = stay.down; t < std::min(stay.rise, clip.frames()); ++t) out[static_cast<size_t>(t)] = kSit;
  // Between sitting and walking away one rises.
  for (const Stay& stay : stays)
    for (int64_t t = stay.rise; t < std::min(stay.risen, clip.frames()); ++t) out[static_cast<size_t>(t)] = kIdle;
  return out;
}

/// Weights of each action: the mean over half a second around each frame.
torch::Tensor soft_actions(const std::vector<int64_t>& plain, double rate) {
  const auto frames = static_cast<int64_t>(plain.size()), reach = static_cast<int64_t>(rate / 4);
  torch::Tensor out = torch::zeros({frames, 3});
  float* o = out.data_ptr<float>();
  for (int64_t t = 0; t < frames; ++t, o += 3) {
    const int64_t first = std::max<int64_t>(t - reach, 0), last = std::min(t + reach, frames - 1);
    for (int64_t k = first; k <= last; ++k)
      o[plain[static_cast<size_t>(k)]] += 1.F / static_cast<float>(last - first + 1);
  }
  return out;
}

/// Frames at which feet are put down while not seated: the left one's (0) and the right one's (1), in order.
std::vector<std::pair<int64_t, int>> footfalls(const Clip& clip, const std::vector<int64_t>& plain) {
  std::vector<std::pair<int64_t, int>> out;
  if (!clip.contact.defined()) return out;
  const auto on = clip.contact.to(torch::kFloat).contiguous();
  const auto c = on.accessor<float, 2>();
  for (int64_t t = 1; t < clip.frames(); ++t)
    for (int side = 0; side < 2; ++side) {
      const auto down = [&](int64_t f) { return std::max(c[f][7 + side], c[f][10 + side]) > 0.5F; };
      if (down(t) && !down(t - 1) && plain[static_cast<size_t>(t)] != kSit) out.emplace_back(t, side);
    }
  return out;
}

/// A phase through knots (frame, value), linear between them, at rest before the first and after the last.
class PhaseCurve {
 public:
  explicit PhaseCurve(double rate) : rate_(rate) {}
  void at(int64_t frame, double value) {
    if (!knots_.empty() && frame <= knots_.back().first) frame = knots_.back().first + 1;
    knots_.emplace_back(frame, value);
  }
  void hold(int64_t frame) {
    if (knots_.empty() || frame > knots_.back().first) knots_.emplace_back(frame, last());
  }
  double last() const { return knots_.empty() ? 0 : knots_.back().second; }
  int64_t last_frame() const { return knots_.empty() ? 0 : knots_.back().first; }
  /// A foot is put down: the next value of this side. After a pause the cycle goes on half a second before.
  void footfall(int64_t frame, int side) {
    const double part = side == 0 ? 0 : 0.5;
    double value = std::floor(last() - part) + 1 + part;
    if (knots_.empty()) value = part;
    if (!knots_.empty() && static_cast<double>(frame - last_frame()) > 1.2 * rate_)
      hold(frame - static_cast<int64_t>(0.6 * rate_));
    at(frame, value);
  }
  /// One whole cycle from frame `from` to frame `to`.
  void cycle(int64_t from, int64_t to) {
    const double begin = std::ceil(last() - 1e-9);
    at(from, begin);
    at(std::max(to, last_frame() + 1), begin + 1);
  }
  torch::Tensor values(int64_t frames) const {
    torch::Tensor out = torch::zeros({frames});
    float* o = out.data_ptr<float>();
    size_t k = 0;
    for (int64_t t = 0; t < frames; ++t) {
      while (k < knots_.size() && knots_[k].first <= t) ++k;
      if (knots_.empty()) continue;
      if (k == 0 || k == knots_.size()) {
        o[t] = static_cast<float>(knots_[k == 0 ? 0 : k - 1].second);
        continue;
      }
      const auto& [a, from] = knots_[k - 1];
      const auto& [b, to] = knots_[k];
      o[t] = static_cast<float>(from + (to - from) * static_cast<double>(t - a) / static_cast<double>(b - a));
    }
    return out;
  }

 private:
  double rate_;
  std::vector<std::pair<int64_t, double>> knots_;
};

torch::Tensor phase_of(const Clip& clip, const std::vector<Stay>& stays, const std::vector<int64_t>& plain) {
  PhaseCurve curve(clip.rate);
  const auto falls = footfalls(clip, plain);
  size_t next = 0;
  const auto walk_until = [&](int64_t frame) {
    for (; next < falls.size() && falls[next].first < frame; ++next)
      if (falls[next].first > curve.last_frame()) curve.footfall(falls[next].first, falls[next].second);
  };
  for (const Stay& stay : stays) {
    walk_until(stay.down);
    curve.cycle(stay.down, stay.first);
    curve.hold(std::min(stay.rise, clip.frames() - 1));
    if (stay.rises) curve.cycle(std::max(stay.rise, curve.last_frame()), stay.risen);
  }
  walk_until(clip.frames());
  return curve.values(clip.frames());
}

/// The frame at which a hand leaves for what it touches at `touch`, not before `earliest`.
int64_t reach_start(const std::vector<double>& speed, int64_t touch, int64_t earliest) {
  const auto s = [&](int64_t t) { return speed[static_cast<size_t>(t)]; };
  int64_t t = touch;
  // Back over where it was fastest to where it was slow before that.
  for (double peak = s(t); t > earliest && (peak < kMoving || s(t) > 0.4 * peak); peak = std::max(peak, s(t))) --t;
  while (t > earliest && s(t - 1) <= s(t) && s(t) > kMoving) --t;
  return t;
}

void label_hands(const Clip& clip, const torch::Tensor& joints, Labels& out) {
  const int64_t frames = clip.frames();
  out.hand_phase = torch::zeros({frames, 2});
  out.hand_target = torch::zeros({frames, 2, 4});
  if (!clip.hand_targets.defined()) return;
  const torch::Tensor given = clip.hand_targets.to(torch::kFloat).contiguous();
  const auto g = given.accessor<float, 3>();
  auto target = out.hand_target.accessor<float, 3>();
  auto phase = out.hand_phase.accessor<float, 2>();
  const auto point = [&](int64_t t, int side) { return Eigen::Vector3f(g[t][side][0], g[t][side][1], g[t][side][2]); };
  for (int side = 0; side < 2; ++side) {
    const std::vector<double> speed = smooth_speed(joints, 20 + side, clip.rate);
    int64_t free_from = 0;
    for (int64_t t = 0; t < frames;) {
      if (g[t][side][3] < 0.5F) {
        ++t;
        continue;
      }
      int64_t end = t + 1;
      while (end < frames && g[end][side][3] > 0.5F && (point(end, side) - point(t, side)).norm() < 0.03F) ++end;
      const int64_t earliest = std::max(free_from, t - static_cast<int64_t>(kReachSeconds * clip.rate));
      const int64_t start = std::min(reach_start(speed, t, earliest), t);
      for (int64_t k = start; k < end; ++k) {
        for (int i = 0; i < 3; ++i) target[k][side][i] = g[std::max(k, t)][side][i];
        target[k][side][3] = 1;
        phase[k][side] = k >= t ? 1.F : static_cast<float>(k - start) / static_cast<float>(t - start);
      }
      free_from = t = end;
    }
  }
}

/// Goals of all frames, one after the other.
class GoalWriter {
 public:
  GoalWriter(const torch::Tensor& joints, const torch::Tensor& yaw, Labels& labels) : joints_(joints), yaw_(yaw) {
    const int64_t frames = joints.size(0);
    labels.goal = torch::zeros({frames, 3});
    labels.goal_direction = torch::zeros({frames, 3});
    labels.goal_action = torch::zeros({frames, 3});
    goal_ = labels.goal.data_ptr<float>();
    direction_ = labels.goal_direction.data_ptr<float>();
    action_ = labels.goal_action.data_ptr<float>();
  }
  void seat(int64_t from, int64_t to, const Vector3d& place, double heading) {
    for (int64_t t = from; t < to; ++t) put(t, place, heading, kSit);
  }
  /// Somebody walks to where they are at frame `end`.
  void place(int64_t from, int64_t to, int64_t end) {
    const Vector2d place = floor_place(joints_, end);
    bool there = false;
    for (int64_t t = from; t < to; ++t) {
      there = there || (floor_place(joints_, t) - place).norm() < kArrived;
      put(t, {place.x(), 0, place.y()}, yaw_.data_ptr<double>()[end], there ? kIdle : kWalk);
    }
  }

 private:
  void put(int64_t t, const Vector3d& place, double heading, int64_t action) {
    for (int i = 0; i < 3; ++i) goal_[3 * t + i] = static_cast<float>(place[i]);
    direction_[3 * t] = static_cast<float>(ahead_of(heading).x());
    direction_[3 * t + 2] = static_cast<float>(ahead_of(heading).y());
    action_[3 * t + action] = 1;
  }
  const torch::Tensor& joints_;
  const torch::Tensor& yaw_;
  float *goal_, *direction_, *action_;
};

}  // namespace

Labels label(const Clip& clip, const std::optional<Chair>& chair) {
  const torch::Tensor joints = clip.joints.to(torch::kFloat).contiguous();
  const torch::Tensor yaw = headings(joints.to(torch::kDouble)).contiguous();
  const std::vector<Stay> stays = chair ? stays_of(clip) : std::vector<Stay>();
  const std::vector<int64_t> plain = plain_actions(clip, joints, stays);
  Labels out;
  out.action = soft_actions(plain, clip.rate);
  out.global_phase = phase_of(clip, stays, plain);
  label_hands(clip, joints, out);
  out.seated = torch::zeros({clip.frames()});
  for (const Stay& stay : stays) out.seated.slice(0, stay.first, std::max(stay.first, stay.rise)).fill_(1);
  GoalWriter goals(joints, yaw, out);
  int64_t from = 0;
  for (const Stay& stay : stays) {
    // Between two stays somebody walks off first, as far as they go.
    if (from > 0) {
      int64_t farthest = from;
      for (int64_t t = from; t < stay.down; ++t)
        if ((floor_place(joints, t) - on_ground(stay.rest)).norm() >
            (floor_place(joints, farthest) - on_ground(stay.rest)).norm())
          farthest = t;
      goals.place(from, farthest, farthest);
      from = farthest;
    } else {
      // Who stands about has no goal yet: when they begin to walk would be anybody's guess.
      while (from < stay.down && plain[static_cast<size_t>(from)] == kIdle) ++from;
      goals.place(0, from, 0);
    }
    const int64_t until = stay.rises ? stay.rise : clip.frames();
    goals.seat(from, until, {stay.rest.x(), chair->frame.translation().y() + chair->seat_height, stay.rest.z()},
               stay.heading);
    from = until;
  }
  if (from < clip.frames()) goals.place(from, clip.frames(), clip.frames() - 1);
  return out;
}

}  // namespace inhabit::interact
