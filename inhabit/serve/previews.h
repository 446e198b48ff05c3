#pragma once
#include <vector>

#include "inhabit/serve/frames.h"
#include "inhabit/serve/world.h"

namespace inhabit::serve {

// What the other systems make of a person; each takes up to seconds, and is meant for a thread of its own. Throw Error
// where the world has no such model or its networks refuse what they are given.

/// The next two seconds (forecast/): a pose every half second.
std::vector<Ghost> forecast_ghosts(const World& world, const Clip& recent);

/// Some of what may come (anticipate/): four futures, a pose a second for three seconds.
std::vector<Ghost> future_ghosts(const World& world, const Clip& recent, uint64_t seed);

/// Motion from a pose to another one (inbetween/), 30 frames a second, as long as the path takes. Throws Error too
/// where that is farther than one window of the model.
Clip motion_to(const World& world, const Frame& from, const Frame& to);

}  // namespace inhabit::serve
