#include "inhabit/synth/perform.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/heading.h"
#include "inhabit/synth/seated_legs.h"
#include "inhabit/synth/stepping.h"

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// How far a stay on a seat has come: root over the floor, root height and forward lean, each 0 to 1.
struct SeatProgress {
  double across = 0, down = 0, lean = 0;
};

SeatProgress progress_of(const SeatStay& stay, double t) {
  const double going = stay.seated - stay.down, rising = stay.risen - stay.rise;
  SeatProgress s;
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

/// The quick part of how people stand and sit: tremor of a millimetre or so, that jerk shows and no eye.
struct Quick {
  explicit Quick(std::mt19937_64& random)
      : root{{Wander(random, kSlowest, kFastest), Wander(random, kSlowest, kFastest),
              Wander(random, kSlowest, kFastest)}},
        trunk{{Wander(random, kSlowest, kFastest), Wander(random, kSlowest, kFastest),
               Wander(random, kSlowest, kFastest)}},
        gaze{{Wander(random, kSlowest, kFastest), Wander(random, kSlowest, kFastest)}},
        arm{{Wander(random, kSlowest, kFastest), Wander(random, kSlowest, kFastest)}},
        elbow{{Wander(random, kSlowest, kFastest), Wander(random, kSlowest, kFastest)}} {}
  static constexpr double kSlowest = 1.5, kFastest = 5;  // Hz
  std::array<Wander, 3> root, trunk;
  std::array<Wander, 2> gaze, arm, elbow;
};

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
        breath_phase(6.28 * static_cast<double>(random() >> 11) * 0x1.0p-53),
        quick(random) {}
  Wander tilt, lean, twist, gaze_yaw, gaze_pitch, sway_x, sway_z;
  std::array<Wander, 2> arm, elbow;
  double breath_phase;
  Quick quick;
};

/// A plan with all that is known of it before the frames are posed one by one. Frames count from the plan's start.
class Performer {
 public:
  Performer(const Figure& figure, const LifePlan& plan, int frames, double rate, std::mt19937_64& random)
      : figure_(figure),
        plan_(plan),
        manner_(plan.manner),
        steps_(step_tracks(figure, plan.gait, plan.steps, plan.favour, frames, rate)),
        live_(random),
        rate_(rate),
        swing_(smoothed(steps_.stride, 0.05 * rate)),
        list_(static_cast<size_t>(frames)),
        yaw_(static_cast<size_t>(frames)) {
    const std::vector<double> load = smoothed(steps_.load, 0.07 * rate);
    for (size_t i = 0; i < list_.size(); ++i) {
      const double moving = steps_.stepping[i] * std::min(1.0, steps_.speed[i] / 1.1);
      list_[i] = -(1 - 2 * load[i]) * (0.065 * moving + 0.06 * (1 - steps_.stepping[i]));
      yaw_[i] = steps_.yaw[i] - 0.16 * steps_.stride[i];
    }
    height_ = root_height(figure, steps_, yaw_, list_);
  }

  /// Adds frame i to `out`.
  void play(size_t i, Performance& out) const {
    const double t = static_cast<double>(i) / rate_;
    Controls c = upright(i, t);
    const Sitting sitting = sit(t, c);
    const bool on_back = move_trunk(t, c);
    c.foot = steps_.foot[i];
    std::array<bool, 2> heel = steps_.heel_down[i], ball = steps_.ball_down[i];
    for (const LegMove& move : plan_.legs) {
      const double w = move.when.at(t);
      if (w <= 0) continue;
      move_leg(figure_, move, w, c.foot[static_cast<size_t>(move.side)]);
      heel[static_cast<size_t>(move.side)] = move.heel_rests && w > 0.9999;
      ball[static_cast<size_t>(move.side)] = false;
    }
    look(i, t, c);
    for (int side = 0; side < 2; ++side) move_arm(side, i, t, sitting.down, c);
    out.pose.push_back(pose_figure(figure_, c));

    Action action = Action::stand;
    for (const Doing& d : plan_.doing)
      if (d.from <= t) action = d.action;
    out.action.push_back(action);
    out.seat.push_back(sitting.seat);
    std::array<bool, kStandardJoints> touching{};
    for (int side = 0; side < 2; ++side) {
      touching[7 + side] = heel[side];
      touching[10 + side] = ball[side];
    }
    if (sitting.down > 0.999) touching[0] = touching[1] = touching[2] = true;
    if (on_back && sitting.down > 0.999) touching[6] = touching[9] = true;
    out.hand_target.push_back(touch(t, out.pose.back(), touching));
    out.contact.push_back(touching);
  }

 private:
  struct Sitting {
    double down = 0;  ///< 0 standing, 1 on the seat
    int seat = -1;    ///< furniture
  };

  /// On two feet, walking or not, but for the head and the arms.
  Controls upright(size_t i, double t) const {
    const double moving = steps_.stepping[i], speed = steps_.speed[i], jolt = steps_.jolt[i];
    const double breath = std::sin(6.283185 * 0.25 * t + live_.breath_phase);
    Controls c;
    c.root = {steps_.body[i].x(), height_[i], steps_.body[i].y()};
    const double still = (1 - moving) * manner_.sway;
    c.root.y() -= 0.015 * jolt;
    c.root.x() -= 0.005 * jolt * std::sin(steps_.yaw[i]);
    c.root.z() -= 0.005 * jolt * std::cos(steps_.yaw[i]);
    c.root.x() += 0.004 * still * live_.sway_x.at(t);
    c.root.z() += 0.005 * still * live_.sway_z.at(t);
    for (int k = 0; k < 3; ++k) c.root[k] += (k == 1 ? 0.0006 : 0.0013) * still * live_.quick.root[k].at(t);
    c.yaw = yaw_[i];
    c.list = list_[i];
    c.tilt = 0.01 + 0.03 * speed + 0.010 * jolt;
    c.bend = manner_.upright + 0.015 * speed + 0.012 * manner_.sway * live_.tilt.at(t) + 0.006 * breath + 0.008 * jolt;
    c.lean = -0.7 * c.list + 0.012 * manner_.sway * live_.lean.at(t);
    c.twist = 0.24 * swing_[i] + 0.015 * manner_.sway * live_.twist.at(t);
    c.bend += 0.003 * manner_.sway * live_.quick.trunk[0].at(t);
    c.lean += 0.003 * manner_.sway * live_.quick.trunk[1].at(t);
    c.twist += 0.0045 * manner_.sway * live_.quick.trunk[2].at(t);
    return c;
  }

  Sitting sit(double t, Controls& c) const {
    Sitting out;
    for (const SeatStay& stay : plan_.seats) {
      const SeatProgress s = progress_of(stay, t);
      const Vector3d standing = c.root;
      c.root.x() += s.across * (stay.root.x() - standing.x());
      c.root.z() += s.across * (stay.root.z() - standing.z());
      c.root.y() += s.down * (stay.root.y() - standing.y());
      c.list *= 1 - s.down;
      c.lean *= 1 - 0.8 * s.down;
      c.tilt += s.lean * 0.5 * stay.deepest_lean - 0.14 * s.down;
      c.bend += s.lean * 0.5 * stay.deepest_lean + 0.1 * s.down;
      out.down = std::max(out.down, s.down);
      if (s.across > 0.01) out.seat = stay.furniture;
    }
    return out;
  }

  /// True while the back leans on the back rest.
  bool move_trunk(double t, Controls& c) const {
    bool on_back = false;
    for (const TrunkMove& move : plan_.trunk) {
      const double w = move.when.at(t);
      if (w <= 0) continue;
      c.tilt += w * move.tilt;
      c.bend += w * move.bend;
      c.lean += w * move.lean;
      c.twist += w * move.twist;
      c.root += w * move.shift;
      on_back = on_back || (move.leans_on_back && w > 0.97);
    }
    return on_back;
  }

  /// The head looks along the trajectory, or at what there is to look at, and stays level.
  void look(size_t i, double t, Controls& c) const {
    const size_t soon = std::min(i + static_cast<size_t>(0.4 * rate_), yaw_.size() - 1);
    const double heading = steps_.yaw[i], trunk_lean = c.tilt + c.bend;
    c.gaze_yaw = heading + std::clamp(1.1 * (steps_.yaw[soon] - heading), -0.9, 0.9) + 0.05 * live_.gaze_yaw.at(t);
    c.gaze_pitch =
        0.06 + 0.05 * steps_.stepping[i] + 0.45 * trunk_lean + 0.035 * live_.gaze_pitch.at(t) + 0.01 * steps_.jolt[i];
    c.gaze_yaw += 0.005 * live_.quick.gaze[0].at(t);
    c.gaze_pitch += 0.004 * live_.quick.gaze[1].at(t);
    const Vector3d eyes = c.root + Vector3d(0, 0.62, 0);
    for (const Look& look : plan_.looks) {
      const double w = look.when.at(t);
      if (w <= 0) continue;
      const Vector3d there = look.point - eyes;
      const double toward = wrapped(heading_of(on_ground(there)) - heading);
      const double down = -std::atan2(there.y(), Vector2d(there.x(), there.z()).norm());
      c.gaze_yaw += w * (heading + std::clamp(toward, -1.0, 1.0) - c.gaze_yaw);
      c.gaze_pitch += w * (std::clamp(down, -0.5, 0.75) + 0.25 * trunk_lean - c.gaze_pitch);
    }
  }

  void move_arm(int side, size_t i, double t, double seated, Controls& c) const {
    const double moving = steps_.stepping[i], jolt = steps_.jolt[i], trunk_lean = c.tilt + c.bend;
    ArmControl& a = c.arm[side];
    const double ahead = (side == 0 ? -1 : 1) * swing_[i];
    const double flexion = manner_.arm_swing * ahead;
    a.flexion =
        flexion + 0.02 + 0.5 * c.bend + 0.02 * manner_.sway * live_.arm[side].at(t) - 0.06 * moving + 0.13 * jolt;
    a.flexion += 0.005 * manner_.sway * live_.quick.arm[side].at(t);
    // Hanging arms stay upright when the trunk leans.
    a.flexion += 0.75 * std::max(0.0, trunk_lean - 0.1);
    a.abduction = manner_.arms_out + 0.02 * live_.elbow[side].at(t) + 0.1 * seated;
    a.twist = 0.25;
    a.elbow = manner_.elbow + 0.55 * std::max(-0.25, flexion) + 0.12 * moving +
              0.03 * manner_.sway * live_.elbow[side].at(t) + 0.5 * seated - 0.16 * jolt +
              0.006 * manner_.sway * live_.quick.elbow[side].at(t);
    size_t slot = 0;
    for (const HandTrip& trip : plan_.hands) {
      if (trip.side != side || slot == a.pull.size()) continue;
      const double w = trip.when.at(t);
      if (w <= 0) continue;
      a.pull[slot] = trip.pull;
      a.pull[slot].weight = w;
      a.pull[slot].rise = trip.arch * 16 * w * w * (1 - w) * (1 - w);
      ++slot;
    }
  }

  /// What the hands touch: points of surfaces, with 1 behind them. The hands' contacts are set too.
  std::array<Eigen::Vector4d, 2> touch(double t, const Posed& pose, std::array<bool, kStandardJoints>& touching) const {
    std::array<Eigen::Vector4d, 2> target{Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero()};
    for (const HandTrip& trip : plan_.hands) {
      if (!trip.touches || trip.when.at(t) < 0.9995) continue;
      if ((pose.position[20 + trip.side] - trip.pull.place).norm() > 0.006) continue;
      // A wrist at its end lifts the palm.
      if (pose.global[20 + trip.side].angularDistance(trip.pull.rotation) > 0.2) continue;
      target[trip.side] << trip.point, 1;
      touching[20 + trip.side] = true;
    }
    return target;
  }

  const Figure& figure_;
  const LifePlan& plan_;
  const Manner& manner_;
  const Stepping steps_;
  const Liveliness live_;
  const double rate_;
  const std::vector<double> swing_;
  std::vector<double> list_, yaw_, height_;
};

/// A seat that is not sat on within these frames counts as any other furniture.
void forget_unused_seats(Performance& performance) {
  std::vector<int>& seat = performance.seat;
  for (size_t first = 0, last = 0; first < seat.size(); first = last) {
    bool sat = false;
    for (last = first; last < seat.size() && seat[last] == seat[first]; ++last)
      sat = sat || performance.contact[last][0];
    if (!sat) std::fill(seat.begin() + static_cast<long>(first), seat.begin() + static_cast<long>(last), -1);
  }
}

}  // namespace

Performance perform(const Figure& figure, const LifePlan& plan, double from, int frames, double rate,
                    std::mt19937_64& random) {
  const int first = static_cast<int>(std::lround(from * rate));
  const int all = first + frames + static_cast<int>(rate);  // a second more, so that smoothing knows what comes
  const Performer performer(figure, plan, all, rate, random);
  Performance out;
  out.pose.reserve(frames);
  for (int i = first; i < first + frames; ++i) performer.play(static_cast<size_t>(i), out);
  forget_unused_seats(out);
  return out;
}

}  // namespace inhabit
