#pragma once
#include <string>

#include "inhabit/serve/world.h"

namespace inhabit::serve {

/// The page that a server of this world sends: its scene and the person's body are in it.
std::string live_page(const World& world);

/// What a page is told first, as JSON: seats, poses, what is offered, limits.
std::string greeting(const World& world, int recorded);

}  // namespace inhabit::serve
