#pragma once
#include <string>

namespace inhabit {

/// A whole file as bytes. Throws Error(path, ...) when it is missing, a folder, unreadable or over 4 GiB.
std::string read_bytes(const std::string& path);

/// The part after the last dot of the file's name, lower case, without the dot; empty where there is none.
std::string extension_of(const std::string& path);

}  // namespace inhabit
