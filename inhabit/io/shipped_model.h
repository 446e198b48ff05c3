#pragma once
#include <string>

namespace inhabit {

/// Path of a model that ships with inhabit: in $INHABIT_MODELS, or in models/ or share/inhabit/models/ of a folder
/// above the program or shared library that this code is part of (the command, the Python module). Throws Error where
/// there is none.
std::string shipped_model(const std::string& name);

}  // namespace inhabit
