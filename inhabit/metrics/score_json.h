#pragma once
#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "inhabit/metrics/score_clips.h"

namespace inhabit {

// Scores as JSON, under the names that `inhabit score --json` writes and Python's dictionaries have.

/// What is scored; each has JSON of its own.
enum class ScoreKind { fid, skating, jerk, penetration, diversity, ndms, npss, apd, error };
/// The first name in the JSON of each ScoreKind, in its order: what tells scores from other JSON.
inline constexpr std::array<const char*, 9> kScoreNames = {
    "fid", "foot_skating", "jerk", "collision_frame_ratio", "diversity", "ndms", "npss", "apd_m", "world_error_mm"};

/// The beginning of all JSON of scores: the kind's name and its number; others are put behind it.
nlohmann::ordered_json begin_scores(ScoreKind kind, double value);

/// A row for each motion: its file and what `row(i)` says.
template <class Row>
nlohmann::ordered_json rows_by_file(const std::vector<ScoredClip>& clips, const Row& row) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (size_t i = 0; i < clips.size(); ++i) {
    nlohmann::ordered_json one = {{"file", clips[i].name}};
    one.update(row(i));
    out.push_back(one);
  }
  return out;
}

/// What `by_frame` (T) is at 0.4, 0.8, 1.6, 2, 4, 10, 20 and 30 s, as far as it goes: objects of "seconds" and "value".
/// @param rate frames a second; the first frame is one step after the start. @param scale values are multiplied by it
nlohmann::ordered_json at_horizons(const torch::Tensor& by_frame, double rate, double scale = 1);

/// @param clips that were scored
nlohmann::ordered_json score_json(const SkatingScore& score, const std::vector<ScoredClip>& clips);
/// @param reference of real motion, for the ratio of the jerk to its; null: none
nlohmann::ordered_json score_json(const JerkScore& score, const std::vector<ScoredClip>& clips,
                                  const JerkScore* reference = nullptr);
/// Depths in millimetres.
nlohmann::ordered_json score_json(const PenetrationScore& score, const std::vector<ScoredClip>& clips);
/// @param clips that were scored
nlohmann::ordered_json score_json(const NdmsScore& score, const std::vector<ScoredClip>& clips);
/// Millimetres. @param futures how many. @param rate frames a second that they were scored at
nlohmann::ordered_json score_json(const MotionError& error, size_t futures, double rate);

}  // namespace inhabit
