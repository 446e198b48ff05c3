#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "inhabit/body/bones.h"

namespace inhabit::refine {

// A motion to be found as a nonlinear least-squares problem, as data: the unknowns, and the terms whose sum is least
// at the motion sought. Each term adds weight / 2 times its squared residual (loss aside), weights are 1 / sigma^2 with
// sigma in the unit of the residual. Metres, seconds, radians, +Y up.

/// One joint's part of a point that moves with the body: linear blend skinning.
struct Attachment {
  int joint = 0;
  double weight = 1;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< metres, in the joint's frame
};
using Point = std::vector<Attachment>;

/// What a residual of length r costs: squared r^2 / 2; huber the same up to `scale` and linear beyond; norm r itself,
/// rounded off below `scale`.
struct Loss {
  enum class Kind { squared, huber, norm } kind = Kind::squared;
  double scale = 1;
};

/// The pose of one frame.
struct FramePose {
  std::vector<Eigen::Quaterniond> local;  ///< one unit quaternion a joint, relative to its parent
  Eigen::Vector3d trans;                  ///< root joint = trans + bones.offsets[0]
};
using Trajectory = std::vector<FramePose>;

/// Pulls poses to others: rotations by the angle in between, the root by its distance.
struct StayNear {
  std::vector<double> rotations;  ///< (frames x joints) 1 / rad^2
  std::vector<double> root;       ///< (frames) 1 / m^2
  Trajectory to;                  ///< empty: to `Problem::start`
};

/// The n-th difference in time of every joint's position and local rotation, n = 1 velocity, 2 acceleration, 3 jerk.
struct Smoothness {
  int order = 2;
  double positions = 0;  ///< (s^n / m)^2, of the 3-vector of each joint
  double rotations = 0;  ///< (s^n / rad)^2
  Loss loss;
  bool of_change =
      false;  ///< of the difference to `start` instead: what detail it has stays, what is changed is smooth
  std::vector<double> joints;  ///< factor of each joint; empty: 1
};

/// Point `point` at `target` in frame `frame`. Axis-wise weights, 1 / m^2, so that one may be left free.
struct PlaceTerm {
  int64_t frame = 0;
  int point = 0;
  Eigen::Vector3d target, weight;
  Loss loss;
};

/// Point `point` at one place in frames `frame` and `frame` + 1: a contact that lasts.
struct HoldTerm {
  int64_t frame = 0;
  int point = 0;
  Eigen::Vector3d weight;
};

/// Point `point` on the outer side of a plane, normal . place >= height, or on it. The floor is such a plane; a scene's
/// surface is one where the body is near it (scene_terms.h), found anew as the body moves.
struct PlaneTerm {
  int64_t frame = 0;
  int point = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< unit
  double height = 0, weight = 0;                      ///< metres, 1 / m^2
  bool on_it = false;                                 ///< counts on both sides: a contact of unknown place
};

struct DepthTerm;

struct Problem {
  Bones bones;
  double rate = 30;
  Trajectory start;           ///< what changes are measured from
  Trajectory initial;         ///< where the search begins; empty: at `start`
  std::vector<char> fixed;    ///< (frames) 1: comes out exactly as the search begins; empty: none
  std::vector<char> rotates;  ///< (joints) 1: its rotation is unknown; empty: all
  bool moves = true;          ///< whether the root's translation is unknown
  std::vector<Point> points;  ///< the first are the joints themselves, see joint_points

  StayNear stay_near;
  std::vector<Smoothness> smoothness;
  std::vector<PlaceTerm> places;
  std::vector<HoldTerm> holds;
  std::vector<PlaneTerm> planes;
  std::shared_ptr<const DepthTerm> depth;  ///< point clouds that the skin is to fit (depth_terms.h); null: none

  std::vector<Eigen::Vector3d> low, high;  ///< (joints) radians of each axis-angle component; empty: no limits
  double limit_weight = 0;                 ///< 1 / rad^2

  int64_t frames() const { return static_cast<int64_t>(start.size()); }
};

/// One point at each joint.
std::vector<Point> joint_points(int joints);

/// Where a point is.
Eigen::Vector3d place_of(const Point& point, const BonesPose& pose);

}  // namespace inhabit::refine
