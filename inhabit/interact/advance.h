#pragma once
#include <array>

#include "inhabit/interact/layout.h"
#include "inhabit/interact/state.h"
#include "inhabit/interact/voxels.h"

namespace inhabit::interact {

/// How much of PoseNet's correction goals take, by the goal's action (idle, walk, sit); 0: they stay as they are set.
using GoalShares = std::array<double, kActions>;

/// PoseNet's output made the next frame of a state. Window: the past moves on by a frame; the root's future is the
/// ego-centric prediction blended with the goal-centric one by weight ((i - 6) / 7)^(100 d^2) at key i > 6, d metres
/// from that key's root to its goal; goals move on, the future ones drawn to the prediction by `shares`; between keys
/// positions and phases are linear, directions spherical. Pose: positions are the mean of those predicted and of the
/// last ones moved on by the predicted velocity (bone lengths are the caller's), rotations the predicted axes made
/// orthonormal. Planned hands move on by a frame. Allocates nothing.
void apply_output(const OutputLayout& layout, const float* output, const GoalShares& shares, double rate, State& state);

/// ControlNet's output as the planned hands of a state that has just moved on.
/// @param root the root that the output is in the axes of: the state's before it moved on.
void apply_control(const float* control, const Place& root, State& state);

}  // namespace inhabit::interact
