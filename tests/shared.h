#pragma once
#include <cstdlib>
#include <filesystem>
#include <string>

/// Folder of recordings and reference outputs beside the project (data/, parity/); empty where there is none, and tests
/// that need it skip.
inline std::string shared_folder() {
  const char* named = std::getenv("INHABIT_SHARED");
  const std::filesystem::path path = named != nullptr ? named : INHABIT_SOURCE_DIR "/../shared";
  return std::filesystem::is_directory(path) ? path.string() : std::string();
}
