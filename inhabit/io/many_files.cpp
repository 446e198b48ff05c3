#include "inhabit/io/many_files.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "inhabit/error.h"
#include "inhabit/interruption.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

bool looks_like_motion(const std::string& path) {
  const std::string extension = extension_of(path);
  if (extension == "bvh" || extension == "amc" || extension == "txt" || extension == "json") return true;
  static const std::set<std::string> perhaps = {"npz", "npy", "fbx", "dae", "glb", "gltf"};
  if (perhaps.count(extension) == 0) return false;
  try {
    return is_clip_file(path);
  } catch (const Error&) {
    return true;  // damaged: to be said, not passed over
  }
}

std::vector<std::string> in_folder(const std::string& folder) {
  std::vector<std::string> out;
  std::error_code refused;
  for (fs::recursive_directory_iterator entry(folder, refused), end; !refused && entry != end; entry.increment(refused))
    if (entry->is_regular_file(refused) && looks_like_motion(entry->path().string()))
      out.push_back(entry->path().string());
  if (refused) throw Error(folder, "cannot be read: " + refused.message());
  if (out.empty())
    throw Error(folder, "is a folder without motion files (.bvh .fbx .glb .gltf .dae .amc .txt .npz .npy .json)");
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

std::vector<std::string> files_matching(const std::string& pattern) {
  glob_t found{};
  const int failed = ::glob(pattern.c_str(), 0, nullptr, &found);
  std::vector<std::string> out;
  if (failed == 0) out.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  if (out.empty()) throw Error(pattern, "there is no such file");
  return out;
}

std::vector<std::string> motion_files(const std::vector<std::string>& named) {
  std::vector<std::string> out;
  for (const std::string& name : named) {
    std::vector<std::string> files = {name};
    std::error_code none;
    if (fs::is_directory(name, none))
      files = in_folder(name);
    else if (name.find_first_of("*?[") != std::string::npos && !fs::exists(name, none))
      files = files_matching(name);
    out.insert(out.end(), files.begin(), files.end());
  }
  return out;
}

FileCount each_file(const std::vector<std::string>& files, const std::function<void(const std::string&)>& work,
                    const Progress& progress) {
  FileCount out;
  const auto all = static_cast<int64_t>(files.size());
  for (const std::string& file : files) {
    interruption_point();
    if (progress) progress(out.done + static_cast<int64_t>(out.skipped.size()), all);
    try {
      work(file);
      ++out.done;
    } catch (const Error& e) {
      if (files.size() == 1) throw;
      out.skipped.emplace_back(e.what());
    }
  }
  if (progress) progress(all, all);
  if (out.done == 0 && !out.skipped.empty())
    throw Error("none of " + std::to_string(files.size()) + " files can be used; of the first: " + out.skipped.front());
  return out;
}

}  // namespace inhabit
