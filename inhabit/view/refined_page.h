#pragma once
#include <string>
#include <vector>

#include "inhabit/view/page.h"

namespace inhabit {

/// A motion as it was and as it was refined.
struct RefinedPerson {
  Clip before;  ///< on the standard skeleton
  Clip after;   ///< likewise
};

/// Motions of one or several people, with strips of the first one's hand contacts (Clip::hand_targets), in a scene that
/// must outlive the page.
Page refined_page(const std::vector<RefinedPerson>& people, const Scene& scene, const std::string& title);

}  // namespace inhabit
