#pragma once
#include <string>
#include <vector>

#include "inhabit/motion/clip.h"

namespace inhabit {

/// A recording as its file tells it, in metres: the source's own skeleton, and where things stood (no floor is
/// assumed).
struct SourceMotion {
  Clip clip;                       ///< metres, on the file's skeleton, at its rate
  double metres_per_unit = 1;      ///< the factor that was applied to the file's lengths
  std::string unit = "metres";     ///< name of the file's unit
  bool y_up = false;               ///< by definition of its format: nothing to be detected
  bool slopes = false;             ///< the world is that of the first pose's pelvis, which need not be upright
  bool rate_assumed = false;       ///< the file does not say its rate: that of its format was taken
  std::vector<std::string> notes;  ///< what was guessed or left out, one clause each, for `inhabit info`
};

/// A length unit guessed from the size of a person.
struct LengthUnit {
  double metres = 1;  ///< in one of it
  std::string name;   ///< for people: "centimetres"
};

/// The unit in which `reach`, the longest chain of bones from the root to a leaf, is that of a person (0.5 to 2.6 m; an
/// adult has about 1.3 m): metres, centimetres, millimetres, inches or CMU's ASF units (0.0564444 m).
/// Throws Error(subject, ...) where none fits and says to give the scale.
LengthUnit guess_length_unit(double reach, const std::string& subject);

/// The longest chain of bones from joint `from` to a leaf, in the skeleton's own unit. What lies above that joint does
/// not count: a root that stands for the world may be any distance away.
double longest_reach(const Skeleton& skeleton, int from = 0);

}  // namespace inhabit
