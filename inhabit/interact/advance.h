#pragma once
#include <array>

#include "inhabit/interact/layout.h"
#include "inhabit/interact/state.h"
#include "inhabit/interact/voxels.h"

namespace inhabit::interact {

/// Weights of PoseNet's corrections of goals, by the goal's action (idle, walk, sit); 0: they stay as they are set.
using GoalWeights = std::array<double, kActions>;

/// Makes PoseNet's output the next frame of a state. Allocates nothing.
/// - The samples of the past, the goals and the planned hands move on by a frame.
/// - The root's future is the ego-centric prediction blended with the goal-centric one, which has the weight
///   ((i - 6) / 7)^(100 d^2) at key i > 6, d metres from that key's root to its goal.
/// - Future goals are blended with the predicted ones, which have `weights`.
/// - Between keys positions and phases are interpolated linearly, directions spherically.
/// - Joint positions are the mean of the predicted ones and of the last ones moved on by the predicted velocity;
///   lengths of bones are left to the caller. Rotations are the predicted axes made orthonormal.
void apply_output(const OutputLayout& layout, const float* output, const GoalWeights& weights, double rate,
                  State& state);

/// ControlNet's output as the planned hands of a state that has just moved on.
/// @param root the root that the output is in the axes of: the state's before it moved on.
void apply_control(const float* control, const Place& root, State& state);

}  // namespace inhabit::interact
