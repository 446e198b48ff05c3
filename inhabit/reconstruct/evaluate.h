#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "inhabit/metrics/score_table.h"
#include "inhabit/reconstruct/rendered.h"

namespace inhabit::reconstruct {

/// How far one reconstruction is from the truth.
struct Errors {
  double scale = 0;                                       ///< of depth: part of the true one
  double depth = 0;                                       ///< metres, mean over the person's depths that occur
  double root_before = 0, root_keys = 0, root_after = 0;  ///< metres, mean: estimate, key frames moved, result
  double joints_before = 0, joints_after = 0;             ///< metres, mean
  double skating_before = 0, skating_after = 0;           ///< part of the frames
  double jerk_before = 0, jerk_after = 0, jerk_true = 0;  ///< m/s^3
  struct Object {
    std::string name;
    double place = 0, yaw = 0, scale = 0;  ///< metres of the middle; degrees; part of the true one
  };
  std::vector<Object> objects;
};

/// Compares a result with what was rendered. Turns that an object looks the same after (180 or 90 degrees) count as
/// none.
Errors errors_of(const Rendered& rendered, const Result& result);

struct Evaluation {
  int64_t rooms = 10;
  uint64_t seed = 1;
  double seconds = 6;
  bool objects = true;
  RenderOptions render;
  Options options;
  std::string keep;  ///< folder that the first room's inputs are written to; empty: none
  std::function<void(int64_t done, int64_t all)> progress;  ///< rooms; may be empty
};

/// A room and somebody's life in it, made as data sets of rooms are, and rendered. @param index of the room
Rendered rendered_room(const Evaluation& evaluation, int64_t index);

/// Reconstructs rendered rooms and returns their errors, one a room.
std::vector<Errors> evaluate(const inbetween::SceneInbetweener& inbetweener, const Evaluation& evaluation);

/// A row for each room and their mean, and in the notes the objects' errors.
ScoreTable table_of(const std::vector<Errors>& rooms);

}  // namespace inhabit::reconstruct
