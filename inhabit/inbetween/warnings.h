#pragma once
#include <string>
#include <vector>

#include "inhabit/inbetween/scene_inbetweener.h"

namespace inhabit::inbetween {

/// What is to be said of a motion that was made all the same, a line each: key poses that are inside the scene (the
/// five deepest by name), keys behind something that nobody gets around in time, contacts that nobody there could
/// reach. @param contacts what each of Controls::contacts is called
std::vector<std::string> warnings_of(const Result& result, const std::vector<std::string>& contacts);

/// What is to be known of the scene that was looked at, a line each: that a flat floor was assumed, or that it is a
/// point cloud, which has no inside.
std::vector<std::string> notes_of(const Result& result);

}  // namespace inhabit::inbetween
