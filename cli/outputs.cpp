#include "outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "verbs.h"

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

void add_outputs(CLI::App& verb, std::vector<std::string>& outputs, const std::string& what) {
  verb.add_option("-o,--out", outputs, what + "; once for each file")->allow_extra_args(false);
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
                   const std::function<size_t(const std::string& path)>& write_motion) {
  const auto is_page = [](const std::string& out) { return inhabit::extension_of(out) == "html"; };
  for (const std::string& out : outputs) {
    if (is_page(out)) continue;
    const std::vector<std::string> files = inhabit::clip_files(out, write_motion(out));
    std::printf("%s\n", (files.size() > 1 ? files.front() + " to " + files.back() : out).c_str());
  }
  for (const std::string& out : outputs) {
    if (!is_page(out)) continue;
    inhabit::write_page(out, page());
    std::printf("%s\n", out.c_str());
  }
}

void add_writing(CLI::App& verb, inhabit::WriteOptions& writing, bool loop) {
  verb.add_option("--from", writing.from, "Seconds of the motion from which on it is written")
      ->check(not_negative)
      ->option_text("SECONDS");
  verb.add_option("--to", writing.to, "Seconds of the motion up to which it is written, that frame with it")
      ->check(not_negative)
      ->option_text("SECONDS");
  verb.add_option("--rate", writing.rate, "Frames a second of the motion that is written")->check(frame_rate);
  verb.add_option("--out-up", writing.up, "Up axis of the motion that is written, y, or z (.bvh, .npz)")
      ->transform(one_of<inhabit::UpAxis>({{"y", inhabit::UpAxis::y}, {"z", inhabit::UpAxis::z}}))
      ->option_text("y|z");
  if (loop)
    verb.add_flag("--loop", writing.loop,
                  "Mix the end of the motion that is written into its start, half a second shorter, so that it can be "
                  "repeated");
}

void require_motion_written(const inhabit::WriteOptions& writing, const std::vector<std::string>& outputs) {
  if (writing.any() && pages_alone(outputs))
    throw inhabit::Error("--from, --to, --rate, --out-up and --loop",
                         "are of motion files; a page shows the motion as it is");
  for (const std::string& out : outputs)
    if (inhabit::extension_of(out) != "html") inhabit::require_written_as(writing, out);
}
