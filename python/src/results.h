#pragma once
#include <optional>

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
  bool cleaned = false;      ///< keys were noisy
  torch::Tensor key_groups;  ///< inbetween::Options
};

struct IntentionsResult {
  anticipate::ClusteredSet set;
  std::optional<anticipate::LabelAgreement> agreement;  ///< with labels of others, where there are any
};

struct InteractResult {
  interact::Result result;
  Scene scene;
};

/// Contacts as Python has them: of the left and the right hand, metres, or None.
using HandPoints = std::pair<std::optional<Point>, std::optional<Point>>;

struct RefineResult {
  refine::Result result;
  Scene scene;
};

}  // namespace inhabit::python
