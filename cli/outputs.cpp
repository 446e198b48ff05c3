#include "outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "inhabit/error.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"

namespace fs = std::filesystem;

void require_writable(const std::string& path) {
  const fs::path target(path), folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::error_code ignored;
  if (fs::is_directory(target, ignored)) throw inhabit::Error(path, "cannot be written: it is a folder");
  if (!fs::is_directory(folder, ignored))
    throw inhabit::Error(path, "cannot be written: there is no folder " + folder.string());
  const bool in_place = fs::exists(target, ignored) && !fs::is_regular_file(target, ignored);  // /dev/null, a pipe
  const fs::path probe = in_place ? target : folder / ("." + target.filename().string() + ".probe");
  errno = 0;
  if (!std::ofstream(probe, std::ios::app))
    throw inhabit::Error(path, std::string("cannot be written: ") + std::strerror(errno));
  if (!in_place) fs::remove(probe, ignored);
}

void require_motion_outputs(std::vector<std::string>& outputs, const std::string& otherwise, const std::string& what) {
  if (outputs.empty()) outputs.push_back(otherwise);
  for (const std::string& out : outputs) {
    if (const std::string e = inhabit::extension_of(out);
        e != "npz" && e != "bvh" && e != "glb" && e != "json" && e != "html")
      throw inhabit::Error(out, "is no output of " + what + ": .npz, .bvh, .glb, .json or .html");
    require_writable(out);
  }
}

bool pages_alone(const std::vector<std::string>& outputs) {
  return std::all_of(outputs.begin(), outputs.end(),
                     [](const std::string& out) { return inhabit::extension_of(out) == "html"; });
}

void write_outputs(const std::vector<std::string>& outputs, const std::function<inhabit::Page()>& page,
                   const std::function<void(const std::string& path)>& write_motion) {
  for (const std::string& out : outputs) {
    if (inhabit::extension_of(out) == "html")
      inhabit::write_page(out, page());
    else
      write_motion(out);
    std::printf("%s\n", out.c_str());
  }
}

void write_motions(const std::string& path, const std::vector<inhabit::Clip>& motions,
                   const std::map<std::string, torch::Tensor>& more, const inhabit::Scene* scene) {
  if (motions.size() == 1 && more.empty()) return inhabit::write_clip(path, motions.front(), scene);
  if (inhabit::extension_of(path) == "npz") return inhabit::write_clips_npz(path, motions, more);
  const fs::path p(path);
  for (size_t i = 0; i < motions.size(); ++i) {
    const std::string number = motions.size() == 1 ? "" : fmt::format("_{:03}", i);
    inhabit::write_clip((p.parent_path() / (p.stem().string() + number + p.extension().string())).string(), motions[i],
                        scene);
  }
}
