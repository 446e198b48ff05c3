#include "inhabit/io/shipped_model.h"

#include <dlfcn.h>
#include <link.h>

#include <cstdlib>
#include <filesystem>

#include "inhabit/error.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

/// The file that holds this code.
fs::path own_file() {
  std::error_code none;
  Dl_info info;
  link_map* of = nullptr;
  const bool found =
      dladdr1(reinterpret_cast<void*>(&shipped_model), &info, reinterpret_cast<void**>(&of), RTLD_DL_LINKMAP) != 0;
  // The program itself has no name there, and what dladdr says of it is what the caller wished to call it.
  if (found && of != nullptr && of->l_name != nullptr && *of->l_name != '\0') return fs::canonical(of->l_name, none);
  return fs::read_symlink("/proc/self/exe", none);
}

}  // namespace

std::string shipped_model(const std::string& name) {
  if (const char* folder = std::getenv("INHABIT_MODELS"); folder != nullptr && fs::exists(fs::path(folder) / name))
    return (fs::path(folder) / name).string();
  const fs::path own = own_file();
  for (fs::path folder = own.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    for (const char* place : {"models", "share/inhabit/models"})
      if (fs::exists(folder / place / name)) return (folder / place / name).string();
  throw Error(name, "is in no models folder above " + own.filename().string() +
                        " nor in $INHABIT_MODELS; name a model file instead");
}

}  // namespace inhabit
