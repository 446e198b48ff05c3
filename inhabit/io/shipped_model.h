#pragma once
#include <string>

namespace inhabit {

/// Path of a model by its file's name, the first there is: in a folder of $INHABIT_MODELS (several between colons), in
/// inhabit/models of the user's data ($XDG_DATA_HOME, else ~/.local/share), in models/ or share/inhabit/models/ of a
/// folder above the program or shared library that this code is part of (the command, the Python module), in
/// inhabit/models of $XDG_DATA_DIRS (else /usr/local/share and /usr/share). Throws Error where there is none.
std::string shipped_model(const std::string& name);

/// What a user means by a model: nothing is the one called `shipped`, a file is that file, and a name without a folder
/// a model in the places above, with or without .safetensors. Throws Error where none of them is there.
std::string model_file(const std::string& given, const std::string& shipped);

}  // namespace inhabit
