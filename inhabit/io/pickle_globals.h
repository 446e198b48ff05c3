#pragma once
#include <string>
#include <vector>

#include "inhabit/io/pickle.h"

namespace inhabit {

// What pickles may call, for pickle.cpp alone.

/// The one name in this project for a global that a pickle may use ("reconstruct"), empty where it is not allowed.
std::string allowed_global(const std::string& module, const std::string& name);

/// What such a global gives for its arguments (a tuple). Throws Error(subject, ...) where they are not its own.
PickleValue call_global(const std::string& global, const PickleValue& arguments, const std::string& subject);

/// Gives an array or a dtype its state (BUILD). Throws Error(subject, ...) where either is something else.
void set_state(PickleValue& object, const PickleValue& state, const std::string& subject);

}  // namespace inhabit
