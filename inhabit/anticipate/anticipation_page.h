#pragma once
#include <string>

#include "inhabit/anticipate/intention_anticipator.h"
#include "inhabit/view/page.h"

namespace inhabit::anticipate {

/// All futures, side by side and overlaid, with their intentions.
Page anticipation_page(const Result& result, const std::string& title);

}  // namespace inhabit::anticipate
