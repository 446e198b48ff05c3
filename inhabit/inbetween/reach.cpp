#include "inhabit/inbetween/reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "inhabit/body/bones.h"
#include "inhabit/body/two_bone.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/math/smooth_step.h"

namespace inhabit::inbetween {
namespace {

using Eigen::Vector3d;

constexpr double kFade = 0.5;    // seconds in which a limb's move comes and goes
constexpr double kReach = 0.98;  // share of a limb's length that it can be asked for
constexpr double kSteep = 0.8;   // share of it that goes up or down
constexpr int kRounds = 30;
constexpr int kLeaning = 3;        // the joint, spine1, about which a trunk on a given pelvis leans
constexpr double kFarthest = 0.8;  // radians that it leans by at most

Vector3d place(const Clip& clip, int64_t frame, int joint) {
  const torch::Tensor p = clip.joints[frame][joint].to(torch::kFloat64);
  return {p[0].item<double>(), p[1].item<double>(), p[2].item<double>()};
}

/// A limb and which of its joints the keys give: its end or what hangs on that, or -1.
struct GivenLimb {
  Limb limb;
  int joint;
};

/// What a key asks for.
struct Reach {
  Vector3d shift = Vector3d::Zero();  ///< of the whole body
  Vector3d lean = Vector3d::Zero();   ///< of the trunk after that, axis-angle in the world
  std::array<Vector3d, 4> moves;      ///< of each limb's end after both
};

/// What the body has to move for a limb of `length` to get to `wanted` from its start: over the floor, and up or down
/// only where the limb would have to point nearly that way.
Vector3d beyond_reach(const Vector3d& wanted, double length) {
  const double height = std::clamp(wanted.y(), -kSteep * length, kSteep * length),
               far = std::hypot(wanted.x(), wanted.z());
  const double level = std::max(0.0, 1 - std::sqrt(length * length - height * height) / std::max(1e-9, far));
  return {wanted.x() * level, wanted.y() - height, wanted.z() * level};
}

/// How the trunk has to lean for the given wrists to come into reach. @param wanted where they are to be
Vector3d lean_at(const std::array<Vector3d, 2>& shoulders, const std::array<std::optional<Vector3d>, 2>& wanted,
                 const Vector3d& spine, const std::array<double, 2>& lengths) {
  Vector3d lean = Vector3d::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Vector3d more = Vector3d::Zero();
    for (size_t side = 0; side < 2; ++side) {
      if (!wanted[side]) continue;
      const Vector3d arm = quaternion_of(lean) * (shoulders[side] - spine), open = *wanted[side] - spine - arm;
      more += arm.cross(open * std::max(0.0, 1 - lengths[side] / std::max(1e-9, open.norm()))) / arm.squaredNorm();
    }
    lean = axis_angle_of((quaternion_of(more) * quaternion_of(lean)).normalized());
    if (lean.norm() > kFarthest) lean *= kFarthest / lean.norm();
  }
  return lean;
}

/// @param leans whether nothing but the pelvis is given of the trunk, so that it may lean
Reach reach_at(const Clip& filled, const Clip& given, int64_t key, const std::vector<int>& trunk, bool leans,
               const std::array<GivenLimb, 4>& limbs, const Bones& bones) {
  Reach out;
  out.moves.fill(Vector3d::Zero());
  const auto missed = [&](int joint) -> Vector3d { return place(given, key, joint) - place(filled, key, joint); };
  for (const int joint : trunk) out.shift += missed(joint) / static_cast<double>(trunk.size());
  // Averaged projections onto the places from which every limb reaches.
  const auto given_limbs = std::count_if(limbs.begin(), limbs.end(), [](const GivenLimb& l) { return l.joint >= 0; });
  for (int round = 0; round < kRounds && trunk.empty(); ++round) {
    Vector3d excess = Vector3d::Zero();
    for (const auto& [limb, joint] : limbs) {
      if (joint < 0) continue;
      const Vector3d start = place(filled, key, limb.start) + out.shift;
      const Vector3d wanted = place(filled, key, limb.end) + missed(joint) - start;
      const double length = kReach * (bones.offsets[limb.mid].norm() + bones.offsets[limb.end].norm());
      excess += beyond_reach(wanted, length);
    }
    if (given_limbs > 0) out.shift += excess / static_cast<double>(given_limbs);
  }
  const Vector3d spine = place(filled, key, kLeaning) + out.shift;
  if (leans) {
    std::array<Vector3d, 2> shoulders;
    std::array<std::optional<Vector3d>, 2> wanted;
    std::array<double, 2> lengths{};
    for (size_t side = 0; side < 2; ++side) {
      const auto& [limb, joint] = limbs[2 + side];
      shoulders[side] = place(filled, key, limb.start) + out.shift;
      lengths[side] = kReach * (bones.offsets[limb.mid].norm() + bones.offsets[limb.end].norm());
      if (joint >= 0) wanted[side] = place(given, key, joint);
    }
    out.lean = lean_at(shoulders, wanted, spine, lengths);
  }
  for (size_t i = 0; i < limbs.size(); ++i) {
    if (limbs[i].joint < 0) continue;
    Vector3d at = place(filled, key, limbs[i].joint) + out.shift;
    if (i >= 2) at = spine + quaternion_of(out.lean) * (at - spine);  // arms hang on the trunk
    out.moves[i] = place(given, key, limbs[i].joint) - at;
  }
  return out;
}

}  // namespace

Clip reach_targets(const Clip& filled, const Clip& given, const std::vector<int64_t>& keys,
                   const torch::Tensor& groups) {
  const auto is_given = [&](int joint) { return groups[kJointGroups + joint].item<float>() > 0; };
  std::vector<int> trunk;
  for (const int joint : {0, 1, 2, 3, 6, 9, 12, 13, 14, 15, 16, 17})
    if (is_given(joint)) trunk.push_back(joint);
  const bool leans = trunk == std::vector<int>{0};
  if (is_given(0)) trunk = {0};
  const auto ankle_or_ball = [&](int ankle, int ball) { return is_given(ankle) ? ankle : is_given(ball) ? ball : -1; };
  const auto wrist = [&](int joint) { return is_given(joint) ? joint : -1; };
  const std::array<GivenLimb, 4> limbs = {GivenLimb{leg(Side::left), ankle_or_ball(7, 10)},
                                          {leg(Side::right), ankle_or_ball(8, 11)},
                                          {arm(Side::left), wrist(20)},
                                          {arm(Side::right), wrist(21)}};
  const Bones bones = bones_of(filled.skeleton);
  std::vector<Reach> asked(keys.size());
  for (Reach& whole : asked) whole.moves.fill(Vector3d::Zero());
  for (size_t k = 1; k + 1 < keys.size(); ++k) asked[k] = reach_at(filled, given, keys[k], trunk, leans, limbs, bones);

  Clip out = filled;
  out.rotations = filled.rotations.clone();
  out.trans = filled.trans.clone();
  out.joints = filled.joints.clone();
  BonesPose pose;
  for (size_t k = 0; k + 1 < keys.size(); ++k)
    for (int64_t t = keys[k]; t < keys[k + 1]; ++t) {
      const auto since = static_cast<double>(t - keys[k]), until = static_cast<double>(keys[k + 1] - t);
      const double next = smooth_step(since / (since + until)), fade = std::min(since + until, kFade * filled.rate);
      const Vector3d shift = (1 - next) * asked[k].shift + next * asked[k + 1].shift;
      const auto faded = [&](const Vector3d& a, const Vector3d& b) -> Vector3d {
        return smooth_step(1 - since / fade) * a + smooth_step(1 - until / fade) * b;
      };
      const auto move = [&](size_t i) { return faded(asked[k].moves[i], asked[k + 1].moves[i]); };
      const Vector3d lean = faded(asked[k].lean, asked[k + 1].lean);
      std::vector<Eigen::Quaterniond> local = local_quaternions(filled.rotations[t]);
      const torch::Tensor before = filled.trans[t].to(torch::kFloat64);
      const Vector3d trans =
          shift + Vector3d(before[0].item<double>(), before[1].item<double>(), before[2].item<double>());
      pose_bones(bones, local, trans, pose);
      bool moved = shift.norm() > 1e-6 || lean.norm() > 1e-6;
      if (lean.norm() > 1e-6) {
        const Eigen::Quaterniond& below = pose.rotations[static_cast<size_t>(bones.parents[kLeaning])];
        local[kLeaning] = (below.conjugate() * quaternion_of(lean) * below * local[kLeaning]).normalized();
        pose_bones(bones, local, trans, pose);
      }
      for (size_t i = 0; i < limbs.size(); ++i)
        if (move(i).norm() > 1e-6) {
          move_limb_end(bones, limbs[i].limb, move(i), pose, local);
          moved = true;
        }
      if (!moved) continue;
      pose_bones(bones, local, trans, pose);
      out.trans[t] = torch::tensor({trans.x(), trans.y(), trans.z()}, torch::kFloat32);
      for (int joint = 0; joint < bones.size(); ++joint) {
        const Vector3d turn = axis_angle_of(local[joint]), &at = pose.positions[joint];
        out.rotations[t][joint] = torch::tensor({turn.x(), turn.y(), turn.z()}, torch::kFloat32);
        out.joints[t][joint] = torch::tensor({at.x(), at.y(), at.z()}, torch::kFloat32);
      }
    }
  return out;
}

}  // namespace inhabit::inbetween
