#pragma once
#include <string>
#include <vector>

#include "inhabit/anticipate/intention_summary.h"
#include "inhabit/view/page.h"

namespace inhabit::anticipate {

/// One motion for each label that occurs, at most ten seconds of its representative segment, and the labels of every
/// recording as strips, on which the motions' segments are outlined.
/// @param recordings those that were summarised, at `rate` frames a second on the bones of `skeleton`
Page intention_page(const IntentionSummary& summary, const std::vector<Sequence>& recordings, const Skeleton& skeleton,
                    double rate, const std::string& title);

}  // namespace inhabit::anticipate
