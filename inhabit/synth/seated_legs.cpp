#include "inhabit/synth/seated_legs.h"

#include <algorithm>
#include <cmath>

#include "inhabit/math/heading.h"
#include "inhabit/math/random.h"

namespace inhabit {

using Eigen::Vector3d;

namespace {

Eigen::Quaterniond sole_rotation(double yaw, double pitch) {
  return Eigen::AngleAxisd(yaw, Vector3d::UnitY()) * Eigen::AngleAxisd(-pitch, Vector3d::UnitX());
}

/// Least distance between the segments a to b and c to d.
double between_segments(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d u = b - a, v = d - c, w = a - c;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  const double whole = uu * vv - uv * uv;
  double s = whole > 1e-12 ? std::clamp((uv * vw - vv * uw) / whole, 0.0, 1.0) : 0;
  const double t = vv > 1e-12 ? std::clamp((uv * s + vw) / vv, 0.0, 1.0) : 0;
  if (uu > 1e-12) s = std::clamp((uv * t - uw) / uu, 0.0, 1.0);
  return (w + s * u - t * v).norm();
}

}  // namespace

Vector3d SeatedLegs::hip(int side) const {
  Controls c;
  c.root = stay.root;
  c.yaw = heading;
  c.tilt = -0.13;  // as one sits
  return hip_position(figure, side, c);
}

Vector3d SeatedLegs::turned(double left, double up, double ahead) const {
  return Eigen::AngleAxisd(heading, Vector3d::UnitY()) * Vector3d(left, up, ahead);
}

Vector3d SeatedLegs::heel_place(int side, double reach, double pitch, double aside) const {
  const Vector3d& ball = figure.bones.offsets[10 + side];
  const double back = figure.heel_back - ball.z(), up = figure.ball_height - ball.y();  // of the ankle, from the heel
  const double height = std::sin(pitch) * back + std::cos(pitch) * up;
  const Vector3d start = hip(side);
  const double length = reach * figure.leg(), down = start.y() - height;
  const double across = (start - stay.root).dot(turned(1, 0, 0)) - aside;
  const double ahead = std::sqrt(std::max(0.01, length * length - down * down - across * across));
  Vector3d out = stay.root + turned(aside, 0, (start - stay.root).dot(turned(0, 0, 1)) + ahead);
  out.y() = height;
  return out;
}

Vector3d SeatedLegs::knee_of(int side, const Vector3d& ankle) const {
  const Vector3d start = hip(side), along = (ankle - start).normalized(), up = Vector3d::UnitY();
  const double length = (ankle - start).norm();
  const double along_leg = (length * length + figure.thigh * figure.thigh - figure.shank * figure.shank) / (2 * length);
  const double out = std::sqrt(std::max(0.0, figure.thigh * figure.thigh - along_leg * along_leg));
  return start + along_leg * along + out * (up - up.dot(along) * along).normalized();
}

std::vector<LegMove> SeatedLegs::stretched(int which, std::mt19937_64& random) const {
  std::vector<LegMove> out;
  const double reach = uniform(random, 0.9, 0.96), pitch = uniform(random, 0.35, 0.6);
  for (int side = 0; side < 2; ++side) {
    if (which != 2 && which != side) continue;
    const double mirror = side == 0 ? 1 : -1, go = uniform(random, 0.75, 1.0), back = uniform(random, 0.75, 1.0);
    const double late = which == 2 ? uniform(random, 0.0, 0.25) : 0;
    LegMove move;
    move.side = side;
    move.when = {from + late, from + late + go, until - late - back, until - late};
    move.pitch = pitch * uniform(random, 0.9, 1.1);
    move.yaw = heading + mirror * uniform(random, 0.05, 0.25);
    move.ankle =
        heel_place(side, reach * uniform(random, 0.99, 1.01), move.pitch, mirror * uniform(random, 0.09, 0.15));
    move.arch = uniform(random, 0.05, 0.07);
    move.heel_rests = true;
    out.push_back(move);
  }
  return out;
}

std::vector<LegMove> SeatedLegs::ankles_crossed(int over, std::mt19937_64& random) const {
  const double mirror = over == 0 ? 1 : -1;  // the upper leg's side
  const double go = uniform(random, 0.75, 0.95), wait = uniform(random, 0.45, 0.6);
  LegMove under, upper;
  under.side = 1 - over;
  under.when = {from, from + go, until - go, until};
  under.pitch = uniform(random, 0.35, 0.5);
  under.yaw = heading - mirror * uniform(random, 0.05, 0.2);
  under.ankle =
      heel_place(under.side, uniform(random, 0.945, 0.97), under.pitch, -mirror * uniform(random, 0.02, 0.04));
  under.arch = 0.05;
  under.heel_rests = true;
  upper.side = over;
  upper.when = {from + wait, from + wait + go + 0.15, until - wait - go, until - wait + 0.05};
  upper.pitch = uniform(random, 0.3, 0.5);
  upper.yaw = heading + mirror * uniform(random, 0.0, 0.15);
  // On the other shank just above its ankle, and a little past it.
  const Vector3d shank = (under.ankle - knee_of(under.side, under.ankle)).normalized(), up = Vector3d::UnitY();
  const Vector3d off = (up - up.dot(shank) * shank).normalized();
  upper.ankle = under.ankle - 0.03 * shank + uniform(random, 0.106, 0.112) * off +
                turned(-mirror * uniform(random, 0.045, 0.06), 0, 0);
  // Over the other from its own side, not through its shank.
  upper.via = upper.ankle + turned(mirror * 0.16, 0.14, -0.02);
  upper.bends = true;
  return {under, upper};
}

std::vector<LegMove> SeatedLegs::legs_crossed(int over, std::mt19937_64& random) const {
  const double mirror = over == 0 ? 1 : -1;
  const int other = 1 - over;
  // The lower leg as one sits: its thigh all but level.
  const Vector3d knee_below = hip(other) + turned(-mirror * 0.01, -0.02, 0.99 * figure.thigh);
  const Vector3d above = knee_below + turned(0, 2 * figure.thigh_depth + 0.02, uniform(random, -0.02, 0.02));
  const Vector3d from_hip = hip(over);
  LegMove move;
  move.side = over;
  move.knee = from_hip + (above - from_hip).normalized() * figure.thigh;
  const Vector3d hang = turned(-mirror * uniform(random, 0.3, 0.4), -0.75, uniform(random, 0.5, 0.6)).normalized();
  move.ankle = move.knee + hang * 0.995 * figure.shank;
  move.via = 0.5 * (from_hip + knee_below) + turned(mirror * 0.08, 0.02, 0.5 * figure.thigh + 0.28);
  move.bends = move.knee_goes = true;
  move.yaw = heading - mirror * uniform(random, 0.1, 0.3);
  move.pitch = -uniform(random, 0.05, 0.3);
  const double go = uniform(random, 1.1, 1.35);
  move.when = {from, from + go, until - go, until};
  return {move};
}

void move_leg(const Figure& figure, const LegMove& move, double w, FootControl& foot) {
  const Vector3d start = ankle_position(figure, move.side, foot);
  Vector3d ankle = start + w * (move.ankle - start);
  if (move.bends) ankle += 2 * w * (1 - w) * (move.via - 0.5 * (start + move.ankle));
  ankle.y() += 4 * w * (1 - w) * move.arch;
  foot.yaw += w * wrapped(move.yaw - foot.yaw);
  foot.pitch += w * (move.pitch - foot.pitch);
  foot.toe_pitch += w * (move.pitch - foot.toe_pitch);
  foot.ball = ankle + sole_rotation(foot.yaw, foot.pitch) * figure.bones.offsets[10 + move.side];
  if (!move.knee_goes) return;
  foot.knee = move.knee;
  foot.knee_weight = w;
}

double legs_in_each_other(const std::vector<Capsule>& capsules, const Posed& pose) {
  const auto end = [&](const Capsule& c, const std::array<float, 3>& p) -> Vector3d {
    return pose.position[c.joint] + pose.global[c.joint] * Vector3d(p[0], p[1], p[2]);
  };
  double deepest = 0;
  for (const Capsule& a : capsules) {
    const bool shank = a.joint == 4 || a.joint == 7 || a.joint == 10;
    if (!shank && a.joint != 1) continue;
    for (const Capsule& b : capsules) {
      const bool other_shank = b.joint == 5 || b.joint == 8 || b.joint == 11;
      if (!(other_shank || (b.joint == 2 && shank))) continue;  // thighs touch at the hips
      const double apart = between_segments(end(a, a.a), end(a, a.b), end(b, b.a), end(b, b.b));
      deepest = std::max(deepest, static_cast<double>(a.radius + b.radius) - apart);
    }
  }
  return deepest;
}

}  // namespace inhabit
