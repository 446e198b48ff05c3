#include "inhabit/synth/posing.h"

#include <cmath>

#include "inhabit/body/two_bone.h"
#include "inhabit/math/quaternion.h"

namespace inhabit {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond about(double angle, const Vector3d& axis) { return Quaterniond(AngleAxisd(angle, axis)); }

Quaterniond about_x(double a) { return about(a, Vector3d::UnitX()); }
Quaterniond about_y(double a) { return about(a, Vector3d::UnitY()); }
Quaterniond about_z(double a) { return about(a, Vector3d::UnitZ()); }

/// That fraction of a rotation.
Quaterniond part(const Quaterniond& rotation, double fraction) {
  return Quaterniond::Identity().slerp(fraction, rotation);
}

Quaterniond pelvis_rotation(const Controls& c) { return about_y(c.yaw) * about_x(c.tilt) * about_z(-c.list); }

Quaterniond foot_rotation(const FootControl& foot) { return about_y(foot.yaw) * about_x(-foot.pitch); }

class Poser {
 public:
  Poser(const Figure& figure, const Controls& controls) : figure_(figure), c_(controls) {}

  Posed pose() {
    posed_.local.fill(Quaterniond::Identity());
    posed_.position[0] = c_.root;
    posed_.global[0] = posed_.local[0] = pelvis_rotation(c_);
    trunk();
    head();
    for (int side = 0; side < 2; ++side) {
      leg_of(side);
      arm_of(side);
    }
    return posed_;
  }

 private:
  /// Puts joint j where its parent has it, with local rotation `local`.
  void set(int j, const Quaterniond& local) {
    const int parent = figure_.bones.parents[j];
    posed_.local[j] = local;
    posed_.global[j] = posed_.global[parent] * local;
    posed_.position[j] = posed_.position[parent] + posed_.global[parent] * figure_.bones.offsets[j];
  }
  void set_global(int j, const Quaterniond& global) {
    set(j, posed_.global[figure_.bones.parents[j]].conjugate() * global);
  }

  void trunk() {
    const Quaterniond bend = about_x(c_.bend) * about_z(-c_.lean);
    // Bending sits low in the back, turning high.
    set(3, part(bend, 0.36) * about_y(0.22 * c_.twist));
    set(6, part(bend, 0.36) * about_y(0.33 * c_.twist));
    set(9, part(bend, 0.28) * about_y(0.45 * c_.twist));
  }

  void head() {
    const Quaterniond chest = posed_.global[9];
    const Quaterniond gaze = about_y(c_.gaze_yaw) * about_x(c_.gaze_pitch);
    const Quaterniond rotation = chest.conjugate() * gaze;
    set(12, part(rotation, 0.45));
    set_global(15, gaze);
  }

  void leg_of(int side) {
    const Limb limb = leg(side == 0 ? Side::left : Side::right);
    set(limb.start, Quaterniond::Identity());
    const FootControl& foot = c_.foot[side];
    const Vector3d ankle = ankle_position(figure_, side, foot);
    // The knee points between where the pelvis and where the foot point.
    const Vector3d ahead(std::sin(foot.yaw), 0, std::cos(foot.yaw));
    const Vector3d pelvis_ahead = posed_.global[0] * Vector3d(side == 0 ? 0.12 : -0.12, 0, 1);
    Vector3d pole = 0.6 * ahead + 0.4 * pelvis_ahead + Vector3d(0, 0.3, 0);
    if (foot.knee_weight > 0) {
      const Vector3d knee = foot.knee - 0.5 * (posed_.position[limb.start] + ankle);
      pole = (1 - foot.knee_weight) * pole.normalized() + foot.knee_weight * knee.normalized();
    }
    const LimbPose solved =
        solve_limb(figure_.bones, limb, posed_.global[0], posed_.position[limb.start], ankle, pole, 0.006);
    set(limb.start, solved.start_rotation);
    set(limb.mid, solved.mid_rotation);
    set_global(limb.end, foot_rotation(foot));
    set_global(10 + side, about_y(foot.yaw) * about_x(-foot.toe_pitch));
  }

  void arm_of(int side) {
    const double mirror = side == 0 ? 1 : -1;
    const ArmControl& free = c_.arm[side];
    const int collar = 13 + side, shoulder = 16 + side, elbow = 18 + side, wrist = 20 + side;
    // Angles first: an arm that hangs, swung forwards, outwards and about itself.
    const double raise = std::max(0.0, free.abduction - 0.3) * 0.25;
    set(collar, about_y(-mirror * 0.12 * free.flexion) * about_z(mirror * (raise - 0.06)));
    const Quaterniond hanging = about_x(-free.flexion) * about_z(mirror * (free.abduction - M_PI / 2));
    // Against the chest, not the collar, so that the collar's motion does not add.
    set_global(shoulder, posed_.global[9] * hanging * about(mirror * -free.twist, Vector3d(1, 0, 0)));
    set(elbow, about_y(-mirror * free.elbow));
    set(wrist, Quaterniond::Identity());
    double reach = 0;
    Vector3d target = posed_.position[wrist];
    Quaterniond rotation = posed_.global[wrist];
    Vector3d pole = posed_.position[elbow] - 0.5 * (posed_.position[shoulder] + posed_.position[wrist]);
    pole += 0.02 * (posed_.global[9] * Vector3d(0, -0.3, -1));
    pole.normalize();
    for (const HandPull& pull : free.pull) {
      if (pull.weight <= 0) continue;
      const bool world = pull.anchor < 0;
      const Quaterniond frame = world ? Quaterniond::Identity() : posed_.global[pull.anchor];
      const Vector3d place = world ? pull.place : Vector3d(posed_.position[pull.anchor] + frame * pull.place);
      target += pull.weight * (place - target) + Vector3d(0, pull.rise, 0);
      rotation = rotation.slerp(pull.weight, frame * pull.rotation);
      const Vector3d down(mirror * std::sin(pull.swivel), -std::cos(pull.swivel), -0.4);
      pole += pull.weight * (about_y(c_.yaw) * down.normalized() - pole);
      reach += pull.weight * (1 - reach);
    }
    if (reach <= 0) return;
    // The collar goes along with a far reach.
    const Vector3d away = target - posed_.position[shoulder];
    const double stretch = std::clamp((away.norm() / figure_.arm() - 0.75) / 0.25, 0.0, 1.0);
    if (stretch > 0) {
      const Quaterniond along =
          Quaterniond::FromTwoVectors(posed_.global[collar] * figure_.bones.offsets[shoulder], away);
      const double angle = 2 * std::acos(std::min(1.0, std::abs(along.w())));
      const double fraction =
          std::min(0.3, angle) / std::max(angle, 1e-6) * stretch * stretch * (3 - 2 * stretch) * reach;
      set_global(collar, part(along, fraction) * posed_.global[collar]);
      set(shoulder, posed_.local[shoulder]);
    }
    const LimbPose solved = solve_limb(figure_.bones, arm(side == 0 ? Side::left : Side::right), posed_.global[collar],
                                       posed_.position[shoulder], target, pole, 0.01);
    set(shoulder, solved.start_rotation);
    set(elbow, solved.mid_rotation);
    hold(side, rotation);
  }

  /// Rotates the hand towards `rotation`: most of the roll comes from the forearm, and the wrist gives only as far as
  /// wrists do.
  void hold(int side, const Quaterniond& rotation) {
    const int elbow = 18 + side, wrist = 20 + side;
    const Vector3d along = figure_.bones.offsets[wrist].normalized();
    const Quaterniond wanted = posed_.global[elbow].conjugate() * rotation;
    const double roll = std::remainder(2 * std::atan2(wanted.vec().dot(along), wanted.w()), 2 * M_PI);
    set(elbow, posed_.local[elbow] * about(0.75 * softly(roll, 1.5), along));
    const Vector3d rest = axis_angle_of(posed_.global[elbow].conjugate() * rotation);
    set(wrist, quaternion_of(Vector3d(softly(rest.x(), 0.9), softly(rest.y(), 0.75), softly(rest.z(), 1.35))));
  }

  /// x near zero, never beyond +-most.
  static double softly(double x, double most) {
    const double knee = 0.7 * most, over = std::abs(x) - knee;
    return over <= 0 ? x : std::copysign(knee + (most - knee) * std::tanh(over / (most - knee)), x);
  }

  const Figure& figure_;
  const Controls& c_;
  Posed posed_;
};

}  // namespace

Quaterniond hand_rotation(int side, const Vector3d& ahead, const Vector3d& palm) {
  // At rest hands point sideways, palms down.
  const Vector3d along(side == 0 ? 1 : -1, 0, 0), back(0, 1, 0);
  Eigen::Matrix3d rest, now;
  rest << along, back, along.cross(back);
  const Vector3d back_now = -(palm - palm.dot(ahead) * ahead).normalized();
  now << ahead, back_now, ahead.cross(back_now);
  return Quaterniond(now * rest.transpose());
}

Posed pose_figure(const Figure& figure, const Controls& controls) { return Poser(figure, controls).pose(); }

Vector3d ankle_position(const Figure& figure, int side, const FootControl& foot) {
  return foot.ball - foot_rotation(foot) * figure.bones.offsets[10 + side];
}

Vector3d hip_position(const Figure& figure, int side, const Controls& controls) {
  return controls.root + pelvis_rotation(controls) * figure.bones.offsets[1 + side];
}

}  // namespace inhabit
