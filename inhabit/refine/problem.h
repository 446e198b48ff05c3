#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "inhabit/body/bones.h"
#include "inhabit/body/joint_limits.h"

namespace inhabit::refine {

// A motion to be found as a nonlinear least-squares problem, as data: the unknowns, and the terms whose sum is least
// at the motion sought. Each term adds weight / 2 times its squared residual (loss aside), weights are 1 / sigma^2 with
// sigma in the unit of the residual. Metres, seconds, radians, +Y up.

/// One joint's part of a point that moves with the body: linear blend skinning.
struct Attachment {
  int joint = 0;                                     ///< of Problem::bones
  double weight = 1;                                 ///< part of the point that goes with it; a point's add up to 1
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< metres, in the joint's frame
};
/// A point of the body: the weighted mean of its attachments' places.
using Point = std::vector<Attachment>;

/// What a residual of length r costs: squared r^2 / 2; huber the same up to `scale` and linear beyond; norm r itself,
/// rounded off below `scale`.
struct Loss {
  /// How the cost grows with the length.
  enum class Kind {
    squared,               ///< as r^2 / 2
    huber,                 ///< the same up to `scale`, as a line beyond
    norm                   ///< as r, rounded off below `scale`
  } kind = Kind::squared;  ///< how the cost grows with the length
  double scale = 1;        ///< in the unit of r, of a PlaceTerm in its standard deviations; `squared` has no use for it
};

/// The pose of one frame.
struct FramePose {
  std::vector<Eigen::Quaterniond> local;  ///< one unit quaternion a joint, relative to its parent
  Eigen::Vector3d trans;                  ///< root joint = trans + bones.offsets[0]
};
/// A motion, a pose for each frame.
using Trajectory = std::vector<FramePose>;

/// Pulls poses to others: rotations by the angle in between, the root by its distance.
struct StayNear {
  std::vector<double> rotations;  ///< (frames x joints) 1 / rad^2
  std::vector<double> root;       ///< (frames) 1 / m^2
  Trajectory to;                  ///< empty: to `Problem::start`
};

/// The n-th difference in time of every joint's position and local rotation, n = 1 velocity, 2 acceleration, 3 jerk.
struct Smoothness {
  int order = 2;         ///< n, 1 to 3
  double positions = 0;  ///< (s^n / m)^2, of the 3-vector of each joint
  double rotations = 0;  ///< (s^n / rad)^2
  Loss loss;             ///< of one joint's difference, m / s^n or rad / s^n
  bool of_change =
      false;  ///< of the difference to `start` instead: what detail it has stays, what is changed is smooth
  std::vector<double> joints;  ///< factor of each joint; empty: 1
};

/// Point `point` at `target` in frame `frame`. Axis-wise weights, 1 / m^2, so that one may be left free.
struct PlaceTerm {
  int64_t frame = 0;       ///< of Problem::start
  int point = 0;           ///< of Problem::points
  Eigen::Vector3d target;  ///< metres, world
  Eigen::Vector3d weight;  ///< 1 / m^2 of each world axis; 0: left free
  Loss loss;               ///< of the distance over its standard deviation
};

/// Point `point` at one place in frames `frame` and `frame` + 1: a contact that lasts.
struct HoldTerm {
  int64_t frame = 0;       ///< the first of the two
  int point = 0;           ///< of Problem::points
  Eigen::Vector3d weight;  ///< 1 / m^2 of each world axis
};

/// Point `point` on the outer side of a plane, normal . place >= height, or on it. The floor is such a plane; a scene's
/// surface is one where the body is near it (scene_terms.h), found anew as the body moves.
struct PlaneTerm {
  int64_t frame = 0;                                  ///< of Problem::start
  int point = 0;                                      ///< of Problem::points
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit
  double height = 0;                                  ///< metres from the origin to the plane along the normal
  double weight = 0;                                  ///< 1 / m^2
  bool on_it = false;                                 ///< counts on both sides: a contact of unknown place
};

struct DepthTerm;

/// The motion sought: what is known of it, which of it is unknown, and the terms.
struct Problem {
  Bones bones;                ///< the skeleton, joints after their parents
  double rate = 30;           ///< frames a second
  Trajectory start;           ///< what changes are measured from
  Trajectory initial;         ///< where the search begins; empty: at `start`
  std::vector<char> fixed;    ///< (frames) 1: comes out exactly as the search begins; empty: none
  std::vector<char> rotates;  ///< (joints) 1: its rotation is unknown; empty: all
  bool moves = true;          ///< whether the root's translation is unknown
  std::vector<Point> points;  ///< the first are the joints themselves, see joint_points

  StayNear stay_near;                      ///< without weights it pulls at nothing
  std::vector<Smoothness> smoothness;      ///< each over all frames
  std::vector<PlaceTerm> places;           ///< points that are wanted somewhere, in any order
  std::vector<HoldTerm> holds;             ///< points that are to stay where they are, in any order
  std::vector<PlaneTerm> planes;           ///< surfaces that points are kept out of or on, in any order
  std::shared_ptr<const DepthTerm> depth;  ///< point clouds that the skin is to fit (depth_terms.h); null: none

  JointLimits limits;       ///< of the local rotations, but the root's; empty: none
  double limit_weight = 0;  ///< 1 / rad^2; 0: no limits

  /// What `stay_near` pulls to.
  const Trajectory& near_to() const { return stay_near.to.empty() ? start : stay_near.to; }
  /// T, the frames of `start`.
  int64_t frames() const { return static_cast<int64_t>(start.size()); }
};

/// One point at each joint.
std::vector<Point> joint_points(int joints);

/// Where a point is.
Eigen::Vector3d place_of(const Point& point, const BonesPose& pose);

}  // namespace inhabit::refine
