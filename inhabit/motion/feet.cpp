#include "inhabit/motion/feet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "inhabit/body/bones.h"
#include "inhabit/body/two_bone.h"
#include "inhabit/error.h"
#include "inhabit/math/quaternion.h"

namespace inhabit {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kHigh = 0.05;               // metres above the lowest place of both balls: a foot in the air
constexpr double kSlow = 0.6, kQuick = 1.2;  // m/s: a foot stands; it stands no longer
constexpr int64_t kShortest = 4;             // frames that a foot stands for at least
constexpr int64_t kBlend = 9;                // frames in which a move of a foot comes and goes
constexpr std::array<int, 2> kBalls = {10, 11};

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

/// How far each frame's foot is to be moved.
std::vector<Vector3d> foot_moves(const std::vector<Vector3d>& ball, double floor, double rate,
                                 const std::vector<int64_t>& fixed) {
  const auto frames = static_cast<int64_t>(ball.size());
  const auto speed = [&](int64_t t) {
    const int64_t before = std::max<int64_t>(0, t - 1), after = std::min(frames - 1, t + 1);
    Vector3d moved = ball[after] - ball[before];
    moved.y() = 0;
    return moved.norm() * rate / static_cast<double>(std::max<int64_t>(1, after - before));
  };
  const auto may_stand = [&](int64_t t) { return ball[t].y() < floor + kHigh && speed(t) < kQuick; };
  std::vector<Stance> stances;
  for (int64_t t = 0; t < frames; ++t) {
    if (!may_stand(t) || speed(t) >= kSlow) continue;
    int64_t first = t, last = t;
    while (first > 0 && (stances.empty() || first - 1 > stances.back().last) && may_stand(first - 1)) --first;
    while (last + 1 < frames && may_stand(last + 1)) ++last;
    if (last - first + 1 >= kShortest) stances.push_back(stance(ball, first, last, fixed));
    t = last;
  }
  std::vector<Vector3d> moves(ball.size(), Vector3d::Zero());
  const auto smooth = [](double x) { return x <= 0 ? 0 : x >= 1 ? 1 : x * x * (3 - 2 * x); };
  for (size_t i = 0; i < stances.size(); ++i) {
    const Stance& s = stances[i];
    std::copy(s.moves.begin(), s.moves.end(), moves.begin() + s.first);
    // Each side's move fades over kBlend frames, or until the next stance begins.
    const int64_t before = i == 0 ? -1 : stances[i - 1].last,
                  after = i + 1 < stances.size() ? stances[i + 1].first : frames;
    const auto reach = [&](int64_t gap, bool neighbour) {
      return static_cast<double>(neighbour ? std::min(kBlend, gap) : kBlend);
    };
    for (int64_t t = s.last + 1; t < after; ++t)
      moves[t] +=
          s.moves.back() * smooth(1 - static_cast<double>(t - s.last) / reach(after - s.last, i + 1 < stances.size()));
    for (int64_t t = s.first - 1; t > before; --t)
      moves[t] += s.moves.front() * smooth(1 - static_cast<double>(s.first - t) / reach(s.first - before, i > 0));
  }
  for (const int64_t f : fixed) {  // moves nothing, and what is near it little, where the foot does not stand in it
    if (std::any_of(stances.begin(), stances.end(), [&](const Stance& s) { return s.first <= f && f <= s.last; }))
      continue;
    for (int64_t t = std::max<int64_t>(0, f - kBlend + 1); t < std::min(frames, f + kBlend); ++t)
      moves[t] *= smooth(std::abs(static_cast<double>(t - f)) / kBlend);
  }
  return moves;
}

/// Brings the ankle of a posed leg to `target`: thigh and shin turn by the least that does, the foot stays turned as it
/// is.
void move_ankle(const Bones& bones, const Limb& limb, const Vector3d& move, const BonesPose& pose,
                std::vector<Quaterniond>& local) {
  const Vector3d &hip = pose.positions[limb.start], &knee = pose.positions[limb.mid], &ankle = pose.positions[limb.end];
  const Vector3d straight = ankle - hip;
  Vector3d pole = knee - hip - straight * ((knee - hip).dot(straight) / std::max(1e-12, straight.squaredNorm()));
  if (pole.norm() < 1e-3) pole = pose.rotations[limb.start] * limb.rest_pole;
  const TwoBone solved =
      solve_two_bone(hip, bones.offsets[limb.mid].norm(), bones.offsets[limb.end].norm(), ankle + move, pole, 0);
  const Quaterniond thigh = Quaterniond::FromTwoVectors(knee - hip, solved.mid - hip) * pose.rotations[limb.start],
                    shin =
                        Quaterniond::FromTwoVectors(ankle - knee, solved.end - solved.mid) * pose.rotations[limb.mid];
  const int parent = bones.parents[limb.start];
  local[limb.start] = (pose.rotations[parent].conjugate() * thigh).normalized();
  local[limb.mid] = (thigh.conjugate() * shin).normalized();
  local[limb.end] = (shin.conjugate() * pose.rotations[limb.end]).normalized();
}

}  // namespace

Clip hold_feet(const Clip& clip, const std::vector<int64_t>& fixed) {
  if (clip.skeleton.size() != kStandardJoints || !clip.rotations.defined() || !clip.trans.defined())
    throw Error("feet: need rotations on the standard skeleton");
  const int64_t frames = clip.frames();
  Clip out = clip;
  const torch::Tensor joints = clip.joints.to(torch::kFloat64).contiguous();
  const auto at = joints.accessor<double, 3>();
  std::array<std::vector<Vector3d>, 2> balls;
  double floor = 1e9;
  for (size_t side = 0; side < 2; ++side)
    for (int64_t t = 0; t < frames; ++t) {
      const auto p = at[t][kBalls[side]];
      balls[side].emplace_back(p[0], p[1], p[2]);
      floor = std::min(floor, p[1]);
    }
  std::array<std::vector<Vector3d>, 2> moves;
  for (size_t side = 0; side < 2; ++side) moves[side] = foot_moves(balls[side], floor, clip.rate, fixed);

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
    for (const Side side : {Side::left, Side::right})
      move_ankle(bones, leg(side), moves[side == Side::left ? 0 : 1][t], pose, local);
    pose_bones(bones, local, trans, pose);
    for (const int joint : {1, 4, 7, 2, 5, 8}) {
      const Vector3d v = axis_angle_of(local[joint]);
      out.rotations[t][joint] = torch::tensor({v.x(), v.y(), v.z()}, torch::kFloat32);
    }
    for (const int joint : {4, 7, 10, 5, 8, 11}) {
      const Vector3d& p = pose.positions[joint];
      out.joints[t][joint] = torch::tensor({p.x(), p.y(), p.z()}, torch::kFloat32);
    }
  }
  return out;
}

}  // namespace inhabit
