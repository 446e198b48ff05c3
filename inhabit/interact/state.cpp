#include "inhabit/interact/state.h"

#include <algorithm>
#include <cmath>

#include "inhabit/body/palm.h"

namespace inhabit::interact {

using Eigen::Vector2f;
using Eigen::Vector3f;

Vector3f palm_of(const Vector3f& wrist, const Eigen::Matrix3f& rotation, int side) {
  return wrist + rotation * palm_offset(side);
}

void give_contact(State& state, int side, const Vector3f& point, double seconds) {
  const auto s = static_cast<size_t>(side);
  state.contact[s] = point;
  state.wanted[s] = true;
  const Vector3f from = state.now().hand[s];
  const auto frames = static_cast<float>(std::max(1.0, 30 * seconds));
  for (int i = kNow; i < kSamples; ++i) {
    const float part = std::min(1.F, static_cast<float>(i - kNow) / frames);
    Sample& sample = state.samples[static_cast<size_t>(i)];
    sample.hand[s] = from + part * (point - from);
    sample.hand_phase[s] = part;
  }
}

void move_contact(State& state, int side, const Vector3f& point) {
  const auto s = static_cast<size_t>(side);
  const Vector3f by = point - state.contact[s];
  state.contact[s] = point;
  for (int i = kNow + 1; i < kSamples; ++i) {
    Sample& sample = state.samples[static_cast<size_t>(i)];
    sample.hand[s] += sample.hand_phase[s] * by;
  }
}

void drop_contact(State& state, int side) {
  const auto s = static_cast<size_t>(side);
  state.wanted[s] = false;
  for (int i = kNow; i < kSamples; ++i) {
    Sample& sample = state.samples[static_cast<size_t>(i)];
    sample.hand[s] = state.now().hand[s];
    sample.hand_phase[s] = 0;
  }
}

void set_goal(State& state, const Vector3f& goal, const Vector2f& facing, int action, int after) {
  for (int i = std::clamp(kNow + after, 0, kSamples - 1); i < kSamples; ++i) {
    Sample& sample = state.samples[static_cast<size_t>(i)];
    sample.goal = goal;
    sample.goal_facing = facing;
    sample.goal_action = {};
    sample.goal_action[static_cast<size_t>(action)] = 1;
  }
}

State standing_state(const std::array<Vector3f, kJoints>& position,
                     const std::array<Eigen::Matrix3f, kJoints>& rotation) {
  State state;
  state.position = state.position_from_ahead = position;
  state.rotation = rotation;
  state.velocity.fill(Vector3f::Zero());
  Sample still;
  // From the right to the left, of hips and shoulders, as motion/canonical.h has it.
  const Vector3f left = position[1] - position[2] + position[16] - position[17];
  const Vector2f ahead(-left.z(), left.x());
  still.root = {{position[0].x(), position[0].z()},
                ahead.norm() > 1e-6F ? Vector2f(ahead.normalized()) : Vector2f(0, 1)};
  still.action[0] = still.goal_action[0] = 1;
  still.goal = still.root.origin();
  still.goal_facing = still.root.facing;
  for (int side = 0; side < 2; ++side) still.hand[static_cast<size_t>(side)] = palm_of(state, side);
  state.samples.fill(still);
  return state;
}

}  // namespace inhabit::interact
