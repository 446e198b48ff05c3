#pragma once
#include <string>
#include <vector>

#include "inhabit/inbetween/scene_inbetweener.h"
#include "inhabit/view/page.h"

namespace inhabit::inbetween {

/// The motions between the same keys, with the keys as still figures. The page looks at the scene of the first result,
/// which must outlive it.
/// @param cleaned keys were noisy: poses asked for are shown beside those that came out
/// @param key_groups as in Options
Page inbetween_page(const std::vector<Result>& results, bool cleaned, const torch::Tensor& key_groups,
                    const std::string& title);

}  // namespace inhabit::inbetween
