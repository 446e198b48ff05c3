#pragma once
#include <vector>

#include "inhabit/view/page.h"

namespace inhabit {

/// A page of many futures of one observation: side by side, each in its place, and overlaid, where they go.
/// @param past what was observed; its last frame comes right before each future's first.
/// @param futures on any one skeleton, in the world of `past`. Their joints are shown, as small figures.
/// @param labels (T) int64 intentions of each future, in its order; empty for a model without them.
/// Throws Error where there is no future, or labels are of another number than futures.
Page futures_page(const Clip& past, const std::vector<Clip>& futures, const std::vector<torch::Tensor>& labels);

}  // namespace inhabit
