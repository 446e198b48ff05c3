#pragma once
#include <string>
#include <vector>

#include "inhabit/interact/chair_interactor.h"

namespace inhabit::interact {

/// What is to be said of a motion that was made all the same, a line each: that nobody sat down, and how many of the
/// contacts no hand left for. @param seconds that the motion was given
std::vector<std::string> warnings_of(const Result& result, double seconds);

}  // namespace inhabit::interact
