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
/// Names of actions, "stand", "walk", ... "lean_back", in the order of Action.
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
  double down = 0;                                 ///< begins to sit down
  double seated = 0;                               ///< is on the seat
  double rise = 0;                                 ///< begins to get up
  double risen = 0;                                ///< stands
  Eigen::Vector3d root = Eigen::Vector3d::Zero();  ///< where the root joint rests, world
  double deepest_lean = 0.6;  ///< largest forward lean of the trunk on the way down and up, radians
  int furniture = -1;         ///< index into Room::furniture
};

/// A hand goes somewhere and comes back.
struct HandTrip {
  int side = 0;                                     ///< 0 left, 1 right
  Envelope when;                                    ///< there from `full` to `fall`
  HandPull pull;                                    ///< its weight comes from `when`
  double arch = 0;                                  ///< metres upwards half way there
  bool touches = false;                             ///< a surface of the room, at `point`
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< world, metres
};

/// A leg of somebody seated goes somewhere and comes back. World, metres, radians.
struct LegMove {
  int side = 0;                                     ///< 0 left, 1 right
  Envelope when;                                    ///< there from `full` to `fall`
  Eigen::Vector3d ankle = Eigen::Vector3d::Zero();  ///< where it goes
  double yaw = 0;                                   ///< of the foot, as in FootControl
  double pitch = 0;                                 ///< of the sole, as in FootControl
  double arch = 0;                                  ///< metres upwards half way there
  bool heel_rests = false;                          ///< the heel is on the floor there
  bool bends = false;                               ///< the path there bends towards `via`
  bool knee_goes = false;                           ///< the knee goes to `knee`
  Eigen::Vector3d via = Eigen::Vector3d::Zero();    ///< place beside the ankle's path
  Eigen::Vector3d knee = Eigen::Vector3d::Zero();   ///< place of the knee
};

/// The trunk and head leave their usual posture and return.
struct TrunkMove {
  Envelope when;                                    ///< there from `full` to `fall`
  double tilt = 0;                                  ///< radians, as in Controls
  double bend = 0;                                  ///< likewise
  double lean = 0;                                  ///< likewise
  double twist = 0;                                 ///< likewise
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of the root, world metres
  bool leans_on_back = false;                       ///< the back touches the back rest
};

/// The eyes go to a point.
struct Look {
  Envelope when;                                    ///< there from `full` to `fall`
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< world, metres
};

/// An action, up to the next one's beginning.
struct Doing {
  double from = 0;                ///< seconds
  Action action = Action::stand;  ///< what is done
};

/// Everything a person does in a clip, in seconds from its start; perform() makes it motion.
struct LifePlan {
  /// Somebody who stands at `place` (x, z) facing `heading`. @param figure must outlive the plan
  LifePlan(const Figure& figure, const GaitStyle& style, const Eigen::Vector2d& place, double heading)
      : steps(figure, style, place, heading), gait(style) {}

  StepPlan steps;                ///< where the feet go
  GaitStyle gait;                ///< how they do
  Manner manner;                 ///< how all else moves
  KeyCurve favour;               ///< see step_tracks
  std::vector<Doing> doing;      ///< actions, in rising time
  std::vector<SeatStay> seats;   ///< stays on seats, in rising time
  std::vector<HandTrip> hands;   ///< later ones are laid over earlier ones
  std::vector<LegMove> legs;     ///< while seated
  std::vector<TrunkMove> trunk;  ///< added up
  std::vector<Look> looks;       ///< where the eyes go
  std::vector<int> used;         ///< indices into Room::furniture, in order of use
};

/// A life of at least `seconds` in `room`: walks, turns, stays on seats, touches tables and shelves, stands about.
LifePlan plan_life(const Room& room, const FreeSpace& floor, const Figure& figure, double seconds,
                   std::mt19937_64& random);

/// Extends a life in the same room until it lasts `seconds`. Its earlier part stays.
void extend_life(LifePlan& life, const Room& room, const FreeSpace& floor, const Figure& figure, double seconds,
                 std::mt19937_64& random);

}  // namespace inhabit
