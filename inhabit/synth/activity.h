#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "inhabit/data/native.h"
#include "inhabit/metrics/dynamics.h"
#include "inhabit/metrics/score_table.h"

namespace inhabit {

/// What a body is doing, told from its motion alone, so that recordings and generated clips are told apart alike.
enum class Activity { still, stand, gesture, turn, walk, run, sit, sit_down, stand_up, other };
/// What tables call each Activity, in its order.
inline constexpr std::array<const char*, 10> kActivityNames = {
    "standing still", "standing", "gesturing, reaching", "turning",    "walking",
    "running",        "sitting",  "sitting down",        "getting up", "other"};

/// (T) int64 of Activity, from the joints of the standard skeleton on a floor at y = 0: by the pelvis's height against
/// the legs' length and how fast it sinks or rises, the root's speed over the ground (0.35 and 2 m/s), the rate of its
/// heading (0.6 rad/s) and the wrists' speed against the root (0.3 m/s, still under 0.08 m/s), each over half a second.
torch::Tensor activities(const Clip& clip);

/// The clip's joints (positions alone) low-passed in time by a Gaussian that halves the power at `cutoff` Hz.
torch::Tensor low_passed(const Clip& clip, double cutoff);

/// Means over the frames of an activity, as recorded and after the low-pass.
struct ActivityDynamics {
  Dynamics raw;     ///< as recorded
  Dynamics smooth;  ///< after the low-pass
};

/// By Activity, over all clips of `split`.
std::array<ActivityDynamics, kActivityNames.size()> dynamics_by_activity(const Dataset& dataset,
                                                                         const std::string& split, double cutoff);

/// As a table, a row for each Activity that has frames: frames, speed, acceleration and jerk, and the last two after
/// the low-pass.
ScoreTable activity_table(const std::array<ActivityDynamics, kActivityNames.size()>& by_activity);

}  // namespace inhabit
