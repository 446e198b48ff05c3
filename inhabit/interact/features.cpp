#include "inhabit/interact/features.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace inhabit::interact {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

/// Writes one number or vector after the other.
struct FeatureWriter {
  float* next;
  void operator()(float value) { *next++ = value; }
  template <class Derived>
  void operator()(const Eigen::MatrixBase<Derived>& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i) *next++ = v[i];
  }
  void operator()(const std::array<float, kActions>& v) { next = std::copy(v.begin(), v.end(), next); }
};

void write_pose(const State& pose, const Place& root, float* out) {
  FeatureWriter write{out};
  for (size_t j = 0; j < kJoints; ++j) {
    write(root.in(pose.position[j]));
    write(root.turned_in(Vector3f(pose.rotation[j].col(2))));
    write(root.turned_in(Vector3f(pose.rotation[j].col(1))));
    write(root.turned_in(pose.velocity[j]));
  }
}

void write_trajectory(const State& state, const Place& root, int first_key, float* out) {
  FeatureWriter write{out};
  for (int k = first_key; k < kKeys; ++k) {
    const Sample& s = state.key(k);
    write(root.turned_in(Vector2f(s.root.position - root.position)));
    write(root.turned_in(s.root.facing));
    write(s.action);
  }
}

void write_goals(const State& state, const Place& root, float* out) {
  FeatureWriter write{out};
  for (int k = 0; k < kKeys; ++k) {
    const Sample& s = state.key(k);
    const Vector2f facing = root.turned_in(s.goal_facing);
    write(root.in(s.goal));
    write(Vector3f(facing.x(), 0, facing.y()));
    write(s.goal_action);
  }
}

/// Hands of keys from `first_key` on; zeros for one without a contact.
void write_hands(const State& state, const State& contacts, const Place& root, int first_key, float* out) {
  FeatureWriter write{out};
  for (const size_t hand : kHandOrder)
    for (int k = first_key; k < kKeys; ++k)
      write(contacts.wanted[hand] ? root.turned_in(Vector3f(state.key(k).hand[hand] - contacts.contact[hand]))
                                  : Vector3f(Vector3f::Zero()));
}

void write_ahead(const State& state, const Place& root, float* out) {
  const AheadPose& ahead = state.ahead;
  std::fill(out, out + kAheadSize, 0.F);
  if (!ahead.known) return;
  FeatureWriter write{out};
  write(1.F);
  write(root.turned_in(Vector3f(ahead.head - state.position[15])));
  for (size_t side = 0; side < 2; ++side) write(root.turned_in(Vector3f(ahead.ankle[side] - state.position[7 + side])));
  for (const size_t hand : kHandOrder) {
    write(ahead.free[hand] ? 1.F : 0.F);
    write(ahead.free[hand] ? root.turned_in(Vector3f(ahead.palm[hand] - state.now().hand[hand]))
                           : Vector3f(Vector3f::Zero()));
  }
}

Vector2f phase_vector(float phase) {
  const double angle = 2 * std::numbers::pi * static_cast<double>(phase - std::floor(phase));
  return {static_cast<float>(std::sin(angle)), static_cast<float>(std::cos(angle))};
}

void write_gating(const State& state, float* out) {
  FeatureWriter write{out};
  for (int k = 0; k < kKeys; ++k) {
    const Sample& s = state.key(k);
    const Vector2f phase = phase_vector(s.phase);
    const float apart = (s.root.position - Vector2f(s.goal.x(), s.goal.z())).norm();
    const float angle =
        std::acos(std::clamp(s.root.facing.dot(s.goal_facing), -1.F, 1.F)) * 180 / std::numbers::pi_v<float>;
    for (const float weight : s.action) write((2 * weight - 1) * phase);
    for (const float weight : s.goal_action)
      for (const float by : {1.F, apart, angle}) write((2 * weight - 1) * by * phase);
  }
}

}  // namespace

void build_joints(const State& state, float* out) { write_pose(state, state.now().root, out); }

void build_input(const InputLayout& layout, const State& state, const Senses& senses, float* out) {
  const Place root = state.now().root;
  build_joints(state, out + layout.joints.first);
  write_trajectory(state, root, 0, out + layout.trajectory.first);
  write_goals(state, root, out + layout.goals.first);
  senses.ego.sense(senses.around, root, out + layout.ego.first);
  chair_around(senses.chair, root, out + layout.chair.first);
  write_hands(state, state, root, 0, out + layout.hands.first);
  FeatureWriter phases{out + layout.hand_phases.first};
  for (int k = 0; k < kKeys; ++k)
    for (const size_t hand : kHandOrder) phases(state.wanted[hand] ? state.key(k).hand_phase[hand] : 0.F);
  if (layout.ahead.size > 0) write_ahead(state, root, out + layout.ahead.first);
  write_gating(state, out + layout.gating.first);
}

void build_target(const OutputLayout& layout, const State& now, const State& next, float* out) {
  const Place root = now.now().root, future = next.samples.back().root;
  write_pose(next, root, out + layout.joints.first);
  FeatureWriter ahead{out + layout.future_joints.first};
  for (const Vector3f& p : next.position) ahead(future.in(p));
  write_trajectory(next, root, kPastKeys, out + layout.trajectory.first);
  FeatureWriter by_goal{out + layout.goal_root.first}, phases{out + layout.phases.first};
  for (int k = kPastKeys; k < kKeys; ++k) {
    const Sample& s = next.key(k);
    const Place goal = s.goal_place();
    by_goal(goal.turned_in(Vector2f(s.root.position - goal.position)));
    by_goal(goal.turned_in(s.root.facing));
    phases(s.phase - now.now().phase);
  }
  write_goals(next, root, out + layout.goals.first);
  std::copy(next.touching.begin(), next.touching.end(), out + layout.contacts.first);
}

void build_contacts(const State& state, float* out) {
  std::fill(out, out + 8, 0.F);
  for (size_t hand = 0; hand < 2; ++hand, out += 4) {
    if (!state.wanted[hand]) continue;
    Eigen::Map<Vector3f>(out, 3) = state.now().root.in(state.contact[hand]);
    out[3] = 1;
  }
}

void build_control_input(const State& state, float* pose, float* control) {
  const Place root = state.now().root;
  FeatureWriter joints{pose}, write{control};
  for (const Vector3f& p : state.position) joints(root.in(p));
  for (const size_t hand : kHandOrder) {
    const Vector3f left = root.turned_in(Vector3f(state.now().hand[hand] - state.contact[hand]));
    for (int k = kFutureKeys; k >= 0; --k)
      write(state.wanted[hand] ? Vector3f(left * static_cast<float>(k) / kFutureKeys) : Vector3f(Vector3f::Zero()));
  }
  for (const size_t hand : kHandOrder)
    for (int k = kPastKeys; k < kKeys; ++k) write(state.wanted[hand] ? state.key(k).hand_phase[hand] : 0.F);
}

void build_control_target(const State& now, const State& next, float* control) {
  write_hands(next, now, now.now().root, kPastKeys, control);
  FeatureWriter write{control + 6 * kFuturePoints};
  for (const size_t hand : kHandOrder)
    for (int k = kPastKeys; k < kKeys; ++k) write(now.wanted[hand] ? next.key(k).hand_phase[hand] : 0.F);
}

void contact_condition(const ChairGrid& grid, float* out) { chair_around(grid, grid.seat, out); }

std::array<float, 6> contacts_in_seat(const ChairGrid& grid, const std::array<Vector3f, 2>& contact,
                                      const std::array<bool, 2>& wanted) {
  std::array<float, 6> out{};
  for (size_t i = 0; i < 2; ++i)
    if (wanted[kHandOrder[i]]) Eigen::Map<Vector3f>(out.data() + 3 * i) = grid.seat.in(contact[kHandOrder[i]]);
  return out;
}

}  // namespace inhabit::interact
