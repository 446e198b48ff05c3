#pragma once
#include <array>

#include "inhabit/interact/layout.h"
#include "inhabit/interact/state.h"
#include "inhabit/interact/voxels.h"

namespace inhabit::interact {

/// What a person's surroundings are sensed with.
struct Senses {
  const ChairGrid& chair;      ///< the chair that is gone to
  const EgoGrid& ego;          ///< points around the person
  const Surroundings& around;  ///< what those may be inside
};

/// PoseNet's input (input_layout) of a state, not standardised, in the axes of the present root, in training and in
/// use. Allocates nothing.
/// - Hands: one without a contact has zeros.
/// - Gating, at each key, with p = (sin, cos) of the phase and v = 2 w - 1 of an action's weight w: v p of each action,
///   then three pairs of each goal action: v p, d v p and a v p, where d is the distance in metres from the key's root
///   to its goal and a the angle in degrees between their directions.
/// - Ahead: 1 where it is known, then how far the head and both ankles are to move in the next second; then for each
///   hand, right and left, 1 where it is free and how far its palm is to move. Zeros for what is not told.
void build_input(const InputLayout& layout, const State& state, const Senses& senses, float* out);

/// Its first part: the joints in the axes of the present root, 12 numbers each.
void build_joints(const State& state, float* out);

/// PoseNet's output (output_layout) that leads from a state to the one of the next frame.
void build_target(const OutputLayout& layout, const State& now, const State& next, float* out);

/// The contacts as NSM+Control and SAMP+Control see them, 8 numbers: for the left hand, then the right, the point in
/// the axes of the present root, then 1; zeros without one.
void build_contacts(const State& state, float* out);

/// ControlNet's control signal: for each hand, right then left, its palm less its contact at the present key and the
/// future ones, in the axes of a root (2 x 7 x 3); then their phases (2 x 7). Zeros for a hand without a contact.
inline constexpr int kControlSize = 2 * kFuturePoints * 4,  ///< numbers of the control signal
    kControlPose = 3 * kJoints;  ///< numbers of the joint positions that ControlNet sees with it

/// ControlNet's inputs: joint positions in the axes of the present root, and the control signal whose hands are on the
/// straight line to the contact: 6/6, 5/6, ... 0/6 of what is left (Eq. 1).
void build_control_input(const State& state, float* pose, float* control);

/// ControlNet's target: the control signal of the next frame in the axes of the present root.
void build_control_target(const State& now, const State& next, float* control);

/// The chair's grid as ContactNet sees it: position in the axes of the seat (Chair::frame) and value, 4 N^3 numbers.
void contact_condition(const ChairGrid& grid, float* out);

/// Two contacts, right then left, in the axes of the seat; zeros for none.
std::array<float, 6> contacts_in_seat(const ChairGrid& grid, const std::array<Eigen::Vector3f, 2>& contact,
                                      const std::array<bool, 2>& wanted);

}  // namespace inhabit::interact
