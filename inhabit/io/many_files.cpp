#include "inhabit/io/many_files.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "inhabit/error.h"
#include "inhabit/interruption.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"

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

bool looks_like_scene(const std::string& path) {
  return is_scene_extension(extension_of(path)) && !looks_like_motion(path);
}

std::vector<std::string> in_folder(const std::string& folder, bool (*wanted)(const std::string&), const char* what) {
  std::vector<std::string> out;
  std::error_code refused;
  for (fs::recursive_directory_iterator entry(folder, refused), end; !refused && entry != end; entry.increment(refused))
    if (entry->is_regular_file(refused) && wanted(entry->path().string())) out.push_back(entry->path().string());
  if (refused) throw Error(folder, "cannot be read: " + refused.message());
  if (out.empty()) throw Error(folder, std::string("is a folder without ") + what);
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<std::string> glob_of(const std::string& pattern) {
  glob_t found{};
  const int failed = ::glob(pattern.c_str(), 0, nullptr, &found);
  std::vector<std::string> out;
  if (failed == 0) out.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  return out;
}

}  // namespace

std::vector<std::string> files_matching(const std::string& pattern) {
  std::vector<std::string> out = glob_of(pattern);
  if (out.empty()) throw Error(pattern, "there is no such file");
  return out;
}

std::vector<std::string> motion_files(const std::vector<std::string>& named) {
  std::vector<std::string> out;
  for (const std::string& name : named) {
    std::vector<std::string> files = {name};
    std::error_code none;
    if (fs::is_directory(name, none))
      files = in_folder(name, looks_like_motion, "motion files (.bvh .fbx .glb .gltf .dae .amc .txt .npz .npy .json)");
    else if (name.find_first_of("*?[") != std::string::npos && !fs::exists(name, none))
      files = files_matching(name);
    out.insert(out.end(), files.begin(), files.end());
  }
  return out;
}

std::vector<std::string> scene_files(const std::string& folder) {
  return in_folder(folder, looks_like_scene, "scenes (.obj .ply .glb .gltf .fbx .dae .off .stl .pcd .xyz .npz .npy)");
}

std::vector<std::string> folders_matching(const std::vector<std::string>& named) {
  std::vector<std::string> out;
  for (const std::string& name : named) {
    std::error_code none;
    const bool of_format = name.rfind("cmu:", 0) == 0 || name.rfind("h36m:", 0) == 0;  // data/motion_set.h
    if (of_format || name.find_first_of("*?[") == std::string::npos || fs::exists(name, none)) {
      out.push_back(name);
      continue;
    }
    const size_t before = out.size();
    for (const std::string& each : glob_of(name))
      if (fs::is_directory(each, none)) out.push_back(each);
    if (out.size() == before) throw Error(name, "no folder matches");
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
