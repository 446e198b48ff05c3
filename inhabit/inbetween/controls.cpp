#include "inhabit/inbetween/controls.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "inhabit/body/palm.h"
#include "inhabit/error.h"
#include "inhabit/math/natural_spline.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit::inbetween {

using torch::Tensor;

JointContact joint_contact(const std::string& name, double from, double to, const Eigen::Vector3d& place,
                           const Skeleton& file) {
  constexpr int kWrists = 20;  // left, then right
  JointContact out;
  if (name == "left_hand" || name == "right_hand") {
    const int side = name == "left_hand" ? 0 : 1;
    out.joint = kWrists + side;
    out.offset = palm_offset(side).cast<double>();
  } else {
    out.joint = standard_joint_called(name, file);
    if (out.joint < 0)
      throw Error("\"" + name + "\" is no joint; there are left_hand, right_hand, " + joint_names_for(file));
  }
  out.from = from;
  out.to = to;
  out.place = place;
  return out;
}

std::vector<double> contact_gaps(const std::vector<JointContact>& contacts, const Clip& motion) {
  std::vector<double> out;
  if (contacts.empty()) return out;
  out.reserve(contacts.size());
  const PoseTrack track = pose_track(motion);
  const std::vector<Eigen::Quaterniond> rotations = global_rotations(track, motion.skeleton.parents);
  const Tensor joints = motion.joints.to(torch::kFloat64).contiguous();
  const auto at = joints.accessor<double, 3>();
  const auto frame = [&](double seconds) {
    return std::clamp<int64_t>(std::llround(seconds * motion.rate), 0, motion.frames() - 1);
  };
  for (const JointContact& c : contacts) {
    double gap = 0;
    for (int64_t t = frame(c.from); t <= frame(c.to); ++t) {
      const Eigen::Vector3d joint(at[t][c.joint][0], at[t][c.joint][1], at[t][c.joint][2]);
      const Eigen::Quaterniond& rotation = rotations[static_cast<size_t>(t * kStandardJoints + c.joint)];
      gap = std::max(gap, (joint + rotation * c.offset - c.place).norm());
    }
    out.push_back(gap);
  }
  return out;
}

void check(const Controls& controls, size_t keys, double seconds) {
  const std::vector<double>& weights = controls.key_weights;
  if (!weights.empty() && weights.size() != keys)
    throw Error("key weights", fmt::format("{} are given for {} keys", weights.size(), keys));
  for (const double weight : weights)
    if (!(weight >= 0 && weight <= 1)) throw Error("key weights", fmt::format("{} is not in [0, 1]", weight));
  if (!weights.empty() && (weights.front() != 1 || weights.back() != 1))
    throw Error("key weights", "the first and the last key must have 1");
  for (const JointContact& c : controls.contacts) {
    if (c.joint < 0 || c.joint >= kStandardJoints) throw Error("contact", "is of no joint of the standard skeleton");
    if (!(c.from >= 0 && c.from <= c.to && c.to <= seconds))
      throw Error("contact",
                  fmt::format("from {:g} to {:g} s is not within the clip's 0 to {:g} s", c.from, c.to, seconds));
    if (!c.place.allFinite() || !c.offset.allFinite()) throw Error("contact", "its place is not finite");
  }
  double before = 0;
  for (const PathPoint& point : controls.root_path) {
    if (!(point.seconds > before && point.seconds < seconds))
      throw Error("root path",
                  fmt::format("times are not in order between 0 and {:g} s: {:g}", seconds, point.seconds));
    if (!point.place.allFinite()) throw Error("root path", "a point is not finite");
    before = point.seconds;
  }
}

Tensor path_curve(const std::vector<PathPoint>& path, const Tensor& roots, const std::vector<int64_t>& keys,
                  double rate) {
  const Tensor places = roots.to(torch::kFloat64).contiguous();
  const auto at = places.accessor<double, 2>();
  std::vector<std::pair<double, Eigen::Vector2d>> knots;  // frame, place
  knots.reserve(keys.size() + path.size());
  for (const int64_t key : keys) knots.emplace_back(key, Eigen::Vector2d(at[key][0], at[key][2]));
  for (const PathPoint& point : path) {
    const double frame = point.seconds * rate;
    for (const int64_t key : keys)
      if (std::abs(frame - static_cast<double>(key)) < 1)
        throw Error("root path", fmt::format("at {:g} s a key says where the root is", point.seconds));
    knots.emplace_back(frame, point.place);
  }
  std::sort(knots.begin(), knots.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<double> frames;
  Eigen::MatrixXd values(static_cast<Eigen::Index>(knots.size()), 2);
  for (const auto& [frame, place] : knots) {
    values.row(static_cast<Eigen::Index>(frames.size())) = place.transpose();
    frames.push_back(frame);
  }
  const NaturalSpline spline(std::move(frames), values);
  Tensor out = torch::zeros({roots.size(0), 3});
  auto curve = out.accessor<float, 2>();
  for (size_t k = 0; k + 1 < keys.size(); ++k) {
    const double first = static_cast<double>(keys[k]) / rate, last = static_cast<double>(keys[k + 1]) / rate;
    if (std::none_of(path.begin(), path.end(),
                     [&](const PathPoint& p) { return p.seconds > first && p.seconds < last; }))
      continue;
    for (int64_t t = keys[k] + 1; t < keys[k + 1]; ++t) {
      const Eigen::RowVectorXd place = spline.at(static_cast<double>(t));
      curve[t][0] = static_cast<float>(place[0]);
      curve[t][1] = static_cast<float>(place[1]);
      curve[t][2] = 1;
    }
  }
  return out;
}

Clip with_looped_end(const Clip& clip, const Clip& standard) {
  const int64_t last = clip.frames() - 1;
  const Clip end = transformed(transformed(frames_at(clip, {0}), canonical_transform(standard, 0)),
                               canonical_transform(standard, last).inverse());
  Clip out = clip;
  for (Tensor Clip::*part : {&Clip::joints, &Clip::rotations, &Clip::trans, &Clip::translations}) {
    if (!(clip.*part).defined()) continue;
    out.*part = (clip.*part).clone();
    (out.*part)[last].copy_((end.*part)[0]);
  }
  return out;
}

}  // namespace inhabit::inbetween
