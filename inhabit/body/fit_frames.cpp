#include "inhabit/body/fit_frames.h"

#include <Eigen/SVD>
#include <complex>
#include <initializer_list>

#include "inhabit/body/two_bone.h"
#include "inhabit/error.h"

namespace inhabit {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using torch::Tensor;

constexpr double kShort = 1e-6;    // metres; shorter bones have no direction
constexpr double kBefore = 1e-5;   // square metres that the frame before counts where points leave a rotation open
constexpr double kSettled = 0.05;  // what a limb's rest pose says about its twist; a bend of 4 degrees says as much
constexpr double kMemory = 3;      // frames in which what a bend said about the twist fades by e

/// The rotation by the least angle that carries `from` onto the direction of `to`.
Quaterniond swing(const Vector3d& from, const Vector3d& to) {
  return from.squaredNorm() < kShort * kShort || to.squaredNorm() < kShort * kShort
             ? Quaterniond::Identity()
             : Quaterniond::FromTwoVectors(from, to);
}

/// The rotation that best carries the bones from a joint to its children onto their targets as seen from `at` (Kabsch
/// 1976); what they leave open is as in `before`.
Quaterniond carried(const Bones& bones, const FitTargets& y, const Vector3d& at, std::initializer_list<size_t> children,
                    const Quaterniond& before) {
  Matrix3d h = kBefore * before.toRotationMatrix();
  for (const size_t c : children) h += (y[c] - at) * bones.offsets[c].transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(h, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d sign = Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return Quaterniond(Matrix3d(svd.matrixU() * sign * svd.matrixV().transpose())).normalized();
}

/// Global rotations and positions of a frame while it is built, from the root outwards.
struct Building {
  std::array<Quaterniond, kStandardJoints> global;
  std::array<Vector3d, kStandardJoints> at;
};

/// Where a bone of rest offset `rest` should point for its end to come near `wanted`, both as seen from its start. What
/// `wanted` lacks of the bone's length makes its direction less sure: it is filled up with that of `likely`.
Vector3d aim_of(const Vector3d& rest, const Vector3d& wanted, const Quaterniond& likely) {
  const double length = rest.norm(), there = wanted.norm();
  if (there >= length) return wanted;
  const double lack = 1 - there / length;
  return wanted + 2 * lack * lack * (likely * rest);
}

/// Where the middle joint of two bones of lengths `upper` and `lower` from `start` comes nearest to `mid` and its end
/// to `end`, by the sum of squares: from a guess on, it is put between where each of the two wants it.
Vector3d between(const Vector3d& start, const Vector3d& mid, const Vector3d& end, double upper, double lower) {
  constexpr int kAlternations = 4;
  Vector3d m = mid;
  for (int round = 0; round < kAlternations; ++round) {
    const Vector3d down = end - m;
    if (down.norm() < kShort) break;
    const Vector3d out = 0.5 * (mid + end - lower * down.normalized()) - start;
    if (out.norm() < kShort) break;
    m = start + upper * out.normalized();
  }
  return m;
}

/// A limb with what its twist is settled by.
struct TwistedLimb {
  size_t parent, start, mid, end;
  double upper, lower;           ///< metres
  double lean;                   ///< sine of the angle by which the lower bone leaves the hinge's plane at rest
  Vector3d along, bend, across;  ///< at rest, orthonormal: the upper bone, where the lower one bends to, their product
  bool one_way;                  ///< bends to that side alone, which is within a right angle of the rest pose's
};

std::array<TwistedLimb, 4> twisted_limbs(const Bones& bones) {
  const auto limb = [&](const Limb& l, bool is_leg) {
    TwistedLimb out;
    out.parent = is_leg ? 0 : 9;
    out.start = static_cast<size_t>(l.start);
    out.mid = static_cast<size_t>(l.mid);
    out.end = static_cast<size_t>(l.end);
    out.along = bones.offsets[out.mid];
    out.bend = -l.rest_pole;
    out.one_way = is_leg;
    out.upper = out.along.norm();
    out.lower = bones.offsets[out.end].norm();
    out.along = out.along.norm() < kShort ? Vector3d(-Vector3d::UnitY()) : out.along.normalized();
    out.bend -= out.bend.dot(out.along) * out.along;
    out.bend = out.bend.norm() < kShort ? out.along.unitOrthogonal() : out.bend.normalized();
    out.across = out.along.cross(out.bend);
    out.lean = out.lower < kShort ? 0 : bones.offsets[out.end].dot(out.across) / out.lower;
    return out;
  };
  return {limb(leg(Side::left), true), limb(leg(Side::right), true), limb(arm(Side::left), false),
          limb(arm(Side::right), false)};
}

/// Rotations of a limb's upper bone in all frames, relative to the joint its parent frame belongs to. It points at
/// where the middle joint goes, `middles`. Its twist is measured from a frame that the bone carries along through time
/// without twisting: there the bends of neighbouring frames can be averaged, each by sin^2 of its angle, for a straight
/// limb says nothing, and nothing jumps where the rotation from the rest pose becomes ambiguous.
std::vector<Quaterniond> upper_rotations(const TwistedLimb& limb, const std::vector<FitTargets>& targets,
                                         const std::vector<Building>& building, const std::vector<Vector3d>& middles) {
  const size_t frames = targets.size();
  std::vector<Quaterniond> carry(frames);
  std::vector<std::complex<double>> said(frames), rest(frames);
  Vector3d before = limb.along;
  for (size_t t = 0; t < frames; ++t) {
    const Quaterniond back = building[t].global[limb.parent].conjugate();
    Vector3d bone = back * (middles[t] - building[t].at[limb.start]);
    bone = bone.norm() < kShort ? before : bone.normalized();
    carry[t] =
        (Quaterniond::FromTwoVectors(before, bone) * (t > 0 ? carry[t - 1] : Quaterniond::Identity())).normalized();
    before = bone;
    // Twists as unit complex numbers: e^(i angle) about the bone from the carried frame.
    const auto twist = [&](const Vector3d& side) {
      return std::complex<double>(side.dot(carry[t] * limb.bend), side.dot(carry[t] * limb.across));
    };
    const double near = 0.5 * (1 + bone.dot(limb.along));  // 0 where the rotation from the rest pose is ambiguous
    rest[t] = kSettled * near * twist(swing(limb.along, bone) * limb.bend);
    const Vector3d lower = back * (targets[t][limb.end] - middles[t]);
    if (lower.norm() < kShort) continue;
    const std::complex<double> e = twist(lower.normalized());
    // The bend about the hinge is what is left of the whole when the lower bone's own lean to the side is taken off.
    const double bend = std::norm(e) - limb.lean * limb.lean;
    if (bend <= 0 || (limb.one_way && (e * std::conj(rest[t])).real() < 0)) continue;
    const std::complex<double> expected(std::sqrt(bend), limb.lean);
    said[t] = std::min(1.0, lower.norm() / limb.lower) * bend * e * std::conj(expected) / std::norm(e);
  }
  // Sums that fade both ways.
  const double keep = std::exp(-1 / kMemory);
  std::vector<std::complex<double>> sum = said;
  for (size_t t = 1; t < frames; ++t) sum[t] += keep * sum[t - 1];
  std::complex<double> behind = 0;
  for (size_t t = frames; t-- > 0;) {
    sum[t] += behind;
    behind = keep * (behind + said[t]);
  }
  std::vector<Quaterniond> out(frames);
  for (size_t t = 0; t < frames; ++t) {
    // The frame's own bend counts as much as all around it.
    const double angle = std::arg(sum[t] + 2 * kMemory * said[t] + rest[t]);
    out[t] = carry[t] * Eigen::AngleAxisd(angle, limb.along);
  }
  return out;
}

}  // namespace

std::vector<FitTargets> fit_targets(const Tensor& joints) {
  if (!joints.defined() || joints.dim() != 3 || joints.size(0) < 1 || joints.size(1) < kStandardJoints ||
      joints.size(2) != 3)
    throw Error("fit", "joints are not (T, 22 or more, 3)");
  const Tensor rows = joints.detach().narrow(1, 0, kStandardJoints).to(torch::kCPU, torch::kDouble).contiguous();
  if (!torch::isfinite(rows).all().item<bool>()) throw Error("fit", "a joint position is not finite");
  const double* p = rows.data_ptr<double>();
  std::vector<FitTargets> targets(static_cast<size_t>(rows.size(0)));
  for (FitTargets& y : targets)
    for (Vector3d& v : y) {
      v = Vector3d(p[0], p[1], p[2]);
      p += 3;
    }
  return targets;
}

Bones fit_bones(const Skeleton& skeleton) {
  Bones bones = bones_of(skeleton);
  if (bones.size() < kStandardJoints ||
      !std::equal(standard_parents().begin(), standard_parents().end(), bones.parents.begin()))
    throw Error("fit", "the body's first 22 joints are not the standard ones");
  bones.parents.resize(kStandardJoints);
  bones.offsets.resize(kStandardJoints);
  return bones;
}

std::vector<FitFrame> fit_frames(const Bones& bones, const std::vector<FitTargets>& targets) {
  const size_t frames = targets.size();
  std::vector<Building> building(frames);
  const auto place = [&](Building& b, size_t joint) {
    const auto parent = static_cast<size_t>(bones.parents[joint]);
    b.at[joint] = b.at[parent] + b.global[parent] * bones.offsets[joint];
  };
  // A joint with one child: from where it came out itself it points at the child's target, twisted as `like` is.
  const auto aim = [&](Building& b, const FitTargets& y, size_t joint, size_t child, const Quaterniond& like) {
    const Vector3d& rest = bones.offsets[child];
    b.global[joint] = (swing(like * rest, aim_of(rest, y[child] - b.at[joint], like)) * like).normalized();
    place(b, child);
  };
  Quaterniond pelvis = Quaterniond::Identity(), chest = Quaterniond::Identity();
  for (size_t t = 0; t < frames; ++t) {
    const FitTargets& y = targets[t];
    Building& b = building[t];
    b.at[0] = y[0];
    b.global[0] = pelvis = carried(bones, y, y[0], {1, 2, 3}, t > 0 ? pelvis : Quaterniond::Identity());
    for (const size_t child : {1, 2, 3}) place(b, child);
    chest = carried(bones, y, y[9], {12, 13, 14}, t > 0 ? chest : pelvis);
    aim(b, y, 3, 6, pelvis.slerp(1.0 / 3, chest));
    aim(b, y, 6, 9, pelvis.slerp(2.0 / 3, chest));
    b.global[9] = chest = carried(bones, y, b.at[9], {12, 13, 14}, chest);
    for (const size_t child : {12, 13, 14}) place(b, child);
    aim(b, y, 12, 15, chest);
    aim(b, y, 13, 16, chest);
    aim(b, y, 14, 17, chest);
    b.global[15] = b.global[12];
  }
  std::vector<Vector3d> middles(frames);
  for (const TwistedLimb& limb : twisted_limbs(bones)) {
    for (size_t t = 0; t < frames; ++t)
      middles[t] =
          between(building[t].at[limb.start], targets[t][limb.mid], targets[t][limb.end], limb.upper, limb.lower);
    const std::vector<Quaterniond> upper = upper_rotations(limb, targets, building, middles);
    for (size_t t = 0; t < frames; ++t) {
      const FitTargets& y = targets[t];
      Building& b = building[t];
      b.global[limb.start] = (b.global[limb.parent] * upper[t]).normalized();
      place(b, limb.mid);
      aim(b, y, limb.mid, limb.end, b.global[limb.start]);
      b.global[limb.end] = b.global[limb.mid];
      if (!limb.one_way) continue;  // a foot follows
      aim(b, y, limb.end, limb.end + 3, b.global[limb.mid]);
      b.global[limb.end + 3] = b.global[limb.end];
    }
  }
  std::vector<FitFrame> out(frames);
  for (size_t t = 0; t < frames; ++t) {
    out[t].trans = targets[t][0] - bones.offsets[0];
    out[t].local[0] = building[t].global[0];
    for (size_t j = 1; j < kStandardJoints; ++j)
      out[t].local[j] =
          (building[t].global[static_cast<size_t>(bones.parents[j])].conjugate() * building[t].global[j]).normalized();
  }
  return out;
}

}  // namespace inhabit
