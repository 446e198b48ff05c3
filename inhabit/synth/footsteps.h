#pragma once
#include <Eigen/Core>
#include <array>
#include <random>
#include <vector>

#include "inhabit/scene/walk_path.h"
#include "inhabit/synth/figure.h"

namespace inhabit {

/// A foothold: the ankle's position over the floor (x, z) and the foot's heading.
struct Foothold {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< metres
  double yaw = 0;                                   ///< radians from +Z towards +X
};

/// A step: the foot leaves its foothold at `lift` and stands at the foothold `foothold` from `land` on. Seconds.
struct Footstep {
  int side = 0;       ///< 0 left, 1 right
  Foothold foothold;  ///< that it goes to
  double lift = 0;    ///< leaves the floor
  double land = 0;    ///< stands again
};

/// How a person walks; drawn once for each clip.
struct GaitStyle {
  double speed = 1.1;  ///< metres a second at full stride
  double walk_ratio =
      0.0065;             ///< step length over steps a minute, metres (about 0.0065 in adults, Sekiya & Nagasaki 1998)
  double width = 0.09;    ///< between the ankles' lines, metres
  double toe_out = 0.09;  ///< radians
  double double_support = 0.22;  ///< fraction of a step during which both feet stand
  double clearance = 0.035;      ///< lift of the swinging foot, metres
  double push_off = 1.0;         ///< scales heel rise
};

/// The steps of a clip, laid one after the other.
class StepPlan {
 public:
  /// Standing at `place` facing `heading` from time 0 on. @param figure must outlive the plan
  StepPlan(const Figure& figure, const GaitStyle& style, const Eigen::Vector2d& place, double heading);

  /// Seconds that are planned.
  double now() const { return now_; }
  Eigen::Vector2d place() const;  ///< under the body while it stands
  /// Radians that the body faces then.
  double heading() const { return heading_; }

  /// Stands on.
  void wait(double seconds) { now_ += seconds; }
  /// Walks along `path` from standing to standing; returns when it has all but stopped.
  double walk(const WalkPath& path, double speed, std::mt19937_64& random);
  /// Turns to `heading` by small steps, the foot of that side first, and comes to stand at `to`, which is near.
  void turn(double heading, const Eigen::Vector2d& to, std::mt19937_64& random);

  /// Moves one foot to `foothold` in `seconds`, for somebody who sits.
  void place_foot(int side, const Foothold& foothold, double seconds) { add(side, foothold, now_, now_ + seconds); }
  /// Where the foot of `side` stands now.
  const Foothold& foothold(int side) const { return foothold_[side]; }

  /// Where the feet stand at time 0.
  const std::array<Foothold, 2>& start() const { return start_; }
  /// All of them, in the order of `lift`.
  const std::vector<Footstep>& steps() const { return steps_; }
  /// Where the foot of `side` stands when the body stands at `place` with `heading`.
  Foothold rest_foothold(int side, const Eigen::Vector2d& place, double heading) const;

 private:
  void add(int side, const Foothold& foothold, double lift, double land);

  const Figure* figure_;
  GaitStyle style_;
  std::array<Foothold, 2> start_, foothold_;
  std::vector<Footstep> steps_;
  double now_ = 0, heading_ = 0;
};

}  // namespace inhabit
