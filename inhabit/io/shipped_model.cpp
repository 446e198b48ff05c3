#include "inhabit/io/shipped_model.h"

#include <dlfcn.h>
#include <link.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <vector>

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

/// The folders in a list between colons, or in `otherwise` where the variable is not set or empty.
std::vector<fs::path> folders_in(const char* variable, const std::string& otherwise) {
  const char* value = std::getenv(variable);
  std::stringstream list(value != nullptr && *value != '\0' ? value : otherwise);
  std::vector<fs::path> out;
  for (std::string folder; std::getline(list, folder, ':');)
    if (!folder.empty()) out.emplace_back(folder);
  return out;
}

/// Where models are looked for, in this order.
std::vector<fs::path> model_folders(const fs::path& own) {
  std::vector<fs::path> out = folders_in("INHABIT_MODELS", "");
  const char* home = std::getenv("HOME");
  for (const fs::path& data : folders_in("XDG_DATA_HOME", home != nullptr ? std::string(home) + "/.local/share" : ""))
    out.push_back(data / "inhabit/models");
  for (fs::path folder = own.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
    for (const char* place : {"models", "share/inhabit/models"}) out.push_back(folder / place);
  for (const fs::path& data : folders_in("XDG_DATA_DIRS", "/usr/local/share:/usr/share"))
    out.push_back(data / "inhabit/models");
  return out;
}

/// Empty where there is none.
std::string found_model(const std::string& name) {
  std::error_code none;
  for (const fs::path& folder : model_folders(own_file()))
    if (fs::is_regular_file(folder / name, none)) return (folder / name).string();
  return "";
}

}  // namespace

std::string shipped_model(const std::string& name) {
  if (std::string found = found_model(name); !found.empty()) return found;
  throw Error(name, "is in no models folder above " + own_file().filename().string() +
                        ", nor in $INHABIT_MODELS, nor in inhabit/models of the XDG data folders; name a model file "
                        "instead");
}

std::string model_file(const std::string& given, const std::string& shipped) {
  if (given.empty()) return shipped_model(shipped);
  std::error_code none;
  if (fs::exists(given, none) || given.find('/') != std::string::npos) return given;
  for (const std::string& name : {given, given + ".safetensors"})
    if (std::string found = found_model(name); !found.empty()) return found;
  throw Error(given, "there is no such file, nor a model of this name where models are looked for");
}

}  // namespace inhabit
