#pragma once
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace inhabit {

// Order statistics: one of the values themselves, never a mean of two. There must be values, and none may be NaN.

/// The value that would stand at `index` (from 0) if they were sorted.
template <class T>
T nth_smallest(std::vector<T> values, size_t index) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(index);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The one in the middle, of an even number the upper of the two: the one at count / 2.
template <class T>
T median(std::vector<T> values) {
  const size_t index = values.size() / 2;
  return nth_smallest(std::move(values), index);
}

/// The value that a part of the others is below, rounded down: the one at fraction (count - 1). Half of an even number
/// is therefore the lower of the middle two, where median() is the upper. @param fraction 0 to 1
template <class T>
T quantile(std::vector<T> values, double fraction) {
  const auto index = static_cast<size_t>(fraction * static_cast<double>(values.size() - 1));
  return nth_smallest(std::move(values), index);
}

}  // namespace inhabit
