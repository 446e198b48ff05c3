#include "inhabit/interact/advance.h"

#include <algorithm>
#include <cmath>

namespace inhabit::interact {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

Vector2f unit_or(const Vector2f& v, const Vector2f& otherwise) {
  const float n = v.norm();
  return n > 1e-6F ? Vector2f(v / n) : otherwise;
}

/// Between two unit vectors, spherically.
Vector2f slerp_direction(const Vector2f& a, const Vector2f& b, float u) {
  const float angle = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)) * u, c = std::cos(angle), s = std::sin(angle);
  return {c * a.x() - s * a.y(), s * a.x() + c * a.y()};
}

std::array<float, kActions> mixed(const std::array<float, kActions>& a, const std::array<float, kActions>& b, float u) {
  std::array<float, kActions> out{};
  for (size_t i = 0; i < kActions; ++i) out[i] = a[i] + u * (b[i] - a[i]);
  return out;
}

/// Samples between two neighbouring keys, from these. Hands and goals move on frame by frame and are left alone.
void fill_between(State& state, int key) {
  const Sample &a = state.key(key), &b = state.key(key + 1);
  for (int i = 1; i < kKeyStep; ++i) {
    const float u = static_cast<float>(i) / kKeyStep;
    Sample& s = state.samples[static_cast<size_t>(key) * kKeyStep + static_cast<size_t>(i)];
    s.root.position = a.root.position + u * (b.root.position - a.root.position);
    s.root.facing = slerp_direction(a.root.facing, b.root.facing, u);
    s.action = mixed(a.action, b.action, u);
    s.phase = a.phase + u * (b.phase - a.phase);
  }
}

std::array<float, kActions> weights_from(const float* in) {
  std::array<float, kActions> out{};
  for (size_t i = 0; i < kActions; ++i) out[i] = std::clamp(in[i], 0.F, 1.F);
  return out;
}

/// Future goals drawn to the predicted ones; the frames between keys take the correction of the key after them.
void correct_goals(const float* in, const GoalWeights& weights, const Place& root, State& state) {
  for (int i = kNow; i < kSamples; ++i) {
    Sample& s = state.samples[static_cast<size_t>(i)];
    const float* g = in + ((i + kKeyStep - 1) / kKeyStep) * (6 + kActions);
    float weight = 0;
    for (size_t a = 0; a < kActions; ++a) weight += s.goal_action[a] * static_cast<float>(weights[a]);
    if (weight <= 0) continue;
    weight = std::min(weight, 1.F);
    s.goal += weight * (root.out({g[0], g[1], g[2]}) - s.goal);
    const Vector2f facing = unit_or(root.turned_out(Vector2f(g[3], g[5])), s.goal_facing);
    s.goal_facing = slerp_direction(s.goal_facing, facing, weight);
    s.goal_action = mixed(s.goal_action, weights_from(g + 6), weight);
  }
}

/// Whether somebody has sat for all of the past second and stays. The phase then rests at a whole number, as in
/// recordings: else the little that the network adds in each frame would make them rise.
bool rests(const State& state, float advance) {
  constexpr size_t kSitting = 2;  // of the actions
  constexpr float kSure = 0.8F, kNearWhole = 0.2F, kSlow = 0.2F;
  for (int i = 0; i < kSamples; ++i) {
    const Sample& s = state.samples[static_cast<size_t>(i)];
    if (s.goal_action[kSitting] < kSure || s.action[kSitting] < kSure) return false;
    if (i < kNow && std::abs(s.phase - std::round(s.phase)) > kNearWhole) return false;
  }
  return advance < kSlow;
}

void apply_trajectory(const OutputLayout& layout, const float* output, const Place& root, State& state) {
  const float* in = output + layout.trajectory.first;
  const float* by_goal = output + layout.goal_root.first;
  const float* update = output + layout.phases.first;
  const float before = state.samples[kNow - 1].phase;
  float latest = before;
  for (int k = kPastKeys; k < kKeys; ++k, in += 4 + kActions, by_goal += 4) {
    Sample& s = state.key(k);
    Place ego{root.position + root.turned_out(Vector2f(in[0], in[1])),
              unit_or(root.turned_out(Vector2f(in[2], in[3])), root.facing)};
    if (k > kPastKeys) {
      const Place goal = s.goal_place();
      const Vector2f place = goal.position + goal.turned_out(Vector2f(by_goal[0], by_goal[1]));
      const Vector2f facing = unit_or(goal.turned_out(Vector2f(by_goal[2], by_goal[3])), ego.facing);
      const float apart = (ego.position - goal.position).norm();
      const float weight = std::pow(static_cast<float>(k - kPastKeys) / (kFutureKeys + 1), 100 * apart * apart);
      ego.position += weight * (place - ego.position);
      ego.facing = slerp_direction(ego.facing, facing, weight);
    }
    s.root = ego;
    s.action = weights_from(in + 4);
    latest = s.phase = std::max(latest, before + update[k - kPastKeys]);  // time does not run backwards
  }
  if (rests(state, latest - before))
    for (int k = kPastKeys; k < kKeys; ++k) state.key(k).phase = std::round(before);
  for (int k = kPastKeys; k + 1 < kKeys; ++k) fill_between(state, k);
}

/// Phases count cycles: whole ones are taken off now and then, so that floats stay exact.
void rebase_phases(State& state) {
  const float whole = std::floor(state.samples.front().phase);
  if (whole < 16) return;
  for (Sample& s : state.samples) s.phase -= whole;
}

void apply_pose(const OutputLayout& layout, const float* output, const Place& root, const Place& future, double rate,
                State& state) {
  const float* in = output + layout.joints.first;
  const float* ahead = output + layout.future_joints.first;
  const auto dt = static_cast<float>(1 / rate);
  for (size_t j = 0; j < kJoints; ++j, in += 12, ahead += 3) {
    const Vector3f predicted = root.out({in[0], in[1], in[2]});
    state.velocity[j] = root.turned_out(Vector3f(in[9], in[10], in[11]));
    state.position[j] = 0.5F * (predicted + state.position[j] + dt * state.velocity[j]);
    const Vector3f z = root.turned_out(Vector3f(in[3], in[4], in[5])),
                   y = root.turned_out(Vector3f(in[6], in[7], in[8]));
    const Vector3f x = y.cross(z);
    if (z.norm() > 1e-6F && x.norm() > 1e-6F) {
      state.rotation[j].col(2) = z.normalized();
      state.rotation[j].col(0) = x.normalized();
      state.rotation[j].col(1) = state.rotation[j].col(2).cross(state.rotation[j].col(0));
    }
    state.position_from_ahead[j] = future.out({ahead[0], ahead[1], ahead[2]});
  }
}
}  // namespace

void apply_output(const OutputLayout& layout, const float* output, const GoalWeights& weights, double rate,
                  State& state) {
  const Place root = state.now().root;
  std::copy(state.samples.begin() + 1, state.samples.end(), state.samples.begin());
  correct_goals(output + layout.goals.first, weights, root, state);
  apply_trajectory(layout, output, root, state);
  rebase_phases(state);
  apply_pose(layout, output, root, state.samples.back().root, rate, state);
  for (size_t i = 0; i < kContacts; ++i) state.touching[i] = output[layout.contacts.first + static_cast<int64_t>(i)];
  for (int side = 0; side < 2; ++side) state.now().hand[static_cast<size_t>(side)] = palm_of(state, side);
}

void apply_control(const float* control, const Place& root, State& state) {
  const float* phases = control + 6 * kFuturePoints;
  for (size_t i = 0; i < 2; ++i) {
    const size_t hand = kHandOrder[i];
    if (!state.wanted[hand]) continue;
    const auto point = [&](int k) {
      const float* p = control + (i * kFuturePoints + static_cast<size_t>(k)) * 3;
      return Vector3f(state.contact[hand] + root.turned_out(Vector3f(p[0], p[1], p[2])));
    };
    const auto phase = [&](int k) { return std::clamp(phases[i * kFuturePoints + static_cast<size_t>(k)], 0.F, 1.F); };
    state.now().hand_phase[hand] = phase(0);  // where the hand is, the pose says
    for (int f = kNow + 1; f < kSamples; ++f) {
      const int k = std::min((f - kNow) / kKeyStep, kFutureKeys - 1);
      const float u = static_cast<float>(f - kNow - k * kKeyStep) / kKeyStep;
      Sample& s = state.samples[static_cast<size_t>(f)];
      s.hand[hand] = point(k) + u * (point(k + 1) - point(k));
      s.hand_phase[hand] = phase(k) + u * (phase(k + 1) - phase(k));
    }
  }
}
}  // namespace inhabit::interact
