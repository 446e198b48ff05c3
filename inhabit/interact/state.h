#pragma once
#include <Eigen/Core>
#include <array>

#include "inhabit/interact/layout.h"
#include "inhabit/interact/voxels.h"

namespace inhabit::interact {

/// One frame of the window of time. Hands: 0 left, 1 right.
struct Sample {
  Place root;                                      ///< of the person, on the floor
  std::array<float, kActions> action{};            ///< idle, walk, sit
  Eigen::Vector3f goal = Eigen::Vector3f::Zero();  ///< world, metres
  Eigen::Vector2f goal_facing{0, 1};               ///< unit, (x, z)
  std::array<float, kActions> goal_action{};       ///< what to do there
  float phase = 0;  ///< cycles; its fraction is the global phase. Falls only, by less than 0.2,
                    ///< when somebody seated comes to rest
  std::array<Eigen::Vector3f, 2> hand{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};  ///< palms; future: as planned
  std::array<float, 2> hand_phase{};                                                      ///< of reaching a contact

  /// The goal's frame on the floor.
  Place goal_place() const { return {{goal.x(), goal.z()}, goal_facing}; }
};

/// Where head, ankles and palms of somebody who sits or stands about are to be a second from now, world metres: what
/// they do while no hand has a contact. Hands: 0 left, 1 right.
struct AheadPose {
  bool known = false;                                ///< else nothing is told
  Eigen::Vector3f head = Eigen::Vector3f::Zero();    ///< joint 15
  std::array<Eigen::Vector3f, 2> ankle{head, head};  ///< joints 7 and 8
  std::array<Eigen::Vector3f, 2> palm{head, head};   ///< as palm_of
  std::array<bool, 2> free{};  ///< no contact is held or reached for then: the palm's place is told
};

/// What a person does at one moment: the pose, a second of the past and a second of the future as it was predicted
/// last. World, metres, +Y up, floor at y = 0. Copied without allocation.
struct State {
  std::array<Sample, kSamples> samples;                      ///< one a frame; samples[kNow] is the present
  std::array<Eigen::Vector3f, kJoints> position;             ///< metres
  std::array<Eigen::Vector3f, kJoints> velocity;             ///< metres a second
  std::array<Eigen::Matrix3f, kJoints> rotation;             ///< joint to world
  std::array<Eigen::Vector3f, kJoints> position_from_ahead;  ///< the same places as predicted from a second ahead
  std::array<float, kContacts> touching{};                   ///< as OutputLayout::contacts

  /// A hand's contact while it is being reached for or held.
  std::array<Eigen::Vector3f, 2> contact{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
  std::array<bool, 2> wanted{false, false};  ///< whether it has one
  AheadPose ahead;                           ///< what they are about to do where they sit or stand

  /// The present.
  const Sample& now() const { return samples[kNow]; }
  /// The same, to change.
  Sample& now() { return samples[kNow]; }
  /// Key k, 0 to kKeys - 1; kPastKeys is the present.
  const Sample& key(int k) const { return samples[static_cast<size_t>(k) * kKeyStep]; }
  /// The same, to change.
  Sample& key(int k) { return samples[static_cast<size_t>(k) * kKeyStep]; }
};

/// The middle of a palm's skin, which touches: `side` 0 left, 1 right. @param rotation joint to world.
Eigen::Vector3f palm_of(const Eigen::Vector3f& wrist, const Eigen::Matrix3f& rotation, int side);
/// The middle of a palm's skin in the present pose, world metres: `side` 0 left, 1 right.
inline Eigen::Vector3f palm_of(const State& state, int side) {
  const size_t joint = 20 + static_cast<size_t>(side);
  return palm_of(state.position[joint], state.rotation[joint], side);
}

/// Puts a hand's contact (world): from now on it is reached for, as long as `seconds` say: the plan is the straight
/// line, its phase from 0 to 1. The past of its phase is kept.
void give_contact(State& state, int side, const Eigen::Vector3f& point, double seconds = 1);
/// Moves the contact of a hand that has one: its plan goes along, the more the farther on in it.
void move_contact(State& state, int side, const Eigen::Vector3f& point);
/// No contact for this hand.
void drop_contact(State& state, int side);

/// From frame `kNow + after` on the goal of all samples is this. With `after` = kSamples - 1 - kNow it comes nearer
/// frame by frame, as recordings have it.
void set_goal(State& state, const Eigen::Vector3f& goal, const Eigen::Vector2f& facing, int action,
              int after = kSamples - 1 - kNow);

/// A person who has stood still all the time and will: what State is without a past. Velocities are zero.
/// @param position, rotation of the joints, world.
State standing_state(const std::array<Eigen::Vector3f, kJoints>& position,
                     const std::array<Eigen::Matrix3f, kJoints>& rotation);

}  // namespace inhabit::interact
