#include "inhabit/synth/stepping.h"

#include <algorithm>
#include <cmath>

namespace inhabit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kGravity = 9.81;
constexpr double kToeBreak = 0.2;       // radians of heel rise until the toes leave the floor too
constexpr double kStraightest = 0.993;  // of a leg's length

/// One foot through all its footholds: where it stands, and pitch keys.
class FootTrack {
 public:
  FootTrack(const Figure& figure, const GaitStyle& style, const StepPlan& plan, int side)
      : figure_(figure), style_(style), side_(side), start_(plan.start()[side]) {
    Foothold before = start_;
    double stood_from = -1e3;
    pitch_.add(-1e3, 0);
    for (const Footstep& step : plan.steps()) {
      if (step.side != side) continue;
      const Vector2d stride = step.foothold.place - before.place;
      const double ahead = stride.dot(ahead_of(before.yaw + 0.5 * wrapped(step.foothold.yaw - before.yaw)));
      add_pitch(step, std::clamp(ahead / (1.45 * figure.leg()), -0.6, 1.2), stood_from);
      steps_.push_back(step);
      vigour_.push_back(std::clamp(std::abs(ahead) / (1.45 * figure.leg()), 0.0, 1.0));
      before = step.foothold;
      stood_from = step.land;
    }
    pitch_.add(1e3, 0);
  }

  double pitch(double t) const { return pitch_.at(t); }

  /// The foothold at time t, or between two: ground place and yaw, and lift of the swing.
  struct Ground {
    Foothold foothold;
    double lift = 0;
    bool swinging = false;
  };
  Ground ground(double t) const {
    Ground g;
    g.foothold = start_;
    for (size_t k = 0; k < steps_.size(); ++k) {
      const Footstep& step = steps_[k];
      // In long steps the weight has gone before: the foot is drawn up while its toes still brush the floor.
      const double leaves = step.lift - 0.05 * vigour_[k];
      if (t <= leaves) break;
      if (t >= step.land) {
        g.foothold = step.foothold;
        continue;
      }
      const double part = (t - leaves) / (step.land - leaves);
      // The heel leads: the foot is off the floor before it goes anywhere.
      const double hold = 0.1 - 0.05 * vigour_[k];
      const double u = std::max(0.0, (part - hold) / (1 - hold)), u2 = u * u, u3 = u2 * u;
      // The foot leaves and comes with some speed in long steps.
      const double leave = 0.4 * vigour_[k] * vigour_[k], come = 0.25 * vigour_[k];
      const double f = 3 * u2 - 2 * u3 + leave * (u3 - 2 * u2 + u) + come * (u3 - u2);
      g.foothold.place += f * (step.foothold.place - g.foothold.place);
      g.foothold.yaw += minimum_jerk(u) * wrapped(step.foothold.yaw - g.foothold.yaw);
      // Up quickly, before the foot is fast, and down late.
      g.lift = style_.clearance * Envelope{0, 0.36, 0.6, 1}.at(part);
      // The knee of a long step folds first: the whole foot rises behind the body.
      g.lift += 0.012 * vigour_[k] * Envelope{0, 0.27, 0.3, 0.75}.at(part);
      g.swinging = true;
      break;
    }
    return g;
  }

  /// Foot pose of a foothold under pitch: the sole rolls over heel, ball and toe tip.
  FootControl control(const Ground& ground, double pitch) const {
    FootControl foot;
    foot.yaw = ground.foothold.yaw;
    foot.pitch = pitch;
    const Eigen::AngleAxisd rotation(foot.yaw, Vector3d::UnitY());
    const Vector3d rest = rotation * figure_.bones.offsets[10 + side_];
    const double h = figure_.ball_height;
    Vector2d shift(0, 0);  // ahead, up
    if (pitch > 0) {
      const Vector2d arm(figure_.heel_back, h);
      const double c = std::cos(pitch), s = std::sin(pitch);
      shift = Vector2d(c * arm.x() - s * arm.y(), s * arm.x() + c * arm.y()) - arm;
      foot.toe_pitch = pitch;
    } else {
      const double x = -pitch - kToeBreak;
      const double tip = x > 0 ? x * x / (x + 0.12) : 0;
      const Vector2d arm(-figure_.toe_front, h);
      const double c = std::cos(tip), s = std::sin(tip);
      shift = Vector2d(c * arm.x() + s * arm.y(), -s * arm.x() + c * arm.y()) - arm;
      foot.toe_pitch = -tip;
    }
    const Vector2d ahead = ahead_of(foot.yaw) * shift.x() + Vector2d(rest.x(), rest.z()) + ground.foothold.place;
    foot.ball = Vector3d(ahead.x(), h + shift.y() + ground.lift, ahead.y());
    return foot;
  }

 private:
  void add_pitch(const Footstep& step, double vigour, double stood_from) {
    const double forward = std::max(vigour, 0.0), swing = step.land - step.lift;
    const double push = -style_.push_off * (0.32 + 0.68 * forward);
    const double strike = vigour > 0.25 ? 0.3 * (vigour - 0.25) / 0.75 : vigour < -0.05 ? -0.12 : 0.0;
    const double rising = std::min(0.17 + 0.15 * forward, 0.6 * (step.lift - stood_from));
    pitch_.add(step.lift - rising, 0);
    pitch_.add(step.lift - 0.4 * rising, 0.38 * push);
    pitch_.add(step.lift, 0.8 * push);
    pitch_.add(step.lift + 0.11 * swing, push);
    pitch_.add(step.lift + 0.26 * swing, 0.85 * push);
    pitch_.add(step.lift + 0.68 * swing, 0.02 * push + 0.2 * strike);
    pitch_.add(step.lift + 0.93 * swing, strike);
    pitch_.add(step.land, 0.96 * strike);
    pitch_.add(step.land + 0.07 + 0.03 * forward, 0);
  }

  const Figure& figure_;
  const GaitStyle& style_;
  int side_;
  Foothold start_;
  std::vector<Footstep> steps_;
  std::vector<double> vigour_;
  KeyCurve pitch_;
};

/// Weight on the left foot, and how far each foot's centre of pressure is ahead of its rest.
struct Pressure {
  KeyCurve load;
  std::array<KeyCurve, 2> ahead;
};

Pressure pressure_of(const StepPlan& plan) {
  Pressure p;
  p.load.add(-1e3, 0.5);
  for (auto& a : p.ahead) a.add(-1e3, 0);
  const auto& steps = plan.steps();
  double rested = -1e3;
  for (size_t k = 0; k < steps.size(); ++k) {
    const Footstep& step = steps[k];
    const bool first = step.lift - rested > 0.4, last = k + 1 == steps.size() || steps[k + 1].lift - step.land > 0.4;
    const int other = 1 - step.side;
    if (first) {
      p.load.add(step.lift - 0.38, 0.5);
      p.ahead[0].add(step.lift - 0.38, 0);
      p.ahead[1].add(step.lift - 0.38, 0);
    }
    const double full = step.side == 0 ? 0.03 : 0.97;
    p.load.add(step.lift + 0.02, full);
    p.load.add(step.land - 0.02, full);
    p.ahead[other].add(step.lift, first ? -0.02 : -0.045);
    p.ahead[other].add(step.land, last ? 0.03 : 0.1);
    p.ahead[step.side].add(step.lift, 0.11);
    p.ahead[step.side].add(step.land, -0.045);
    if (last) {
      p.load.add(step.land + 0.4, 0.5);
      p.ahead[0].add(step.land + 0.4, 0);
      p.ahead[1].add(step.land + 0.4, 0);
    }
    rested = step.land;
  }
  return p;
}

/// x - lag^2 x'' = p with x' = 0 at both ends, one tridiagonal sweep (Thomas). @param lag in frames.
std::vector<double> pendulum(const std::vector<double>& p, double lag) {
  const size_t n = p.size();
  const double a = lag * lag;
  std::vector<double> upper(n), x(n);
  for (size_t i = 0; i < n; ++i) {
    const bool end = i == 0 || i + 1 == n;
    const double lower = i == 0 ? 0 : -a, diagonal = 1 + (end ? a : 2 * a);
    const double pivot = diagonal - (i == 0 ? 0 : lower * upper[i - 1]);
    upper[i] = i + 1 == n ? 0 : -a / pivot;
    x[i] = (p[i] - (i == 0 ? 0 : lower * x[i - 1])) / pivot;
  }
  for (size_t i = n - 1; i-- > 0;) x[i] -= upper[i] * x[i + 1];
  return x;
}

}  // namespace

Stepping step_tracks(const Figure& figure, const GaitStyle& style, const StepPlan& plan, const KeyCurve& favour,
                     int frames, double rate) {
  const std::array<FootTrack, 2> tracks{FootTrack(figure, style, plan, 0), FootTrack(figure, style, plan, 1)};
  const Pressure pressure = pressure_of(plan);
  const auto n = static_cast<size_t>(frames);
  Stepping out;
  out.foot.resize(n), out.heel_down.resize(n), out.ball_down.resize(n), out.body.resize(n), out.load.resize(n);
  std::array<std::vector<double>, 2> px_pz{std::vector<double>(n), std::vector<double>(n)};
  std::array<std::vector<double>, 2> pitch{std::vector<double>(n), std::vector<double>(n)};
  std::array<std::vector<FootTrack::Ground>, 2> ground;
  std::vector<double> busy(n, 0.0), heading(n);
  for (const Footstep& step : plan.steps())
    for (int i = std::max(0, static_cast<int>((step.lift - 0.15) * rate));
         i < std::min(frames, static_cast<int>((step.land + 0.1) * rate)); ++i)
      busy[i] = 1;
  out.stepping = smoothed(busy, 0.12 * rate);
  out.jolt.assign(n, 0.0);
  Foothold before[2] = {plan.start()[0], plan.start()[1]};
  for (const Footstep& step : plan.steps()) {
    // A damped ring.
    const double strength =
        std::min(1.2, (step.foothold.place - before[step.side].place).norm() / (1.45 * figure.leg()));
    before[step.side] = step.foothold;
    for (int i = std::max(0, static_cast<int>(std::ceil(step.land * rate)));
         i < std::min(frames, static_cast<int>((step.land + 0.5) * rate)); ++i) {
      const double t = static_cast<double>(i) / rate - step.land;
      out.jolt[i] += strength * 1.6 * std::exp(-t / 0.09) * std::sin(2 * M_PI * 5.6 * t);
    }
  }
  for (int side = 0; side < 2; ++side) {
    for (size_t i = 0; i < n; ++i) {
      const double t = static_cast<double>(i) / rate;
      ground[side].push_back(tracks[side].ground(t));
      pitch[side][i] = tracks[side].pitch(t);
    }
    pitch[side] = smoothed(pitch[side], 0.014 * rate);
    // Soften leaving and landing a little, as a shoe does.
    std::array<std::vector<double>, 2> place{std::vector<double>(n), std::vector<double>(n)};
    for (size_t i = 0; i < n; ++i)
      for (int a = 0; a < 2; ++a) place[a][i] = ground[side][i].foothold.place[a];
    for (int a = 0; a < 2; ++a) place[a] = smoothed(place[a], 0.012 * rate);
    for (size_t i = 0; i < n; ++i) {
      FootTrack::Ground g = ground[side][i];
      g.foothold.place = {place[0][i], place[1][i]};
      out.foot[i][side] = tracks[side].control(g, pitch[side][i]);
      out.heel_down[i][side] = !g.swinging && pitch[side][i] > -0.06;
      out.ball_down[i][side] = !g.swinging && pitch[side][i] < 0.06;
    }
  }
  for (size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate;
    const double standing = 1 - out.stepping[i];
    double load = pressure.load.at(t);
    load += standing * (0.5 + 0.5 * favour.at(t) - load);
    out.load[i] = load;
    Vector2d p(0, 0);
    heading[i] = ground[0][i].foothold.yaw + 0.5 * wrapped(ground[1][i].foothold.yaw - ground[0][i].foothold.yaw);
    for (int side = 0; side < 2; ++side) {
      const Foothold& foothold = ground[side][i].foothold;
      const Vector2d center = foothold.place + ahead_of(foothold.yaw) * pressure.ahead[side].at(t) -
                              ahead_of(heading[i]) * figure.ankle_ahead;
      p += (side == 0 ? load : 1 - load) * center;
    }
    for (int a = 0; a < 2; ++a) px_pz[a][i] = p[a];
  }
  for (size_t i = 1; i < n; ++i) heading[i] = heading[i - 1] + wrapped(heading[i] - heading[i - 1]);
  const double lag = std::sqrt(figure.stand_height / kGravity) * rate;
  const std::vector<double> x = pendulum(px_pz[0], lag), z = pendulum(px_pz[1], lag);
  for (size_t i = 0; i < n; ++i) out.body[i] = {x[i], z[i]};
  out.yaw = smoothed(heading, 0.16 * rate);
  std::vector<double> stride(n), speed(n);
  for (size_t i = 0; i < n; ++i) {
    const Vector3d apart = ankle_position(figure, 0, out.foot[i][0]) - ankle_position(figure, 1, out.foot[i][1]);
    stride[i] = Vector2d(apart.x(), apart.z()).dot(ahead_of(out.yaw[i])) * out.stepping[i];
    speed[i] = (out.body[std::min(i + 1, n - 1)] - out.body[i == 0 ? 0 : i - 1]).norm() * rate / 2;
  }
  out.stride = smoothed(stride, 0.05 * rate);
  out.speed = smoothed(speed, 0.1 * rate);
  return out;
}

std::vector<double> root_height(const Figure& figure, const Stepping& stepping, const std::vector<double>& yaw,
                                const std::vector<double>& list) {
  const size_t n = stepping.body.size();
  const double reach = kStraightest * figure.leg();
  std::vector<double> bound(n);
  for (size_t i = 0; i < n; ++i) {
    Controls c;
    c.root = {stepping.body[i].x(), 0, stepping.body[i].y()};
    c.yaw = yaw[i];
    c.list = list[i];
    double highest = figure.stand_height - 0.004 - 0.005 * stepping.stepping[i] * std::min(1.0, stepping.speed[i]);
    for (int side = 0; side < 2; ++side) {
      const Vector3d hip = hip_position(figure, side, c), ankle = ankle_position(figure, side, stepping.foot[i][side]);
      // A swinging leg that does not reach its place yet comes a little late; it does not pull the body down.
      const bool swings = !stepping.heel_down[i][side] && !stepping.ball_down[i][side];
      const double most = swings ? reach + 0.008 : reach;
      const double across = Vector2d(hip.x() - ankle.x(), hip.z() - ankle.z()).norm();
      highest = std::min(highest, ankle.y() + std::sqrt(std::max(0.04, most * most - across * across)) - hip.y());
    }
    bound[i] = highest;
  }
  // Smooth, then lower where the smooth curve would overstretch a leg.
  std::vector<double> height = smoothed(bound, 1.3);
  for (int round = 0; round < 3; ++round) {
    std::vector<double> excess(n);
    for (size_t i = 0; i < n; ++i) excess[i] = std::max(0.0, height[i] - bound[i]);
    excess = smoothed(excess, 1.0);
    for (size_t i = 0; i < n; ++i) height[i] -= 1.3 * excess[i];
  }
  return height;
}

}  // namespace inhabit
