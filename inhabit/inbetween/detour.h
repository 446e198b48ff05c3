#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/data/measured_parts.h"
#include "inhabit/inbetween/blocked_rooms.h"
#include "inhabit/inbetween/methods.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/progress.h"

namespace inhabit::inbetween {

/// Who goes around what blocks the straight line between two keys (blocked_rooms.h). A run succeeds if in no frame a
/// vertex of the skin is inside the scene by more than `tolerance`, and the joints of both keys are within `key_error`
/// of where the key poses have them, in the mean.
struct DetourEvaluation {
  int64_t seeds = 10;        ///< runs of what depends on a seed, in each room
  uint64_t seed = 1;         ///< what methods draw in each room and run follows from it, and the bootstrap
  double tolerance = 0.02;   ///< metres that skin may be inside the scene
  double key_error = 0.02;   ///< metres, of the mean distance of a key's 22 joints
  bool parallel = true;      ///< methods are called on all of LibTorch's threads
  Progress progress;         ///< called after each run, once at a time
  MeasuredParts parts = {};  ///< of the rooms: nothing is returned where others are still to come
};

/// What a method does in the rooms.
struct DetourScores {
  std::string method;             ///< its name, as Method has it
  int64_t runs = 1;               ///< in each room
  std::vector<double> succeeded;  ///< of each room, the fraction of its runs that succeed

  /// A room is solved if at least 8 of 10 of its runs succeed.
  static bool solved(double fraction) { return fraction >= 0.8 - 1e-9; }
};

/// @param rooms in pairs, as blocked_rooms has them. Throws Error where they are not.
std::vector<DetourScores> evaluate_detour(const std::vector<BlockedRoom>& rooms, const std::vector<Method>& methods,
                                          const DetourEvaluation& options);

/// Means of success and fractions of rooms and of pairs that are solved, each with its 95 % interval by bootstrap over
/// pairs of rooms, then the mean for each kind.
ScoreTable score_table(const std::vector<DetourScores>& scores, const std::vector<BlockedRoom>& rooms,
                       const DetourEvaluation& options);

}  // namespace inhabit::inbetween
