#pragma once
#include "inhabit/inbetween/scene_inbetweener.h"

namespace inhabit::inbetween {

/// Somebody stands before a table and, when the clip ends, behind it: the straight path is blocked.
struct Detour {
  Clip ends;   ///< the first and the last frame count
  Scene room;  ///< floor and table
};
Detour table_detour(int64_t frames, double rate);

/// Whether the root comes over the table of table_detour in any frame.
bool crosses_table(const Clip& clip);

/// In how many of `runs` a model's person goes around.
struct DetourScores {
  int64_t runs = 0;
  int64_t around = 0;         ///< with the room shown to the model
  int64_t around_unseen = 0;  ///< without: the table is there, but hidden from the model
};

/// Fills table_detour for `runs` seeds from request.seed on; request.keys are set to its ends.
DetourScores evaluate_detour(const SceneInbetweener& model, Options request, int64_t runs);

}  // namespace inhabit::inbetween
