#pragma once
#include <string>

/// Path of a model that ships with inhabit: in $INHABIT_MODELS, or in models/ or share/inhabit/models/ of a folder
/// above the command. Throws inhabit::Error where there is none.
std::string shipped_model(const std::string& name);
