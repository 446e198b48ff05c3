#pragma once
#include <random>
#include <utility>
#include <vector>

#include "inhabit/interact/layout.h"

namespace inhabit::interact {

/// What training changes in the occupancies that a person senses, the same in all frames of a rollout, so that
/// furniture of other shapes than the data's is sat on too: cells that are emptied or filled, and whole layers of the
/// chair's grid below its seat.
class SenseNoise {
 public:
  /// Draws changes, with this probability; else none.
  SenseNoise(const InputLayout& layout, const Config& config, double probability, std::mt19937_64& random);
  /// @param row of PoseNet's input (4344), not standardised.
  void apply(float* row) const;

 private:
  std::vector<std::pair<int64_t, float>> numbers_;  // place in the row, value
};

}  // namespace inhabit::interact
