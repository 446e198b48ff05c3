#include "models.h"

#include <cstdlib>
#include <filesystem>

#include "inhabit/error.h"

namespace fs = std::filesystem;

std::string shipped_model(const std::string& name) {
  if (const char* folder = std::getenv("INHABIT_MODELS"); folder != nullptr && fs::exists(fs::path(folder) / name))
    return (fs::path(folder) / name).string();
  std::error_code none;
  const fs::path command = fs::read_symlink("/proc/self/exe", none);
  for (fs::path folder = command.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    for (const char* place : {"models", "share/inhabit/models"})
      if (fs::exists(folder / place / name)) return (folder / place / name).string();
  throw inhabit::Error(name,
                       "is in no models folder above the command nor in $INHABIT_MODELS; name a model with --model");
}
