#pragma once
#include <nlohmann/json.hpp>
#include <vector>

#include "inhabit/metrics/score_clips.h"

namespace inhabit {

// Scores as JSON, under the names that `inhabit score --json` writes and Python's dictionaries have.

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

/// @param clips that were scored
nlohmann::ordered_json score_json(const SkatingScore& score, const std::vector<ScoredClip>& clips);
/// @param reference of real motion, for the ratio of the jerk to its; null: none
nlohmann::ordered_json score_json(const JerkScore& score, const std::vector<ScoredClip>& clips,
                                  const JerkScore* reference = nullptr);
/// Depths in millimetres.
nlohmann::ordered_json score_json(const PenetrationScore& score, const std::vector<ScoredClip>& clips);

}  // namespace inhabit
