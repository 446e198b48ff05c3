#pragma once
#include <string>

namespace inhabit {

/// The part after the last dot of the file's name, lower case, without the dot; empty where there is none.
std::string extension_of(const std::string& path);

}  // namespace inhabit
