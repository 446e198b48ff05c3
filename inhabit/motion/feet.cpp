#include "inhabit/motion/feet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "inhabit/body/bones.h"
#include "inhabit/body/two_bone.h"
#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/math/smooth_step.h"

namespace inhabit {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kHigh = 0.07;                  // metres above the floor: the ball of a foot in the air
constexpr double kSlow = 0.9, kQuick = 1.2;     // m/s: a foot stands; it stands no longer
constexpr double kTogether = 0.5;               // m/s: feet that differ by less move as one
constexpr double kShortest = 0.13;              // seconds that a foot stands for at least
constexpr double kBlend = 0.3;                  // seconds in which a move of a foot comes and goes
constexpr double kClear = 0.055;                // metres above the floor: the ball of a foot that goes
constexpr double kResting = 0.5, kGoing = 0.7;  // m/s: a foot may be on the floor; it is to be kClear above it
constexpr double kRise = 0.2;                   // seconds in which a foot is lifted
constexpr double kSettled = 0.13;               // seconds from a fixed frame to those that may be lifted wholly
constexpr double kReach = 0.15;  // metres from its place to which a foot may have glided and still be held there
constexpr double kStride = 0.4, kStrideTime = 0.4;  // metres, seconds: feet that glide at v m/s each step once on
                                                    // kStride + v kStrideTime metres
constexpr double kSwing = 0.4;                      // share of a stride in which a foot is on its way
constexpr double kLongest = 0.4;                    // seconds that it is on its way for at most
constexpr std::array<int, 2> kBalls = {10, 11};

/// Frames that `seconds` last, one at least.
int64_t frames_in(double seconds, double rate) { return std::max<int64_t>(1, std::llround(seconds * rate)); }

/// Frames [first, last] whose foot is moved by `moves`, one each.
struct Stance {
  int64_t first = 0, last = 0;
  std::vector<Vector3d> moves;
};

/// What brings the foot of frames [first, last] to one place, or from one fixed frame's place to the next one's.
Stance stance(const std::vector<Vector3d>& ball, int64_t first, int64_t last, const std::vector<int64_t>& fixed) {
  Vector3d middle = Vector3d::Zero();
  for (int64_t t = first; t <= last; ++t) middle += ball[t] / static_cast<double>(last - first + 1);
  const std::vector<int64_t> within(std::lower_bound(fixed.begin(), fixed.end(), first),
                                    std::upper_bound(fixed.begin(), fixed.end(), last));
  Stance out{first, last, {}};
  for (int64_t t = first; t <= last; ++t) {
    Vector3d place = middle;
    if (!within.empty()) {
      const auto next = std::lower_bound(within.begin(), within.end(), t);
      if (next == within.begin()) {
        place = ball[within.front()];
      } else if (next == within.end()) {
        place = ball[within.back()];
      } else {
        const double share = static_cast<double>(t - *(next - 1)) / static_cast<double>(*next - *(next - 1));
        place = (1 - share) * ball[*(next - 1)] + share * ball[*next];
      }
    }
    Vector3d move = place - ball[t];
    move.y() = 0;
    out.moves.push_back(move);
  }
  return out;
}

/// Speed, m/s, at which a foot leaves each frame's place.
std::vector<double> speeds(const std::vector<Vector3d>& ball, double rate) {
  std::vector<double> out(ball.size(), 0);
  for (size_t t = 0; t + 1 < ball.size(); ++t) out[t] = (ball[t + 1] - ball[t]).norm() * rate;
  return out;
}

/// Velocity of a foot along the floor in each frame, m/s.
std::vector<Vector3d> velocities(const std::vector<Vector3d>& ball, double rate) {
  std::vector<Vector3d> out(ball.size(), Vector3d::Zero());
  const size_t last = ball.size() - 1;
  for (size_t t = 0; t <= last && last > 0; ++t) {
    const size_t before = t == 0 ? 0 : t - 1, after = std::min(last, t + 1);
    out[t] = (ball[after] - ball[before]) * (rate / static_cast<double>(after - before));
    out[t].y() = 0;
  }
  return out;
}

/// Frames in which both feet glide over the floor as one, as no walk has them.
std::vector<bool> glides(const std::array<std::vector<Vector3d>, 2>& balls, double floor, double rate) {
  const std::vector<Vector3d> left = velocities(balls[0], rate), right = velocities(balls[1], rate);
  std::vector<bool> out(left.size());
  for (size_t t = 0; t < left.size(); ++t)
    out[t] = std::max(balls[0][t].y(), balls[1][t].y()) < floor + kHigh && (left[t] - right[t]).norm() < kTogether;
  return out;
}

/// Frames in which a foot that glides is to be on its way to its next place: the feet in turn, by how far they have
/// glided, and none in a fixed frame.
std::vector<bool> step_times(const std::array<std::vector<Vector3d>, 2>& balls, size_t side, double rate,
                             const std::vector<int64_t>& fixed) {
  const auto frames = static_cast<int64_t>(balls[0].size());
  const int64_t longest = frames_in(kLongest, rate);
  std::vector<bool> out(balls[0].size(), false);
  double strides = side == 0 ? 0 : 0.5;
  int64_t first = -1;
  for (int64_t t = 0; t <= frames; ++t) {
    const bool going = t < frames && strides - std::floor(strides) < kSwing;
    if (going && first < 0) first = t;
    if (!going && first >= 0) {
      int64_t from = first, to = t;  // [from, to)
      if (to - from > longest) {
        from += (to - from - longest) / 2;
        to = from + longest;
      }
      const auto f = std::lower_bound(fixed.begin(), fixed.end(), from - 1);
      if (f != fixed.end() && *f <= to) {  // before it or behind it, where that is nearer
        const int64_t by = *f - from < to - *f ? *f + 2 - from : *f - 1 - to;
        from += by;
        to += by;
      }
      for (int64_t u = std::max<int64_t>(0, from); u < std::min(to, frames); ++u) out[u] = true;
      first = -1;
    }
    if (t + 1 < frames)
      for (const auto& ball : balls) {
        Vector3d moved = ball[t + 1] - ball[t];
        moved.y() = 0;
        strides += moved.norm() / 2 / (kStride + kStrideTime * moved.norm() * rate);
      }
  }
  return out;
}

/// What brings the foot of frames [first, last] to one place, or, where it glides far, to several with steps between.
void add_stances(const std::vector<Vector3d>& ball, int64_t first, int64_t last, const std::vector<int64_t>& fixed,
                 const std::vector<bool>& steps, std::vector<Stance>& out) {
  Stance whole = stance(ball, first, last, fixed);
  const auto within = [&](const Vector3d& far) { return far.norm() < kReach; };
  bool still = true;  // two fixed frames can ask for two places
  for (int64_t t = first; t <= last; ++t)
    still = still && within(ball[t] + whole.moves[t - first] - ball[first] - whole.moves.front());
  if (still && std::all_of(whole.moves.begin(), whole.moves.end(), within)) {
    out.push_back(std::move(whole));
    return;
  }
  for (int64_t t = first; t <= last; ++t) {
    if (steps[t]) continue;
    const int64_t from = t;
    while (t < last && !steps[t + 1]) ++t;
    out.push_back(stance(ball, from, t, fixed));
  }
}

/// How far each frame's foot is to be moved along the floor. @param gliding what glides() says @param steps when a foot
/// that glides is to step
std::vector<Vector3d> foot_moves(const std::vector<Vector3d>& ball, double floor, double rate,
                                 const std::vector<int64_t>& fixed, const std::vector<bool>& gliding,
                                 const std::vector<bool>& steps) {
  const auto frames = static_cast<int64_t>(ball.size());
  const int64_t shortest = frames_in(kShortest, rate), blend = frames_in(kBlend, rate);
  const std::vector<Vector3d> velocity = velocities(ball, rate);
  const auto stands = [&](int64_t t, double speed) {
    return ball[t].y() < floor + kHigh && (velocity[t].norm() < speed || gliding[t]);
  };
  std::vector<Stance> stances;
  int64_t done = -1;
  for (int64_t t = 0; t < frames; ++t) {
    if (!stands(t, kSlow)) continue;
    int64_t first = t, last = t;
    while (first - 1 > done && stands(first - 1, kQuick)) --first;
    while (last + 1 < frames && stands(last + 1, kQuick)) ++last;
    if (last - first + 1 >= shortest) add_stances(ball, first, last, fixed, steps, stances);
    t = done = last;
  }
  std::vector<Vector3d> moves(ball.size(), Vector3d::Zero());
  for (size_t i = 0; i < stances.size(); ++i) {
    const Stance& s = stances[i];
    std::copy(s.moves.begin(), s.moves.end(), moves.begin() + s.first);
    // Each side's move fades over kBlend, or until the next stance begins.
    const int64_t before = i == 0 ? -1 : stances[i - 1].last,
                  after = i + 1 < stances.size() ? stances[i + 1].first : frames;
    const auto reach = [&](int64_t gap, bool neighbour) {
      return static_cast<double>(neighbour ? std::min(blend, gap) : blend);
    };
    for (int64_t t = s.last + 1; t < after; ++t)
      moves[t] += s.moves.back() *
                  smooth_step(1 - static_cast<double>(t - s.last) / reach(after - s.last, i + 1 < stances.size()));
    for (int64_t t = s.first - 1; t > before; --t)
      moves[t] += s.moves.front() * smooth_step(1 - static_cast<double>(s.first - t) / reach(s.first - before, i > 0));
  }
  for (const int64_t f : fixed) {  // moves nothing, and what is near it little, where the foot does not stand in it
    if (std::any_of(stances.begin(), stances.end(), [&](const Stance& s) { return s.first <= f && f <= s.last; }))
      continue;
    for (int64_t t = std::max<int64_t>(0, f - blend + 1); t < std::min(frames, f + blend); ++t)
      moves[t] *= smooth_step(std::abs(static_cast<double>(t - f)) / static_cast<double>(blend));
  }
  return moves;
}

/// How far each frame's foot is to be lifted: one that goes does not drag along the floor, where the other one is not
/// quicker, and none is under it.
std::vector<double> foot_lifts(const std::vector<Vector3d>& ball, const std::vector<double>& speed,
                               const std::vector<double>& others, double floor, double rate,
                               const std::vector<int64_t>& fixed) {
  const int64_t rise = frames_in(kRise, rate), settled = frames_in(kSettled, rate);
  const auto frames = static_cast<int64_t>(ball.size());
  std::vector<double> lifts(ball.size(), 0);
  for (int64_t t = 0; t < frames; ++t) {
    const double going = speed[t] >= others[t] ? smooth_step((speed[t] - kResting) / (kGoing - kResting)) : 0;
    const double lift = std::max(floor - ball[t].y(), going * (floor + kClear - ball[t].y()));
    if (lift <= 0) continue;
    for (int64_t u = std::max<int64_t>(0, t - rise + 1); u < std::min(frames, t + rise); ++u)
      lifts[u] =
          std::max(lifts[u], lift * smooth_step(1 - std::abs(static_cast<double>(u - t)) / static_cast<double>(rise)));
  }
  for (const int64_t f : fixed)
    for (int64_t t = std::max<int64_t>(0, f - settled + 1); t < std::min(frames, f + settled); ++t)
      lifts[t] *= smooth_step(std::abs(static_cast<double>(t - f)) / static_cast<double>(settled));
  return lifts;
}

/// Moves of more than `within` metres in the frames `near` made that long, those of the frames around along with them.
void stay_near(std::vector<Vector3d>& moves, const std::vector<int64_t>& near, double within, double rate) {
  const auto frames = static_cast<int64_t>(moves.size());
  const int64_t blend = frames_in(kBlend, rate);
  std::vector<double> share(moves.size(), 1);
  for (const int64_t n : near) {
    const double length = moves[n].norm();
    if (length <= within) continue;
    for (int64_t t = std::max<int64_t>(0, n - blend + 1); t < std::min(frames, n + blend); ++t) {
      const double close = smooth_step(1 - std::abs(static_cast<double>(t - n)) / static_cast<double>(blend));
      share[t] = std::min(share[t], 1 - close * (1 - within / length));
    }
  }
  for (int64_t t = 0; t < frames; ++t) moves[t] *= share[t];
}

}  // namespace

Clip clean_feet(const Clip& clip, const std::vector<int64_t>& fixed, double floor, const std::vector<int64_t>& near,
                double within) {
  if (clip.skeleton.size() != kStandardJoints || !clip.rotations.defined() || !clip.trans.defined())
    throw Error("feet: need rotations on the standard skeleton");
  const int64_t frames = clip.frames();
  Clip out = clip;
  const torch::Tensor joints = clip.joints.to(torch::kFloat64).contiguous();
  const auto at = joints.accessor<double, 3>();
  std::array<std::vector<Vector3d>, 2> balls;
  for (size_t side = 0; side < 2; ++side)
    for (int64_t t = 0; t < frames; ++t) {
      const auto p = at[t][kBalls[side]];
      balls[side].emplace_back(p[0], p[1], p[2]);
    }
  std::array<std::vector<Vector3d>, 2> moves;
  std::array<std::vector<double>, 2> speed;
  const std::vector<bool> gliding = glides(balls, floor, clip.rate);
  const std::array<std::vector<bool>, 2> steps = {step_times(balls, 0, clip.rate, fixed),
                                                  step_times(balls, 1, clip.rate, fixed)};
  for (size_t side = 0; side < 2; ++side) {
    moves[side] = foot_moves(balls[side], floor, clip.rate, fixed, gliding, steps[side]);
    for (int64_t t = 0; t < frames; ++t) balls[side][t] += moves[side][t];
    speed[side] = speeds(balls[side], clip.rate);
  }
  for (size_t side = 0; side < 2; ++side) {
    const std::vector<double> lifts = foot_lifts(balls[side], speed[side], speed[1 - side], floor, clip.rate, fixed);
    for (int64_t t = 0; t < frames; ++t) moves[side][t].y() = lifts[t];
    stay_near(moves[side], near, within, clip.rate);
  }

  out.rotations = clip.rotations.clone();
  out.joints = clip.joints.clone();
  const Bones bones = bones_of(clip.skeleton);
  BonesPose pose;
  for (int64_t t = 0; t < frames; ++t) {
    if (std::max(moves[0][t].norm(), moves[1][t].norm()) < 1e-6) continue;
    std::vector<Quaterniond> local = local_quaternions(clip.rotations[t]);
    const torch::Tensor place = clip.trans[t].to(torch::kFloat64);
    const Vector3d trans(place[0].item<double>(), place[1].item<double>(), place[2].item<double>());
    pose_bones(bones, local, trans, pose);
    const std::vector<Vector3d> before = pose.positions;
    for (const Side side : {Side::left, Side::right})
      move_limb_end(bones, leg(side), moves[side == Side::left ? 0 : 1][t], pose, local);
    pose_bones(bones, local, trans, pose);
    for (const int joint : {1, 4, 7, 2, 5, 8}) {
      const Vector3d v = axis_angle_of(local[joint]);
      out.rotations[t][joint] = torch::tensor({v.x(), v.y(), v.z()}, torch::kFloat32);
    }
    for (const int joint : {4, 7, 10, 5, 8, 11}) {
      const Vector3d v = pose.positions[joint] - before[joint];
      out.joints[t][joint] += torch::tensor({v.x(), v.y(), v.z()}, torch::kFloat32);
    }
  }
  return out;
}

}  // namespace inhabit
