#include "inhabit/motion/transfer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "inhabit/body/bones.h"
#include "inhabit/body/two_bone.h"
#include "inhabit/error.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/pose_track.h"
#include "inhabit/motion/resample.h"

namespace inhabit {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kMissed = 1e-6;    // metres that are not worth a correction
constexpr double kStraight = 0.05;  // metres of a knee beside the line from hip to ankle: its side is known
constexpr double kBendByMove = 5;   // metres that a straight limb bends to its own side for one its end is moved

// A joint of the file and the standard rotation that moves it: from that of `low` to that of `high` by `weight`.
struct Follower {
  int joint, low, high;
  double weight;
};

// Joints of the file for a limb of the standard skeleton, and for the ball of the foot where it has one.
struct SourceLimb {
  std::array<int, 3> joints;
  Limb standard;
  int ball = -1, standard_ball = -1;
};

struct Mapping {
  std::vector<Follower> followers;  // parents first
  std::vector<SourceLimb> limbs;
  int pelvis = 0;
};

Mapping mapping_of(const Skeleton& skeleton) {
  const Landmarks marks = find_landmarks(skeleton, "skeleton");
  Mapping out;
  out.pelvis = marks.pelvis;
  const auto follow = [&](int joint, int low, int high, double weight) {
    const auto known = [joint](const Follower& f) { return f.joint == joint; };
    if (joint >= 0 && std::none_of(out.followers.begin(), out.followers.end(), known))
      out.followers.push_back({joint, low, high, weight});
  };
  static constexpr std::array<int, 4> kSpine = {0, 3, 6, 9};
  for (size_t k = 0; k < marks.spine.size(); ++k) {
    const double along =
        3.0 * static_cast<double>(k) / static_cast<double>(std::max<size_t>(marks.spine.size() - 1, 1));
    const auto low = static_cast<size_t>(std::min(2.0, along));
    follow(marks.spine[k], kSpine[low], kSpine[low + 1], along - static_cast<double>(low));
  }
  std::vector<int> neck;
  for (int j = marks.head; j != marks.thorax; j = skeleton.parents[static_cast<size_t>(j)]) neck.push_back(j);
  for (size_t k = 0; k < neck.size(); ++k)  // from the head down
    follow(neck[k], 15, 12, neck.size() == 1 ? 0 : static_cast<double>(k) / static_cast<double>(neck.size() - 1));
  for (size_t s = 0; s < 2; ++s) {
    const int side = static_cast<int>(s);
    for (const auto& [joint, standard] : {std::pair(marks.hip[s], 1),
                                          {marks.knee[s], 4},
                                          {marks.ankle[s], 7},
                                          {marks.toe[s], 10},
                                          {marks.collar[s], 13},
                                          {marks.shoulder[s], 16},
                                          {marks.elbow[s], 18},
                                          {marks.wrist[s], 20}})
      follow(joint, standard + side, standard + side, 0);
    const Side which = s == 0 ? Side::left : Side::right;
    out.limbs.push_back({{marks.hip[s], marks.knee[s], marks.ankle[s]}, leg(which), marks.toe[s], 10 + side});
    out.limbs.push_back({{marks.shoulder[s], marks.elbow[s], marks.wrist[s]}, arm(which)});
  }
  std::sort(out.followers.begin(), out.followers.end(),
            [](const Follower& a, const Follower& b) { return a.joint < b.joint; });
  return out;
}

// Rotations and places of a clip, frame by frame, in double precision.
struct Posed {
  PoseTrack track;
  std::vector<Quaterniond> global;
  std::vector<Vector3d> at;

  explicit Posed(const Clip& clip) : track(pose_track(clip)), global(global_rotations(track, clip.skeleton.parents)) {
    const torch::Tensor joints = clip.joints.to(torch::kCPU, torch::kDouble).contiguous();
    const double* p = joints.data_ptr<double>();
    at.reserve(global.size());
    for (size_t k = 0; k < global.size(); ++k, p += 3) at.emplace_back(p[0], p[1], p[2]);
  }
  size_t index(size_t frame, int joint) const {
    return frame * static_cast<size_t>(track.joints) + static_cast<size_t>(joint);
  }
  const Quaterniond& rotation(size_t frame, int joint) const { return global[index(frame, joint)]; }
  const Vector3d& place(size_t frame, int joint) const { return at[index(frame, joint)]; }
  Quaterniond followed(size_t frame, const Follower& f) const {
    return f.low == f.high ? rotation(frame, f.low) : rotation(frame, f.low).slerp(f.weight, rotation(frame, f.high));
  }
};

// Between which poses a frame of the result is, and where in the motion.
struct Between {
  size_t low = 0, high = 0;
  double weight = 0, at = 0;
};

Between between(const SourcePoses& poses, int64_t frame, double step) {
  const auto above = std::upper_bound(poses.frames.begin(), poses.frames.end(), frame);
  const auto high = static_cast<size_t>(above - poses.frames.begin());
  if (high == 0) return {0, 0, 0, poses.at[0] + static_cast<double>(frame - poses.frames[0]) * step};
  const size_t low = high - 1;
  const auto since = static_cast<double>(frame - poses.frames[low]);
  if (high == poses.frames.size()) return {low, low, 0, poses.at[low] + since * step};
  const double weight = since / static_cast<double>(poses.frames[high] - poses.frames[low]);
  return {low, high, weight, poses.at[low] + weight * (poses.at[high] - poses.at[low])};
}

void require_agreement(const Clip& motion, const SourcePoses& poses) {
  const size_t count = poses.frames.size();
  if (count == 0 || poses.at.size() != count || poses.source.frames() != static_cast<int64_t>(count) ||
      poses.standard.frames() != static_cast<int64_t>(count) || (!poses.exact.empty() && poses.exact.size() != count))
    throw Error("transfer", "poses and their times differ in number");
  for (size_t k = 1; k < count; ++k)
    if (poses.frames[k] <= poses.frames[k - 1] || poses.at[k] < poses.at[k - 1])
      throw Error("transfer", "the poses' times are not in order");
  for (const Clip* clip : {&motion, &poses.standard})
    if (clip->skeleton.parents != standard_parents() || !clip->rotations.defined() || !clip->trans.defined())
      throw Error("transfer", "motion and poses need rotations on the standard skeleton");
}

// The motion with the pose that stands just before it, where there is one.
Clip with_pose_before(const Clip& motion, const Clip& pose) {
  Clip out = person_of(motion);
  out.joints = torch::cat({pose.joints.slice(0, 0, 1), motion.joints});
  out.rotations = torch::cat({pose.rotations.slice(0, 0, 1), motion.rotations});
  out.trans = torch::cat({pose.trans.slice(0, 0, 1), motion.trans});
  return out;
}

// One frame of the result while it is found.
struct Figure {
  const std::vector<int>& parents;
  std::vector<Vector3d> places;  // relative to the parents
  std::vector<Quaterniond> local;
  Vector3d trans = Vector3d::Zero();
  BonesPose pose;  // by place_joints

  explicit Figure(const Bones& bones) : parents(bones.parents), places(bones.offsets), local(bones.parents.size()) {
    pose.positions.resize(parents.size());
    pose.rotations.resize(parents.size());
  }
  void place_joints() {
    for (size_t j = 0; j < parents.size(); ++j) {
      const int parent = parents[j];
      pose.rotations[j] = parent < 0 ? local[j] : rotation(parent) * local[j];
      pose.positions[j] =
          parent < 0 ? Vector3d(trans + places[j]) : Vector3d(at(parent) + rotation(parent) * places[j]);
    }
  }
  const Vector3d& at(int joint) const { return pose.positions[static_cast<size_t>(joint)]; }
  const Quaterniond& rotation(int joint) const { return pose.rotations[static_cast<size_t>(joint)]; }
  const Quaterniond& above(int joint) const { return rotation(parents[static_cast<size_t>(joint)]); }
  void set_local(int joint, const Quaterniond& relative) { local[static_cast<size_t>(joint)] = relative.normalized(); }

  // Bends a limb, whose joints may have others between them, so that its end comes to `goal`; the end keeps its
  // rotation. A straight one bends to `side` (unit vector), as its own plane says nothing.
  void reach(const std::array<int, 3>& limb, const Vector3d& goal, const Vector3d& side) {
    const auto [start, mid, end] = limb;
    const Vector3d upper = at(mid) - at(start), lower = at(end) - at(mid), straight = at(end) - at(start);
    const double move = (goal - at(end)).norm();
    if (move < kMissed || upper.norm() < 1e-6 || lower.norm() < 1e-6) return;
    const Vector3d bend = upper - straight * (upper.dot(straight) / std::max(1e-12, straight.squaredNorm()));
    const Vector3d pole = bend + side * kBendByMove * move * std::max(0.0, 1 - bend.norm() / kStraight);
    const TwoBone solved = solve_two_bone(at(start), upper.norm(), lower.norm(), goal, pole, 0);
    const Quaterniond by_upper = Quaterniond::FromTwoVectors(upper, solved.mid - at(start)),
                      by_lower = Quaterniond::FromTwoVectors(lower, solved.end - solved.mid);
    set_local(start, above(start).conjugate() * by_upper * rotation(start));
    set_local(mid, (by_upper * above(mid)).conjugate() * by_lower * rotation(mid));
    set_local(end, (by_lower * above(end)).conjugate() * rotation(end));
  }

  // Rotates a joint that is to stand at `end` by the least that points a joint below it to `goal`.
  // @return where it must stand instead for that joint to be at `goal`, as bones keep their lengths.
  Vector3d point(int joint, const Vector3d& end, int tip, const Vector3d& goal) {
    const Vector3d now = at(tip) - at(joint), wanted = goal - end;
    if ((wanted - now).norm() < kMissed || now.norm() < 1e-6 || wanted.norm() < 1e-6) return end;
    const Quaterniond by = Quaterniond::FromTwoVectors(now, wanted);
    pose.rotations[static_cast<size_t>(joint)] = by * rotation(joint);
    set_local(joint, above(joint).conjugate() * rotation(joint));
    return goal - wanted.normalized() * now.norm();
  }
};

// What poses of the file are off the standard ones, as seen from the standard joints. Rows of one pose.
struct Alignment {
  size_t followers, limbs;
  std::vector<Quaterniond> rotations;         // followers
  std::vector<Vector3d> ends, balls, pelvis;  // limbs, limbs, one

  Alignment(const Mapping& mapping, const Posed& from, const Posed& keys)
      : followers(mapping.followers.size()), limbs(mapping.limbs.size()) {
    const size_t poses = static_cast<size_t>(from.track.frames());
    for (size_t k = 0; k < poses; ++k) {
      for (const Follower& f : mapping.followers)
        rotations.push_back(keys.followed(k, f).conjugate() * from.rotation(k, f.joint));
      const auto off = [&](int joint, int standard, int seen_from) {
        return joint < 0 ? Vector3d::Zero().eval()
                         : Vector3d(keys.rotation(k, seen_from).conjugate() *
                                    (from.place(k, joint) - keys.place(k, standard)));
      };
      for (const SourceLimb& limb : mapping.limbs) {
        ends.push_back(off(limb.joints[2], limb.standard.end, limb.standard.mid));
        balls.push_back(off(limb.ball, limb.standard_ball, limb.standard.end));
      }
      pelvis.push_back(off(mapping.pelvis, 0, 0));
    }
  }
};

// Poses that are to come out as they went in.
void meet_exactly(Clip& out, const SourcePoses& poses) {
  const Clip& source = poses.source;
  for (size_t k = 0; k < poses.frames.size(); ++k) {
    const int64_t f = poses.frames[k];
    if (f < 0 || f >= out.frames() || (!poses.exact.empty() && !poses.exact[k])) continue;
    for (auto [row, pose] : {std::pair(&out.joints, &source.joints), std::pair(&out.rotations, &source.rotations),
                             std::pair(&out.trans, &source.trans), std::pair(&out.translations, &source.translations)})
      if (pose->defined()) (*row)[f].copy_((*pose)[static_cast<int64_t>(k)]);
  }
}

}  // namespace

Clip on_source_skeleton(const Clip& motion, const SourcePoses& poses, int64_t count) {
  const torch::NoGradGuard no_gradients;
  require_agreement(motion, poses);
  const Clip& source = poses.source;
  const bool before = poses.at.front() < 0;
  const Clip line = before ? with_pose_before(motion, poses.standard) : motion;
  std::vector<Between> when;
  std::vector<double> at;
  for (int64_t f = 0; f < count; ++f) {
    when.push_back(between(poses, f, motion.rate / source.rate));
    at.push_back(when.back().at + (before ? 1 : 0));
  }
  const Clip wanted = at_frames(line, at);
  if (!source.rotations.defined() || !source.trans.defined()) {
    Clip out = wanted;
    out.rate = source.rate;
    out.file = source.file;
    return out;
  }

  const Mapping mapping = mapping_of(source.skeleton);
  const Posed from(source), keys(poses.standard), to(wanted);
  const Bones bones = bones_of(source.skeleton);
  const auto joints = static_cast<size_t>(bones.size());
  const Alignment keyed(mapping, from, keys);
  std::vector<int> follower_of(joints, -1);
  for (size_t i = 0; i < keyed.followers; ++i)
    follower_of[static_cast<size_t>(mapping.followers[i].joint)] = static_cast<int>(i);

  PoseTrack track;
  track.joints = bones.size();
  const bool translates = !from.track.places.empty();
  Figure figure(bones);
  std::vector<Quaterniond> global(joints);
  for (size_t t = 0; t < static_cast<size_t>(count); ++t) {
    const Between& b = when[t];
    const auto mixed_place = [&](const std::vector<Vector3d>& values, size_t width, size_t i) {
      return Vector3d((1 - b.weight) * values[b.low * width + i] + b.weight * values[b.high * width + i]);
    };
    for (size_t j = 0; j < joints; ++j) {
      if (translates) figure.places[j] = mixed_place(from.track.places, joints, j);
      const auto parent = static_cast<size_t>(std::max(bones.parents[j], 0));
      if (follower_of[j] < 0) {
        figure.local[j] = from.track.local[b.low * joints + j].slerp(b.weight, from.track.local[b.high * joints + j]);
        global[j] = j == 0 ? figure.local[j] : global[parent] * figure.local[j];
        continue;
      }
      const auto i = static_cast<size_t>(follower_of[j]);
      const Quaterniond &low = keyed.rotations[b.low * keyed.followers + i],
                        &high = keyed.rotations[b.high * keyed.followers + i];
      global[j] = to.followed(t, mapping.followers[i]) * low.slerp(b.weight, high);
      figure.local[j] = (j == 0 ? global[j] : global[parent].conjugate() * global[j]).normalized();
    }
    figure.trans.setZero();
    figure.place_joints();
    figure.trans = to.place(t, 0) + to.rotation(t, 0) * mixed_place(keyed.pelvis, 1, 0) - figure.at(mapping.pelvis);
    figure.place_joints();
    for (size_t i = 0; i < keyed.limbs; ++i) {
      const SourceLimb& limb = mapping.limbs[i];
      const auto goal = [&](int joint, int seen_from, const std::vector<Vector3d>& off) {
        return Vector3d(to.place(t, joint) + to.rotation(t, seen_from) * mixed_place(off, keyed.limbs, i));
      };
      Vector3d end = goal(limb.standard.end, limb.standard.mid, keyed.ends);
      if (limb.ball >= 0)
        end = figure.point(limb.joints[2], end, limb.ball, goal(limb.standard_ball, limb.standard.end, keyed.balls));
      figure.reach(limb.joints, end, to.rotation(t, limb.standard.start) * limb.standard.rest_pole);
    }
    track.trans.push_back(figure.trans);
    track.local.insert(track.local.end(), figure.local.begin(), figure.local.end());
    if (translates) track.places.insert(track.places.end(), figure.places.begin(), figure.places.end());
  }
  Clip out = person_of(source);
  set_pose(out, track);
  meet_exactly(out, poses);
  return out;
}

SourcePoses poses_of(const Clip& source, const Clip& standard, const std::vector<int64_t>& keys,
                     const std::vector<int64_t>& kept, const std::vector<int64_t>& at) {
  if (kept.empty() || kept.size() != at.size()) throw Error("transfer", "poses and their times differ in number");
  SourcePoses out{frames_at(source, keys), frames_at(standard, keys), {}, {}, {}};
  for (const int64_t key : keys) {
    const auto high = std::min<size_t>(
        static_cast<size_t>(std::upper_bound(kept.begin(), kept.end(), key) - kept.begin()), kept.size() - 1);
    const size_t low = high > 0 ? high - 1 : 0;
    const double span = static_cast<double>(std::max<int64_t>(kept[high] - kept[low], 1));
    const double weight = std::clamp(static_cast<double>(key - kept[low]) / span, 0.0, 1.0);
    out.frames.push_back(key - keys.front());
    out.at.push_back(static_cast<double>(at[low]) + weight * static_cast<double>(at[high] - at[low]));
  }
  return out;
}

Clip joined_poses(const std::vector<Clip>& poses) {
  Clip out = person_of(poses.at(0));
  const torch::Tensor& offsets = out.skeleton.offsets;
  // Bones of several files may differ: carry_by_root measures the one to the body in each. By less than 0.02 mm they
  // are the same, in six digits.
  const bool translates = std::any_of(poses.begin(), poses.end(), [&](const Clip& pose) {
    return pose.translations.defined() ||
           (pose.skeleton.size() == out.skeleton.size() && !pose.skeleton.offsets.allclose(offsets, 0, 2e-5));
  });
  std::vector<torch::Tensor> joints, rotations, trans, translations;
  for (const Clip& pose : poses) {
    if (pose.skeleton.names != out.skeleton.names || pose.skeleton.parents != out.skeleton.parents ||
        !pose.rotations.defined() || !pose.trans.defined())
      return {};
    joints.push_back(pose.joints);
    rotations.push_back(pose.rotations);
    trans.push_back(pose.trans + (pose.skeleton.offsets[0] - offsets[0]));
    translations.push_back(pose.translations.defined()
                               ? pose.translations.clone()
                               : pose.skeleton.offsets.unsqueeze(0).repeat({pose.frames(), 1, 1}));
    translations.back().select(1, 0).copy_(offsets[0].expand({pose.frames(), 3}));
  }
  out.joints = torch::cat(joints);
  out.rotations = torch::cat(rotations);
  out.trans = torch::cat(trans);
  if (translates) out.translations = torch::cat(translations);
  return out;
}

Clip going_on(const Clip& source, int64_t start, const Clip& last, const Clip& future) {
  const SourcePoses poses{frames_at(source, {start - 1}), last, {-1}, {-1}, {}};
  const auto count =
      static_cast<int64_t>(std::floor(static_cast<double>(future.frames()) * source.rate / future.rate + 1e-6));
  return on_source_skeleton(future, poses, std::max<int64_t>(count, 1));
}

torch::Tensor labels_going_on(const torch::Tensor& labels, double rate, double source_rate) {
  const int64_t frames = labels.size(-1);
  const auto count = static_cast<int64_t>(std::floor(static_cast<double>(frames) * source_rate / rate + 1e-6));
  std::vector<int64_t> at;
  for (int64_t f = 0; f < std::max<int64_t>(count, 1); ++f)
    at.push_back(std::clamp<int64_t>(std::llround(static_cast<double>(f + 1) * rate / source_rate) - 1, 0, frames - 1));
  return labels.index_select(-1, torch::tensor(at));
}

}  // namespace inhabit
