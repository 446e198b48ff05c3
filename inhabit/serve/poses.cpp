#include "inhabit/serve/poses.h"

#include <algorithm>

#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/math/heading.h"
#include "inhabit/synth/posing.h"

namespace inhabit::serve {
namespace {

/// How a pose differs from standing: metres and radians, arms left and right.
struct PoseShape {
  const char* name;
  double lower = 0, tilt = 0, bend = 0;  ///< of the root; forward
  double stride = 0;                     ///< from foot to foot
  std::array<ArmControl, 2> arm;
};

ArmControl arm(double flexion, double abduction, double elbow) {
  ArmControl out;
  out.flexion = flexion;
  out.abduction = abduction;
  out.elbow = elbow;
  return out;
}

const std::vector<PoseShape>& pose_shapes() {
  const ArmControl hangs = arm(0, 0.12, 0.2);
  static const std::vector<PoseShape> all = {
      {"standing", 0, 0, 0, 0, {hangs, hangs}},
      {"crouching", 0.36, 0.3, 0.25, 0.25, {arm(0.9, 0.1, 0.7), arm(0.9, 0.1, 0.7)}},
      {"reaching up", 0, 0, 0, 0.1, {hangs, arm(2.7, 0.1, 0.15)}},
      {"arms wide", 0, 0, 0, 0, {arm(0, 1.4, 0.1), arm(0, 1.4, 0.1)}},
      {"step", 0.03, 0.03, 0, 0.5, {arm(-0.35, 0.1, 0.3), arm(0.35, 0.1, 0.4)}},
  };
  return all;
}

}  // namespace

const std::vector<std::string>& pose_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const PoseShape& shape : pose_shapes()) out.emplace_back(shape.name);
    return out;
  }();
  return names;
}

Frame pose_at(const World& world, const std::string& name, const Eigen::Vector2d& place, double heading) {
  const auto& all = pose_shapes();
  const auto shape = std::find_if(all.begin(), all.end(), [&](const PoseShape& s) { return name == s.name; });
  if (shape == all.end()) {
    std::string names;
    for (const std::string& known : pose_names()) names += (names.empty() ? "" : ", ") + known;
    throw Error("pose", "is not known; there are " + names);
  }
  if (!world.free_at(place)) throw Error("pose", "is not free: nobody can stand there");
  static const Figure figure = make_figure(builtin_body(), {});
  const Eigen::Vector2d ahead = ahead_of(heading), left = left_of(heading);
  Controls controls;
  controls.root = {place.x(), figure.stand_height - shape->lower, place.y()};
  controls.yaw = controls.gaze_yaw = heading;
  controls.tilt = shape->tilt;
  controls.bend = shape->bend;
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1 : -1;
    const Eigen::Vector2d ball =
        place + sign * 0.09 * left + (figure.ankle_ahead + 0.1 + sign * 0.5 * shape->stride) * ahead;
    controls.foot[static_cast<size_t>(side)] = {{ball.x(), figure.ball_height, ball.y()}, heading, 0, 0};
  }
  controls.arm = shape->arm;
  const Posed posed = pose_figure(figure, controls);
  return frame_of(
      interact::SettledPose{{posed.local.begin(), posed.local.end()}, posed.position[0] - figure.bones.offsets[0], {}});
}

}  // namespace inhabit::serve
