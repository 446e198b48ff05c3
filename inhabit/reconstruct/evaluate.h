#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "inhabit/data/measured_parts.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/progress.h"
#include "inhabit/reconstruct/rendered.h"

namespace inhabit::reconstruct {

/// How far one reconstruction is from the truth.
struct Errors {
  double scale = 0;           ///< of depth: found over true one, less 1
  double depth = 0;           ///< metres, mean over the person's depths that occur
  double root_before = 0;     ///< metres, mean distance of the root from the true one, in the estimate
  double root_keys = 0;       ///< metres, the same of the key frames that were moved
  double root_after = 0;      ///< metres, the same of the result
  double joints_before = 0;   ///< metres, mean distance of the joints from the true ones, in the estimate
  double joints_after = 0;    ///< metres, the same of the result
  double skating_before = 0;  ///< part of the frames in which a foot slides (metrics/foot_skating.h), of the estimate
  double skating_after = 0;   ///< the same of the result
  double jerk_before = 0;     ///< m/s^3, mean over joints and frames, of the estimate
  double jerk_after = 0;      ///< m/s^3, of the result
  double jerk_true = 0;       ///< m/s^3, of the true motion
  /// How far an object is from where it truly is.
  struct Object {
    std::string name;  ///< as ObjectInput has it
    double place = 0;  ///< metres, distance of the middle of its bounding box
    double yaw = 0;    ///< degrees, error of its rotation about the vertical, 0 or more
    double scale = 0;  ///< found over true one, less 1
  };
  std::vector<Object> objects;  ///< one for each of Result::objects
};

/// Compares a result with what was rendered. Rotations that an object looks the same after (180 or 90 degrees) count as
/// none.
Errors errors_of(const Rendered& rendered, const Result& result);

/// Which rooms are rendered, and how they are reconstructed.
struct Evaluation {
  int64_t rooms = 10;        ///< how many
  uint64_t seed = 1;         ///< what rooms, motions and images follow from
  double seconds = 6;        ///< of motion in each room
  bool objects = true;       ///< furniture is given as objects that are to be placed; else it is depth alone
  RenderOptions render;      ///< size of the images, and what is wrong with them
  Options options;           ///< of run()
  std::string keep;          ///< folder that the first room's inputs are written to; empty: none
  Progress progress;         ///< rooms; may be empty
  MeasuredParts parts = {};  ///< of the rooms
};

/// A room and somebody's life in it, made as data sets of rooms are, and rendered. @param index of the room
Rendered rendered_room(const Evaluation& evaluation, int64_t index);

/// Reconstructs rendered rooms and returns their errors, one a room; none where other parts are still to come.
std::vector<Errors> evaluate(const inbetween::SceneInbetweener& inbetweener, const Evaluation& evaluation);

/// A row for each room and their mean, and in the notes the objects' errors.
ScoreTable table_of(const std::vector<Errors>& rooms);

}  // namespace inhabit::reconstruct
