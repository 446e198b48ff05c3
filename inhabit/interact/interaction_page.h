#pragma once
#include <vector>

#include "inhabit/interact/chair_interactor.h"
#include "inhabit/view/page.h"

namespace inhabit::interact {

/// Motions onto a chair. The page looks at `scene`, which must outlive it.
Page interaction_page(const std::vector<Result>& results, const Scene& scene);

}  // namespace inhabit::interact
