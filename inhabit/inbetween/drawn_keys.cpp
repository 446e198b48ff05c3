#include "inhabit/inbetween/drawn_keys.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "inhabit/inbetween/keyframes.h"
#include "inhabit/math/random.h"

namespace inhabit::inbetween {

using torch::Tensor;

namespace {

constexpr double kOpenEnds = 0.25;    // fraction of windows whose last frame is not a key
constexpr double kPartialKeys = 0.3;  // fraction of windows with partial keys
constexpr double kAllPartial = 0.3;   // of these, fraction in which all keys but the ends are partial
constexpr double kContinued = 0.3;    // fraction of windows that begin with known frames, as those of long clips do
constexpr int kLeastKnown = 8, kMostKnown = 100;  // frames of these
constexpr int kLeastFar = 30, kMostFar = 120;     // frames from one key to the next where they are far apart

/// Keeps `count` items, drawn at random.
void shuffle_first(std::vector<int>& items, size_t count, std::mt19937_64& random) {
  count = std::min(count, items.size());
  const int last = static_cast<int>(items.size()) - 1;
  for (size_t i = 0; i < count; ++i)
    std::swap(items[i], items[static_cast<size_t>(uniform_int(random, static_cast<int>(i), last))]);
  items.resize(count);
}

}  // namespace

DrawnKeys draw_keys(int64_t frames, bool partial, double far, std::mt19937_64& random) {
  const auto count = static_cast<double>(frames);
  const double n =
      chance(random, 0.5) ? uniform(random, 2, count + 1) : std::exp(uniform(random, std::log(2.), std::log(count)));
  const int last = chance(random, kOpenEnds)
                       ? uniform_int(random, static_cast<int>(frames / 8), static_cast<int>(frames) - 2)
                       : static_cast<int>(frames) - 1;
  DrawnKeys out{torch::zeros({frames, kKeyGroups}), torch::zeros({frames})};
  for (const int end : {0, last}) {
    out.groups[end].fill_(1);
    out.ends[end].fill_(1);
  }
  // The same joints in all partial keys of a window, as for a drawn hand path.
  const bool some_partial = partial && chance(random, kPartialKeys);
  const double partial_fraction = chance(random, kAllPartial) ? 1 : uniform(random, 0, 1);
  Tensor constrained = torch::zeros({kKeyGroups});
  if (some_partial) {
    const int joints = uniform_int(random, 0, 4);
    for (int j = 0; j < joints; ++j) constrained[kJointGroups + uniform_int(random, 0, kStandardJoints - 1)] = 1;
    if (joints == 0 || chance(random, 0.5)) constrained[kJointGroups] = 1;  // the pelvis
    constrained[kRootTranslationGroup] = constrained[kJointGroups];
  }
  std::vector<int> inner;
  if (chance(random, far)) {
    const int apart = uniform_int(random, kLeastFar, kMostFar);
    for (int key = apart; key < last; key += apart) inner.push_back(key);
  } else {
    inner.resize(static_cast<size_t>(std::max(0, last - 1)));
    std::iota(inner.begin(), inner.end(), 1);
    shuffle_first(inner, static_cast<size_t>(std::max(0.0, n * last / count - 2)), random);
  }
  for (const int key : inner)
    out.groups[key].copy_(some_partial && chance(random, partial_fraction) ? constrained : torch::ones({kKeyGroups}));
  if (chance(random, kContinued)) {
    const int known = std::min(last, uniform_int(random, kLeastKnown, kMostKnown));
    for (Tensor* known_frames : {&out.groups, &out.ends}) known_frames->slice(0, 0, known).fill_(1);
  }
  return out;
}

}  // namespace inhabit::inbetween
