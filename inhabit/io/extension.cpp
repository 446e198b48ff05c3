#include "inhabit/io/extension.h"

#include <filesystem>

#include "inhabit/lower_case.h"

namespace inhabit {

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  return lower_case(extension);
}

}  // namespace inhabit
