#pragma once
#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "inhabit/synth/curves.h"
#include "inhabit/synth/footsteps.h"
#include "inhabit/synth/posing.h"
#include "inhabit/synth/room_space.h"

namespace inhabit {

/// What a person is doing; the order of Clip::action_names in clips made here.
enum class Action { stand, walk, turn, sit_down, sit, stand_up, reach, touch, gesture, lean_back };
const std::vector<std::string>& action_names();

/// How a person moves apart from walking; drawn once for each clip.
struct Manner {
  double arm_swing = 0.5;  ///< radians of shoulder for a metre of stride
  double arms_out = 0.17;  ///< radians off the body
  double elbow = 0.28;     ///< radians
  double upright = 0.02;   ///< forward lean, radians
  double sway = 1.0;       ///< scales small motions
  double pace = 1.0;       ///< scales the time sitting down and reaching take
};

/// A stay on a seat: going down from `down` to `seated`, getting up from `rise` to `risen`, seconds.
struct SeatStay {
  double down = 0, seated = 0, rise = 0, risen = 0;
  Eigen::Vector3d root = Eigen::Vector3d::Zero();  ///< where the root joint rests, world
  double deepest_lean = 0.6;  ///< largest forward lean of the trunk on the way down and up, radians
  int furniture = -1;
};

/// A hand goes somewhere and comes back.
struct HandTrip {
  int side = 0;
  Envelope when;
  HandPull pull;         ///< its weight comes from `when`
  double arch = 0;       ///< metres upwards half way there
  bool touches = false;  ///< a surface of the room, at `point`
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

/// A leg of somebody seated goes somewhere and comes back. World, metres, radians.
struct LegMove {
  int side = 0;
  Envelope when;
  Eigen::Vector3d ankle = Eigen::Vector3d::Zero();
  double yaw = 0, pitch = 0;  ///< of the sole, as in FootControl
  double arch = 0;            ///< metres upwards half way there
  bool heel_rests = false;    ///< the heel is on the floor there
  bool bends = false;         ///< the way there bends towards `via`
  bool knee_goes = false;     ///< the knee goes to `knee`
  Eigen::Vector3d via = Eigen::Vector3d::Zero(), knee = Eigen::Vector3d::Zero();
};

/// The trunk and head leave their usual posture and return.
struct TrunkMove {
  Envelope when;
  double tilt = 0, bend = 0, lean = 0, twist = 0;   ///< radians, as in Controls
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of the root, world metres
  bool leans_on_back = false;                       ///< the back touches the back rest
};

/// The eyes go to a point.
struct Look {
  Envelope when;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

struct Doing {
  double from = 0;
  Action action = Action::stand;
};

/// Everything a person does in a clip, in seconds from its start; perform() makes it motion.
struct LifePlan {
  LifePlan(const Figure& figure, const GaitStyle& style, const Eigen::Vector2d& place, double heading)
      : steps(figure, style, place, heading), gait(style) {}

  StepPlan steps;
  GaitStyle gait;
  Manner manner;
  KeyCurve favour;  ///< see step_tracks
  std::vector<Doing> doing;
  std::vector<SeatStay> seats;
  std::vector<HandTrip> hands;
  std::vector<LegMove> legs;
  std::vector<TrunkMove> trunk;
  std::vector<Look> looks;
  std::vector<int> used;  ///< indices into Room::furniture, in order of use
};

/// A life of at least `seconds` in `room`: walks, turns, stays on seats, touches tables and shelves, stands about.
LifePlan plan_life(const Room& room, const FreeSpace& floor, const Figure& figure, double seconds,
                   std::mt19937_64& random);

/// Extends a life in the same room until it lasts `seconds`. Its earlier part stays.
void extend_life(LifePlan& life, const Room& room, const FreeSpace& floor, const Figure& figure, double seconds,
                 std::mt19937_64& random);

}  // namespace inhabit
