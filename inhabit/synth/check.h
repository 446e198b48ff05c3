#pragma once
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "inhabit/data/native.h"
#include "inhabit/progress.h"

namespace inhabit {

/// One measure of a data set's motion and the range it must lie in.
struct Bar {
  std::string name;        ///< for people: "speed while walking"
  std::string unit;        ///< of all its numbers
  double low = 0;          ///< the value passes in [low, high]
  double high = 0;         ///< likewise
  double value = 0;        ///< over the whole data set
  int64_t clips = 0;       ///< clips that it could be measured on
  std::string worst_clip;  ///< file of the clip farthest out
  double worst = 0;        ///< its value
  std::string where;       ///< the place in that clip, where there is one: "left_knee in table_0, frame 84"

  /// True too where it could be measured on no clip.
  bool pass() const { return clips == 0 || (value >= low && value <= high); }
};

/// The bars of generated motion over clips of `dataset` (of one split, or "all"): fraction of skating frames, speed,
/// joint acceleration and jerk while walking (means over frames), and, as the worst of all clips, joint limits, depth
/// in walls and furniture, distance of labelled hand contacts from the surface (of the point, and of the hand's skin).
/// @param progress told how many clips are measured; may be empty
std::vector<Bar> check_motion(const Dataset& dataset, const std::string& split = "all", const Progress& progress = {});

/// The bars as text, a line each below a title: range, value, whether it passes, and the clip farthest out. No
/// ScoreTable, as every line has a unit, and so digits, of its own and ends in words.
std::string bars_text(const std::vector<Bar>& bars);

/// The bars as a list of JSON objects.
nlohmann::json bars_json(const std::vector<Bar>& bars);

}  // namespace inhabit
