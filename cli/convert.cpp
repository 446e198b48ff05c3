#include <cstdio>
#include <filesystem>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/io/convert_files.h"
#include "inhabit/io/file_notes.h"
#include "inputs.h"
#include "interrupted.h"
#include "outputs.h"
#include "progress.h"
#include "verbs.h"

namespace {

struct Convert {
  std::vector<std::string> files;
  std::string format;
  inhabit::ConvertOptions options;
};

/// Whether `files` name a folder to convert into, and not one file that becomes another.
bool into_folder(const Convert& o) {
  namespace fs = std::filesystem;
  const std::string& in = o.files.front();
  std::error_code none;
  const std::string& out = o.files.back();
  const bool pattern = in.find_first_of("*?[") != std::string::npos && !fs::exists(in, none);
  return o.files.size() > 2 || !o.format.empty() || pattern || fs::is_directory(in, none) ||
         fs::is_directory(out, none) || (!out.empty() && out.back() == '/');
}

void convert_many(const Convert& o) {
  const std::vector<std::string> named(o.files.begin(), o.files.end() - 1);
  inhabit::Notes notes;
  const GoesOnLater later("the files that are named above are written; name the rest to go on");
  const inhabit::FileCount count = inhabit::convert_files(
      named, o.files.back(), o.format.empty() ? "npz" : o.format, o.options,
      [](const std::string& file, const std::string& line) {
        end_progress();
        std::printf("%s: %s\n", file.c_str(), line.c_str());
        std::fflush(stdout);  // what GoesOnLater speaks of
      },
      &notes, progress_of("files"));
  end_progress();
  say(notes, 8);
  end_of(count);
}

}  // namespace

void add_convert(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("convert", "Write a motion or a scene, or many motions, in another format");
  auto given = std::make_shared<Convert>();
  verb->add_option("files", given->files,
                   "IN OUT: motion (.bvh .fbx .dae .glb .gltf .amc .txt .npz .npy .json) as .npz .json .bvh .glb, or "
                   "scene (.obj .ply .glb .gltf .fbx .dae .off .stl .pcd .xyz .npz .npy) as .glb .ply; or IN... "
                   "FOLDER: files, folders of motion (--format ply: of scenes) and "
                   "patterns, each as a file of the same name in FOLDER")
      ->required();
  verb->add_option("--format", given->format, "Of many files: the format they become (default: npz)")
      ->check(CLI::IsMember(inhabit::convert_formats()));
  verb->add_flag("--retarget", given->options.retarget, "Onto the standard 22 joints");
  add_reading(*verb, given->options.reading, "the input");
  add_writing(*verb, given->options.writing);
  verb->add_option("--scene", given->options.scene, "Scene to put into a .glb beside the motion");
  verb->add_option("--body", given->options.body,
                   "SMPL, SMPL-H or SMPL-X model file (.npz) for motions of that family");
  verb->callback([given] {
    if (given->files.size() < 2) throw inhabit::Error("OUT", "is missing: the file or folder to write to");
    if (into_folder(*given)) return convert_many(*given);
    const std::string &in = given->files.front(), &out = given->files.back();
    require_amc(in, given->options.reading);
    inhabit::Notes own, notes;
    const std::string written = inhabit::convert_file(in, out, given->options, &own);
    inhabit::add_notes(notes, std::move(own), in);
    say(notes);
    std::printf("%s: %s\n", out.c_str(), written.c_str());
  });
}
