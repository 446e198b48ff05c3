#pragma once
#include <string>

#include "inhabit/view/page.h"

namespace inhabit {

/// A motion as it was and as it was refined, in a scene that must outlive the page.
Page refined_page(const Clip& before, const Clip& after, const Scene& scene, const std::string& title);

}  // namespace inhabit
