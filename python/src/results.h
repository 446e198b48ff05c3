#pragma once
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "calls.h"
#include "inhabit/anticipate/clustered_set.h"
#include "inhabit/anticipate/label_agreement.h"
#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/interact/chair_interactor.h"
#include "inhabit/refine/refine_clip.h"

// Results of the library with what else their pages show.

namespace inhabit::python {

struct InbetweenResult {
  inbetween::Result result;
  bool cleaned = false;                 ///< keys were noisy
  torch::Tensor key_groups;             ///< inbetween::Options
  std::vector<InbetweenResult> others;  ///< of several samples all but the first, which this is
};

struct IntentionsResult {
  anticipate::ClusteredSet set;
  std::optional<anticipate::LabelAgreement> agreement;  ///< with labels of others, where there are any
};

struct InteractResult {
  interact::Result result;
  Scene scene;
  std::vector<InteractResult> others;  ///< of several samples all but the first, which this is
};

/// Several samples as the first of them, which has the others.
template <class Result>
Result first_of(std::vector<Result> samples) {
  Result out = std::move(samples.front());
  out.others.assign(std::make_move_iterator(samples.begin() + 1), std::make_move_iterator(samples.end()));
  return out;
}

/// All samples, of which a result is the first, each by itself.
template <class Result>
std::vector<Result> samples_of(const Result& result) {
  std::vector<Result> out = {result};
  out.front().others.clear();
  out.insert(out.end(), result.others.begin(), result.others.end());
  return out;
}

/// Contacts as Python has them: of the left and the right hand, metres, or None.
using HandPoints = std::pair<std::optional<Point>, std::optional<Point>>;

struct RefineResult {
  refine::Result result;
  Scene scene;
};

}  // namespace inhabit::python
