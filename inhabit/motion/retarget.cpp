#include "inhabit/motion/retarget.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>

#include "inhabit/body/bones.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/body/proportions.h"
#include "inhabit/error.h"
#include "inhabit/math/quantile.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int J = kStandardJoints;

// A value a frame.
using Points = std::vector<Vector3d>;
using Rotations = std::vector<Quaterniond>;

// Coordinate by coordinate.
Vector3d middle_of(const Points& points) {
  Vector3d out;
  std::vector<double> values(points.size());
  for (int k = 0; k < 3; ++k) {
    std::transform(points.begin(), points.end(), values.begin(), [k](const Vector3d& p) { return p[k]; });
    out[k] = median(values);
  }
  return out;
}

Quaterniond swing(const Vector3d& from, const Vector3d& to) { return Quaterniond::FromTwoVectors(from, to); }

// The source's positions and global rotations, frame by frame.
struct Source {
  int64_t frames = 0;
  std::vector<Points> at;            // [joint][frame]
  std::vector<Rotations> rotations;  // [joint][frame]; empty without rotations
  Points rest;                       // [joint], where all frames are parallel to the world's

  bool has_rotations() const { return !rotations.empty(); }
};

Source source_of(const Clip& clip) {
  Source out;
  const auto joints = static_cast<size_t>(clip.skeleton.size());
  out.frames = clip.frames();
  const torch::Tensor positions = clip.joints.to(torch::kCPU, torch::kDouble).contiguous();
  const double* p = positions.data_ptr<double>();
  out.at.assign(joints, Points(static_cast<size_t>(out.frames)));
  for (size_t t = 0; t < static_cast<size_t>(out.frames); ++t)
    for (size_t j = 0; j < joints; ++j, p += 3) out.at[j][t] = Vector3d(p[0], p[1], p[2]);
  const Bones bones = bones_of(clip.skeleton);
  for (size_t j = 0; j < joints; ++j)
    out.rest.push_back(j == 0 ? bones.offsets[0]
                              : Vector3d(out.rest[static_cast<size_t>(bones.parents[j])] + bones.offsets[j]));
  if (clip.rotations.defined() && clip.trans.defined()) {
    const Rotations global = global_rotations(pose_track(clip), clip.skeleton.parents);
    out.rotations.assign(joints, Rotations(static_cast<size_t>(out.frames)));
    for (size_t t = 0; t < static_cast<size_t>(out.frames); ++t)
      for (size_t j = 0; j < joints; ++j) out.rotations[j][t] = global[t * joints + j];
  }
  return out;
}

// x left, y up, z forward, from two directions that need not be orthogonal; `left` is kept.
Quaterniond upright_frame(const Vector3d& left, const Vector3d& up) {
  Eigen::Matrix3d m;
  m.col(0) = left.normalized();
  m.col(2) = m.col(0).cross(up);
  if (m.col(2).norm() < 1e-6) return swing(Vector3d::UnitX(), left);
  m.col(2).normalize();
  m.col(1) = m.col(2).cross(m.col(0));
  return Quaterniond(m);
}

// Standard axes (x left, y up, z forward) at rest in the source's rest world. Rest poses are drawn along the axes of
// their world, so a frame near to those is taken for exactly those.
Quaterniond rest_axes(const Source& source, const Landmarks& marks) {
  const auto rest = [&](int joint) { return source.rest[static_cast<size_t>(joint)]; };
  const Vector3d middle = 0.5 * (rest(marks.hip[0]) + rest(marks.hip[1]));
  const Vector3d left = rest(marks.hip[0]) - rest(marks.hip[1]), up = rest(marks.head) - middle;
  if (left.norm() < 1e-6 || up.norm() < 1e-6) return Quaterniond::Identity();
  const Eigen::Matrix3d m = upright_frame(left, up).toRotationMatrix();
  Eigen::Matrix3d snapped = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) {
    Eigen::Index row = 0;
    if (m.col(k).cwiseAbs().maxCoeff(&row) < std::cos(30 * M_PI / 180)) return Quaterniond(m);
    snapped(row, k) = m(row, k) > 0 ? 1 : -1;
  }
  return Quaterniond(snapped);
}

// A point at a fraction of the length of a curve through joints, as joint + part * (next joint - joint).
struct CurvePoint {
  size_t segment = 0;
  double part = 0;
};

CurvePoint point_at(const std::vector<double>& lengths, double fraction) {
  double left = fraction, total = 0;
  for (const double length : lengths) total += length;
  left *= total;
  for (size_t k = 0; k < lengths.size(); ++k) {
    if (left <= lengths[k] && lengths[k] > 0) return {k, left / lengths[k]};
    left -= lengths[k];
  }
  return {lengths.size() - 1, 1};
}

// The 22 positions and the frames of pelvis and thorax.
struct Targets {
  std::array<Points, J> at;
  Rotations pelvis, thorax;
};

// `point` in the frame that moves with `origin` and `frame`: its median place there, brought back to the world.
Points carried(const Points& origin, const Rotations& frame, const Points& point, Vector3d* place = nullptr) {
  Points local(point.size()), out(point.size());
  for (size_t t = 0; t < point.size(); ++t) local[t] = frame[t].conjugate() * (point[t] - origin[t]);
  const Vector3d middle = middle_of(local);
  if (place != nullptr) *place = middle;
  for (size_t t = 0; t < point.size(); ++t) out[t] = origin[t] + frame[t] * middle;
  return out;
}

Points mixed(const Points& a, const Points& b, double part) {
  Points out(a.size());
  for (size_t t = 0; t < a.size(); ++t) out[t] = a[t] + part * (b[t] - a[t]);
  return out;
}

/// The curve from pelvis to neck, one point of it a joint of the source.
struct SpineCurve {
  std::vector<Points> points;
  std::vector<double> lengths;  // of its segments, metres

  /// Where a joint of the standard spine is on it: as far along as in the built-in body.
  Points at(int standard_joint) const {
    const std::array<Vector3d, J> body = builtin_rest_joints();
    double along = 0, whole = 0;
    for (const auto& [a, b] : {std::pair{0, 3}, {3, 6}, {6, 9}, {9, 12}}) {
      const double length = (body[static_cast<size_t>(b)] - body[static_cast<size_t>(a)]).norm();
      whole += length;
      if (b <= standard_joint) along += length;
    }
    const CurvePoint p = point_at(lengths, along / whole);
    return mixed(points[p.segment], points[p.segment + 1], p.part);
  }
};

SpineCurve spine_curve(const Source& source, const Landmarks& marks, const Points& neck, const std::string& subject) {
  SpineCurve out;
  for (const int joint : marks.spine) out.points.push_back(source.at[static_cast<size_t>(joint)]);
  out.points.push_back(neck);
  double total = 0;
  for (size_t k = 0; k + 1 < out.points.size(); ++k) {
    std::vector<double> values(neck.size());
    for (size_t t = 0; t < values.size(); ++t) values[t] = (out.points[k + 1][t] - out.points[k][t]).norm();
    out.lengths.push_back(median(values));
    total += out.lengths.back();
  }
  if (!(total > 1e-4)) throw Error(subject, "the spine has no length");
  return out;
}

Targets targets_of(const Source& source, const Landmarks& marks, const std::string& subject) {
  const auto frames = static_cast<size_t>(source.frames);
  const auto at = [&](int joint) -> const Points& { return source.at[static_cast<size_t>(joint)]; };
  Targets out;
  out.at[0] = at(marks.pelvis);
  for (size_t s = 0; s < 2; ++s) {
    out.at[1 + s] = at(marks.hip[s]);
    out.at[4 + s] = at(marks.knee[s]);
    out.at[7 + s] = at(marks.ankle[s]);
    if (marks.toe[s] >= 0) out.at[10 + s] = at(marks.toe[s]);
    out.at[16 + s] = at(marks.shoulder[s]);
    out.at[18 + s] = at(marks.elbow[s]);
    out.at[20 + s] = at(marks.wrist[s]);
  }
  out.at[15] = at(marks.head);
  // Where the neck starts; a head that follows the thorax at once leaves that open, and the shoulders tell.
  out.at[12] = marks.neck >= 0 ? at(marks.neck) : mixed(at(marks.thorax), at(marks.head), 0.6);

  const SpineCurve spine = spine_curve(source, marks, out.at[12], subject);

  if (source.has_rotations()) {
    const Quaterniond axes = rest_axes(source, marks);
    for (size_t t = 0; t < frames; ++t) {
      out.pelvis.push_back(source.rotations[static_cast<size_t>(marks.pelvis)][t] * axes);
      out.thorax.push_back(source.rotations[static_cast<size_t>(marks.thorax)][t] * axes);
    }
  } else {
    const Points middle_back = spine.at(6);
    for (size_t t = 0; t < frames; ++t) {
      const Vector3d middle = 0.5 * (out.at[1][t] + out.at[2][t]);
      out.pelvis.push_back(upright_frame(out.at[1][t] - out.at[2][t], middle_back[t] - middle));
      out.thorax.push_back(upright_frame(out.at[16][t] - out.at[17][t], out.at[12][t] - middle_back[t]));
    }
  }
  const Points low = carried(out.at[0], out.pelvis, spine.at(3));
  out.at[6] = spine.at(6);
  // A back that bends at the pelvis joint itself leaves the bone from spine1 to spine2 its length only where spine1
  // lies close to that joint: as far up as keeps the length within a centimetre, else a tenth of the distance.
  for (double part = 1; part > 0.05; part -= 0.15) {
    double shortest = 1e9, longest = 0;
    out.at[3] = mixed(out.at[0], low, part);
    for (size_t t = 0; t < frames; ++t) {
      const double length = (out.at[6][t] - out.at[3][t]).norm();
      shortest = std::min(shortest, length), longest = std::max(longest, length);
    }
    if (longest - shortest < 0.01) break;
  }
  out.at[9] = carried(at(marks.thorax), out.thorax, spine.at(9));

  for (size_t s = 0; s < 2; ++s) {
    // Some skeletons start both collar bones on the midline; ours start a third of the distance out.
    Vector3d place = Vector3d::Zero();
    if (marks.collar[s] >= 0) out.at[13 + s] = carried(at(marks.thorax), out.thorax, at(marks.collar[s]), &place);
    if (marks.collar[s] < 0 || std::abs(place.x()) < 0.02)
      out.at[13 + s] = carried(at(marks.thorax), out.thorax, mixed(out.at[12], out.at[16 + s], 0.35));
  }
  return out;
}

// The median, unless that is more than a centimetre off in some frame: then as near to it as the range allows.
double bone_length(const std::vector<double>& lengths) {
  const auto [shortest, longest] = std::minmax_element(lengths.begin(), lengths.end());
  const double low = *longest - 0.01, high = *shortest + 0.01;
  return low > high ? 0.5 * (low + high) : std::clamp(median(lengths), low, high);
}

// The standard skeleton with the person's bones, see the header. Toes that are missing have the built-in foot, scaled.
Bones person_of(const Targets& targets, const std::string& subject) {
  const std::array<Vector3d, J> body = builtin_rest_joints();
  Bones out;
  out.parents = standard_parents();
  out.offsets.assign(J, Vector3d::Zero());
  double scale = 1;  // of the legs
  for (const int j : {1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 10, 11}) {
    const auto k = static_cast<size_t>(j), parent = static_cast<size_t>(out.parents[k]);
    const Vector3d drawn = body[k] - body[parent];
    if (targets.at[k].empty()) {
      out.offsets[k] = drawn * scale;
      continue;
    }
    const bool of_pelvis = parent == 0, of_thorax = parent == 9;
    Points local(targets.at[k].size());
    std::vector<double> lengths(local.size());
    for (size_t t = 0; t < local.size(); ++t) {
      Vector3d start = targets.at[parent][t];
      if (j == 9) {  // spine2 comes out at its bone's length from spine1
        const Vector3d along = start - targets.at[3][t];
        if (along.norm() > 1e-6) start = targets.at[3][t] + along.normalized() * out.offsets[6].norm();
      }
      local[t] = targets.at[k][t] - start;
      lengths[t] = local[t].norm();
      if (of_pelvis) local[t] = targets.pelvis[t].conjugate() * local[t];
      if (of_thorax) local[t] = targets.thorax[t].conjugate() * local[t];
    }
    const double length = bone_length(lengths);
    if (!(length > 1e-4)) throw Error(subject, "the bone to " + standard_joint_names()[k] + " has no length");
    out.offsets[k] = of_pelvis || of_thorax ? middle_of(local) : Vector3d(drawn.normalized() * length);
    if (j == 7 || j == 8) scale = length / drawn.norm();
  }
  return out;
}

// Global rotations of the limbs' joints before they are pointed at their targets: what twist they have.
std::array<Rotations, J> twists_of_source(const Source& source, const Landmarks& marks, const Bones& person) {
  const Quaterniond axes = rest_axes(source, marks);
  const auto rest = [&](int joint) { return source.rest[static_cast<size_t>(joint)]; };
  // Standard frame at rest whose bone to joint `end` lies as the source's bone from `a` to `b` does. Where that is
  // nearly opposite to how the bone is drawn (skeletons whose joints' own axes run along the bones), the axes do not
  // tell about what to swing it over: the frame of the bone above does.
  const auto aligned = [&](int end, int a, int b, const Quaterniond* above = nullptr) {
    const Vector3d bone = rest(b) - rest(a), &drawn = person.offsets[static_cast<size_t>(end)];
    if (bone.norm() < 1e-6) return axes;
    const bool opposite = (axes * drawn).dot(bone) < -0.5 * drawn.norm() * bone.norm();
    const Quaterniond& from = opposite && above != nullptr ? *above : axes;
    return Quaterniond(swing(from * drawn, bone) * from);
  };
  std::array<Rotations, J> out;
  const auto set = [&](int joint, int from, const Quaterniond& at_rest) {
    Rotations& rotations = out[static_cast<size_t>(joint)];
    for (const Quaterniond& rotation : source.rotations[static_cast<size_t>(from)])
      rotations.push_back(rotation * at_rest);
  };
  set(15, marks.head, axes);
  if (marks.neck >= 0) set(12, marks.neck, aligned(15, marks.neck, marks.head));
  for (size_t s = 0; s < 2; ++s) {
    const int side = static_cast<int>(s);
    const Quaterniond thigh = aligned(4 + side, marks.hip[s], marks.knee[s]);
    const Quaterniond shank = aligned(7 + side, marks.knee[s], marks.ankle[s], &thigh);
    set(1 + side, marks.hip[s], thigh);
    set(4 + side, marks.knee[s], shank);
    Quaterniond foot = axes;
    if (marks.toe[s] >= 0) {
      foot = aligned(10 + side, marks.ankle[s], marks.toe[s], &shank);
      // A rest pose with a flat foot has flat toes.
      set(10 + side, marks.toe[s], foot.angularDistance(axes) < M_PI / 4 ? axes : foot);
    }
    set(7 + side, marks.ankle[s], foot);
    const Quaterniond upper_arm = aligned(18 + side, marks.shoulder[s], marks.elbow[s]);
    set(16 + side, marks.shoulder[s], upper_arm);
    const Quaterniond forearm = aligned(20 + side, marks.elbow[s], marks.wrist[s], &upper_arm);
    set(18 + side, marks.elbow[s], forearm);
    set(20 + side, marks.wrist[s], forearm);
  }
  return out;
}

// About which angle (radians, about the bone) the upper frame of a limb must be rotated further so that the limb's bend
// lies in its hinge's plane, as sin^2(bend) * exp(i angle): straight limbs say nothing.
std::complex<double> hinge_twist(const Quaterniond& upper, const Vector3d& rest_bone, const Vector3d& rest_bend,
                                 const Vector3d& lower_bone) {
  const Vector3d axis = rest_bone.normalized();
  const Vector3d bone = (upper.conjugate() * lower_bone).normalized();
  const Vector3d bend = bone - bone.dot(axis) * axis, x = (rest_bend - rest_bend.dot(axis) * axis).normalized();
  const std::complex<double> direction(bend.dot(x), bend.dot(axis.cross(x)));
  return direction * std::abs(direction);
}

// The standard limbs: upper joint, middle, end; which way the lower bone bends at rest.
struct HingedLimb {
  size_t upper, middle, end;
  Vector3d bend;
};
const std::array<HingedLimb, 4>& hinged_limbs() {
  static const std::array<HingedLimb, 4> limbs = {
      HingedLimb{1, 4, 7, {0, 0, -1}}, {2, 5, 8, {0, 0, -1}}, {16, 18, 20, {0, 0, 1}}, {17, 19, 21, {0, 0, 1}}};
  return limbs;
}

// Sums over time that fade by e in `frames` frames, both ways.
void smooth(std::vector<std::complex<double>>& values, double frames) {
  const double keep = std::exp(-1 / std::max(frames, 1e-3));
  std::vector<std::complex<double>> sum = values;
  for (size_t t = 1; t < values.size(); ++t) sum[t] += keep * sum[t - 1];
  std::complex<double> behind = 0;
  for (size_t t = values.size(); t-- > 0;) {
    sum[t] += behind;
    behind = keep * (behind + values[t]);
  }
  values = std::move(sum);
}

// Rotates the limbs' frames about their bones until elbows and knees bend about their hinges: by one angle for the
// whole clip where the source has rotations (its twist is kept), else by what the frames around say.
void settle_twists(const Targets& targets, const Bones& person, bool measured, double rate,
                   std::array<Rotations, J>& twist) {
  for (const HingedLimb& limb : hinged_limbs()) {
    const Vector3d& bone = person.offsets[limb.middle];
    const size_t frames = targets.at[0].size();
    std::vector<std::complex<double>> evidence(frames);
    std::complex<double> whole = 0;
    for (size_t t = 0; t < frames; ++t) {
      Quaterniond& upper = twist[limb.upper][t];
      upper = swing(upper * bone, targets.at[limb.middle][t] - targets.at[limb.upper][t]) * upper;
      evidence[t] = hinge_twist(upper, bone, limb.bend, targets.at[limb.end][t] - targets.at[limb.middle][t]);
      whole += evidence[t];
    }
    const bool bends = std::abs(whole) > 0.002 * static_cast<double>(frames);  // by 3 degrees and more
    const double mean = bends ? std::arg(whole) : 0;
    if (!measured) {
      smooth(evidence, 0.1 * rate);
      for (std::complex<double>& e : evidence) e += std::polar(0.05, mean);
    }
    for (size_t t = 0; t < frames; ++t) {
      const Eigen::AngleAxisd about_bone(measured ? mean : std::arg(evidence[t]), bone.normalized());
      twist[limb.upper][t] = twist[limb.upper][t] * about_bone;
      if (!measured) continue;
      const bool arm = limb.upper >= 16;
      const Eigen::AngleAxisd lower(about_bone.angle(), person.offsets[limb.end].normalized());
      twist[limb.middle][t] = twist[limb.middle][t] * lower;
      if (arm) twist[limb.end][t] = twist[limb.end][t] * lower;
    }
  }
}

PoseTrack solve(const Targets& targets, const Bones& person, const std::array<Rotations, J>& twist) {
  PoseTrack out;
  out.joints = J;
  std::array<Vector3d, J> at;
  std::array<Quaterniond, J> rotated;
  for (size_t t = 0; t < targets.at[0].size(); ++t) {
    at[0] = targets.at[0][t];
    out.trans.push_back(at[0] - person.offsets[0]);
    for (size_t j = 0; j < J; ++j) {
      const auto parent = static_cast<size_t>(std::max(person.parents[j], 0));
      if (j > 0) at[j] = at[parent] + rotated[parent] * person.offsets[j];
      Quaterniond frame = twist[j].empty() ? rotated[parent] : twist[j][t];
      if (j == 0) frame = targets.pelvis[t];
      if (j == 9) frame = targets.thorax[t];
      if (j == 3) frame = targets.pelvis[t].slerp(1.0 / 3, targets.thorax[t]);
      if (j == 6) frame = targets.pelvis[t].slerp(2.0 / 3, targets.thorax[t]);
      // Joints with one child point at where it is, from where they themselves came out.
      const auto child = std::find(person.parents.begin() + 1, person.parents.end(), static_cast<int>(j));
      if (j != 0 && j != 9 && child != person.parents.end()) {
        const auto c = static_cast<size_t>(child - person.parents.begin());
        if (!targets.at[c].empty()) {
          const Vector3d aim = targets.at[c][t] - at[j];
          if (aim.norm() > 1e-6) frame = swing(frame * person.offsets[c], aim) * frame;
        }
      }
      rotated[j] = frame.normalized();
      out.local.push_back(j == 0 ? rotated[j] : (rotated[parent].conjugate() * rotated[j]).normalized());
    }
  }
  return out;
}

bool starts_with_standard_joints(const Skeleton& skeleton) {
  return skeleton.size() >= J &&
         std::equal(standard_parents().begin(), standard_parents().end(), skeleton.parents.begin()) &&
         std::equal(standard_joint_names().begin(), standard_joint_names().end(), skeleton.names.begin());
}

Clip cut_to_standard(const Clip& source) {
  Clip out = source;
  out.skeleton.names.resize(J);
  out.skeleton.parents.resize(J);
  out.skeleton.offsets = source.skeleton.offsets.slice(0, 0, J);
  out.joints = source.joints.slice(1, 0, J);
  out.rotations = source.rotations.slice(1, 0, J);
  out.translations = torch::Tensor();
  out.file = {};
  if (source.contact.defined()) out.contact = source.contact.slice(1, 0, J);
  return out;
}

}  // namespace

Clip retarget(const Clip& source, const std::string& subject) {
  validate(source, subject);
  if (starts_with_standard_joints(source.skeleton) && source.rotations.defined() && source.trans.defined())
    return cut_to_standard(source);
  const Landmarks marks = find_landmarks(source.skeleton, subject);
  const Source from = source_of(source);
  Targets targets = targets_of(from, marks, subject);
  const Bones person = person_of(targets, subject);
  std::array<Rotations, J> twist;
  if (from.has_rotations()) {
    twist = twists_of_source(from, marks, person);
  } else {
    for (size_t s = 0; s < 2; ++s) {
      twist[1 + s] = targets.pelvis;
      twist[16 + s] = targets.thorax;
    }
  }
  settle_twists(targets, person, from.has_rotations(), source.rate, twist);
  const PoseTrack track = solve(targets, person, twist);

  Clip out = source;
  out.skeleton.names = standard_joint_names();
  out.skeleton.parents = standard_parents();
  out.skeleton.offsets = torch::empty({J, 3});
  for (int j = 0; j < J; ++j)
    Eigen::Map<Eigen::Vector3f>(out.skeleton.offsets.data_ptr<float>() + 3 * j) =
        person.offsets[static_cast<size_t>(j)].cast<float>();
  out.betas = torch::Tensor();
  out.file = {};
  set_pose(out, track);
  float* p = out.joints.data_ptr<float>();
  for (size_t t = 0; t < static_cast<size_t>(from.frames); ++t)
    for (size_t j = 0; j < J; ++j, p += 3)  // toes that the source lacks stay where the fitted foot has them
      if (!targets.at[j].empty()) Eigen::Map<Eigen::Vector3f>(p, 3) = targets.at[j][t].cast<float>();
  if (source.contact.defined()) {
    const std::array<int, J> counterpart = counterparts(marks);
    out.contact = torch::zeros({source.frames(), J}, source.contact.options());
    for (int j = 0; j < J; ++j)
      if (counterpart[static_cast<size_t>(j)] >= 0)
        out.contact.select(1, j).copy_(source.contact.select(1, counterpart[static_cast<size_t>(j)]));
  }
  return out;
}

Clip retarget_if_known(const Clip& source, const std::string& subject) {
  try {
    return retarget(source, subject);
  } catch (const Error&) {
    return source;
  }
}

}  // namespace inhabit
