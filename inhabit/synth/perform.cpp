#include "inhabit/synth/perform.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/heading.h"
#include "inhabit/synth/stepping.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// How far a stay on a seat has come: root over the floor, root height and forward lean, each 0 to 1.
struct SeatShare {
  double across = 0, down = 0, lean = 0;
};

SeatShare share_of(const SeatStay& stay, double t) {
  const double going = stay.seated - stay.down, rising = stay.risen - stay.rise;
  SeatShare s;
  if (t < stay.rise) {
    s.across = minimum_jerk((t - stay.down) / (0.85 * going));
    s.down = minimum_jerk((t - stay.down - 0.1 * going) / (0.9 * going));
    s.lean = Envelope{stay.down - 0.05, stay.down + 0.6 * going, stay.down + 0.72 * going, stay.seated + 0.45}.at(t);
  } else {
    // Up by the momentum of the trunk: first lean, then lift.
    s.across = 1 - minimum_jerk((t - stay.rise - 0.22 * rising) / (0.68 * rising));
    s.down = 1 - minimum_jerk((t - stay.rise - 0.32 * rising) / (0.68 * rising));
    s.lean = Envelope{stay.rise, stay.rise + 0.42 * rising, stay.rise + 0.48 * rising, stay.risen + 0.1}.at(t);
  }
  return s;
}

/// Small motions that are never still.
struct Liveliness {
  explicit Liveliness(std::mt19937_64& random)
      : tilt(random, 0.08, 0.4),
        lean(random, 0.08, 0.4),
        twist(random, 0.08, 0.4),
        gaze_yaw(random, 0.1, 0.5),
        gaze_pitch(random, 0.1, 0.5),
        sway_x(random, 0.15, 0.7),
        sway_z(random, 0.15, 0.7),
        arm{{Wander(random, 0.1, 0.5), Wander(random, 0.1, 0.5)}},
        elbow{{Wander(random, 0.1, 0.5), Wander(random, 0.1, 0.5)}},
        breath_phase(6.28 * static_cast<double>(random() >> 11) * 0x1.0p-53) {}
  Wander tilt, lean, twist, gaze_yaw, gaze_pitch, sway_x, sway_z;
  std::array<Wander, 2> arm, elbow;
  double breath_phase;
};

}  // namespace

Performance perform(const Figure& figure, const LifePlan& plan, double from, int frames, double rate,
                    std::mt19937_64& random) {
  const int lead = static_cast<int>(std::lround(from * rate));
  const int all = lead + frames + static_cast<int>(rate);  // a second more, so that smoothing knows what comes
  const GaitStyle& gait = plan.gait;
  const Manner& manner = plan.manner;
  const Stepping steps = step_tracks(figure, gait, plan.steps, plan.favour, all, rate);
  const auto n = static_cast<size_t>(all);
  const Liveliness live(random);

  std::vector<double> swing = smoothed(steps.stride, 0.05 * rate), list(n), yaw(n);
  const std::vector<double> load = smoothed(steps.load, 0.07 * rate);
  for (size_t i = 0; i < n; ++i) {
    const double moving = steps.stepping[i] * std::min(1.0, steps.speed[i] / 1.1);
    list[i] = -(1 - 2 * load[i]) * (0.065 * moving + 0.06 * (1 - steps.stepping[i]));
    yaw[i] = steps.yaw[i] - 0.16 * steps.stride[i];
  }
  const std::vector<double> height = root_height(figure, steps, yaw, list);

  Performance out;
  out.pose.reserve(frames);
  const auto end = static_cast<size_t>(lead) + static_cast<size_t>(frames);
  for (auto i = static_cast<size_t>(lead); i < end; ++i) {
    const double t = static_cast<double>(i) / rate;
    const double moving = steps.stepping[i], speed = steps.speed[i];
    const double breath = std::sin(6.283185 * 0.25 * t + live.breath_phase);
    Controls c;
    double seated = 0;
    int seat = -1;
    c.root = {steps.body[i].x(), height[i], steps.body[i].y()};
    const double still = (1 - moving) * manner.sway;
    const double jolt = steps.jolt[i];
    c.root.y() -= 0.015 * jolt;
    c.root.x() -= 0.005 * jolt * std::sin(steps.yaw[i]);
    c.root.z() -= 0.005 * jolt * std::cos(steps.yaw[i]);
    c.root.x() += 0.004 * still * live.sway_x.at(t);
    c.root.z() += 0.005 * still * live.sway_z.at(t);
    c.yaw = yaw[i];
    c.list = list[i];
    c.tilt = 0.01 + 0.03 * speed + 0.010 * jolt;
    c.bend = manner.upright + 0.015 * speed + 0.012 * manner.sway * live.tilt.at(t) + 0.006 * breath + 0.008 * jolt;
    c.lean = -0.7 * c.list + 0.012 * manner.sway * live.lean.at(t);
    c.twist = 0.24 * swing[i] + 0.015 * manner.sway * live.twist.at(t);
    for (const SeatStay& stay : plan.seats) {
      const SeatShare s = share_of(stay, t);
      const Vector3d standing = c.root;
      c.root.x() += s.across * (stay.root.x() - standing.x());
      c.root.z() += s.across * (stay.root.z() - standing.z());
      c.root.y() += s.down * (stay.root.y() - standing.y());
      c.list *= 1 - s.down;
      c.lean *= 1 - 0.8 * s.down;
      c.tilt += s.lean * 0.5 * stay.deepest_lean - 0.14 * s.down;
      c.bend += s.lean * 0.5 * stay.deepest_lean + 0.1 * s.down;
      seated = std::max(seated, s.down);
      if (s.across > 0.01) seat = stay.furniture;
    }
    bool on_back = false;
    for (const TrunkMove& move : plan.trunk) {
      const double w = move.when.at(t);
      if (w <= 0) continue;
      c.tilt += w * move.tilt;
      c.bend += w * move.bend;
      c.lean += w * move.lean;
      c.twist += w * move.twist;
      c.root += w * move.shift;
      on_back = on_back || (move.leans_on_back && w > 0.97);
    }
    c.foot = steps.foot[i];

    // The head looks where the path goes and stays level.
    const size_t soon = std::min(i + static_cast<size_t>(0.4 * rate), n - 1);
    const double trunk_lean = c.tilt + c.bend;
    c.gaze_yaw =
        steps.yaw[i] + std::clamp(1.1 * (steps.yaw[soon] - steps.yaw[i]), -0.9, 0.9) + 0.05 * live.gaze_yaw.at(t);
    c.gaze_pitch = 0.06 + 0.05 * moving + 0.45 * trunk_lean + 0.035 * live.gaze_pitch.at(t) + 0.01 * jolt;
    const Vector3d eyes = c.root + Vector3d(0, 0.62, 0);
    for (const Look& look : plan.looks) {
      const double w = look.when.at(t);
      if (w <= 0) continue;
      const Vector3d gaze = look.point - eyes;
      const double toward = wrapped(heading_of(on_ground(gaze)) - steps.yaw[i]);
      const double down = -std::atan2(gaze.y(), Vector2d(gaze.x(), gaze.z()).norm());
      c.gaze_yaw += w * (steps.yaw[i] + std::clamp(toward, -1.0, 1.0) - c.gaze_yaw);
      c.gaze_pitch += w * (std::clamp(down, -0.5, 0.75) + 0.25 * trunk_lean - c.gaze_pitch);
    }

    for (int side = 0; side < 2; ++side) {
      ArmControl& a = c.arm[side];
      const double ahead = (side == 0 ? -1 : 1) * swing[i];
      const double flexion = manner.arm_swing * ahead;
      a.flexion =
          flexion + 0.02 + 0.5 * c.bend + 0.02 * manner.sway * live.arm[side].at(t) - 0.06 * moving + 0.13 * jolt;
      // Hanging arms stay upright when the trunk leans.
      a.flexion += 0.75 * std::max(0.0, trunk_lean - 0.1);
      a.abduction = manner.arms_out + 0.02 * live.elbow[side].at(t) + 0.1 * seated;
      a.twist = 0.25;
      a.elbow = manner.elbow + 0.55 * std::max(-0.25, flexion) + 0.12 * moving +
                0.03 * manner.sway * live.elbow[side].at(t) + 0.5 * seated - 0.16 * jolt;
      size_t slot = 0;
      for (const HandTrip& trip : plan.hands) {
        if (trip.side != side || slot == a.pull.size()) continue;
        const double w = trip.when.at(t);
        if (w <= 0) continue;
        a.pull[slot] = trip.pull;
        a.pull[slot].weight = w;
        a.pull[slot].rise = trip.arch * 16 * w * w * (1 - w) * (1 - w);
        ++slot;
      }
    }
    out.pose.push_back(pose_figure(figure, c));
    const Posed& pose = out.pose.back();

    Action action = Action::stand;
    for (const Doing& d : plan.doing)
      if (d.from <= t) action = d.action;
    out.action.push_back(action);
    out.seat.push_back(seat);
    std::array<bool, kStandardJoints> touching{};
    for (int side = 0; side < 2; ++side) {
      touching[7 + side] = steps.heel_down[i][side];
      touching[10 + side] = steps.ball_down[i][side];
    }
    if (seated > 0.999) touching[0] = touching[1] = touching[2] = true;
    if (on_back && seated > 0.999) touching[6] = touching[9] = true;
    std::array<Eigen::Vector4d, 2> target{Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero()};
    for (const HandTrip& trip : plan.hands) {
      if (!trip.touches || trip.when.at(t) < 0.9995) continue;
      if ((pose.position[20 + trip.side] - trip.pull.place).norm() > 0.006) continue;
      // A wrist at its end lifts the palm.
      if (pose.global[20 + trip.side].angularDistance(trip.pull.turn) > 0.2) continue;
      target[trip.side] << trip.point, 1;
      touching[20 + trip.side] = true;
    }
    out.contact.push_back(touching);
    out.hand_target.push_back(target);
  }
  // A seat that is not sat on within these frames counts as any other furniture.
  for (size_t first = 0, last = 0; first < out.seat.size(); first = last) {
    bool sat = false;
    for (last = first; last < out.seat.size() && out.seat[last] == out.seat[first]; ++last)
      sat = sat || out.contact[last][0];
    if (!sat) std::fill(out.seat.begin() + static_cast<long>(first), out.seat.begin() + static_cast<long>(last), -1);
  }
  return out;
}

}  // namespace inhabit
