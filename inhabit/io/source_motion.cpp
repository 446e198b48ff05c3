#include "inhabit/io/source_motion.h"

#include <cmath>
#include <cstdio>

#include "inhabit/error.h"

namespace inhabit {

LengthUnit guess_length_unit(double reach, const std::string& subject) {
  static const LengthUnit units[] = {
      {1, "metres"}, {0.01, "centimetres"}, {0.001, "millimetres"}, {0.0254, "inches"}, {0.0254 / 0.45, "ASF units"}};
  const LengthUnit* best = nullptr;
  double best_ratio = 0;
  for (const LengthUnit& unit : units) {
    const double metres = reach * unit.metres;
    const double ratio = std::abs(std::log(metres / 1.3));
    if (metres >= 0.5 && metres <= 2.6 && (best == nullptr || ratio < best_ratio)) best = &unit, best_ratio = ratio;
  }
  if (best == nullptr) {
    char text[160];
    std::snprintf(
        text, sizeof text,
        "the longest chain of bones is %.4g units, in no known unit that of a person; give the scale in metres "
        "per unit (--scale)",
        reach);
    throw Error(subject, text);
  }
  return *best;
}

double longest_reach(const Skeleton& skeleton, int from) {
  const torch::Tensor offsets = skeleton.offsets.to(torch::kDouble).contiguous();
  const auto o = offsets.accessor<double, 2>();
  std::vector<double> reach(static_cast<size_t>(skeleton.size()), -1.0);  // below 0: not below `from`
  reach[static_cast<size_t>(from)] = 0;
  double longest = 0;
  for (int j = from + 1; j < skeleton.size(); ++j) {
    const double start = reach[static_cast<size_t>(skeleton.parents[static_cast<size_t>(j)])];
    if (start < 0) continue;
    reach[static_cast<size_t>(j)] = start + std::hypot(o[j][0], o[j][1], o[j][2]);
    longest = std::max(longest, reach[static_cast<size_t>(j)]);
  }
  return longest;
}

}  // namespace inhabit
