#include "inhabit/io/convert.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/many_files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/motion/retarget.h"

namespace inhabit {
namespace {

using Written = std::map<std::string, std::string>;  // canonical paths of files and what each was made of

std::string canonical(const std::string& path) {
  std::error_code failed;
  const std::filesystem::path out = std::filesystem::weakly_canonical(path, failed);
  return failed ? std::filesystem::absolute(path).string() : out.string();
}

void claim(const std::string& file, const std::string& in, Written* written) {
  if (written == nullptr) return;
  const auto [before, fresh] = written->emplace(canonical(file), in);
  if (!fresh && before->second.empty())
    throw Error(in, "would be written over " + file + ", which is to be converted too");
  if (!fresh) throw Error(file, "would be written of both " + before->second + " and " + in);
}

std::string convert_motion(const std::string& in, const std::string& out, const ConvertOptions& given, Notes* notes,
                           Written* written) {
  ClipReadOptions options = given.reading;
  BodyModel body;
  if (!given.body.empty()) {
    body = read_smpl_model(given.body);
    options.body = &body;
  }
  std::vector<Clip> clips = read_samples(in, options, notes);
  for (Clip& clip : clips) {
    clip.file = {};
    if (given.retarget) clip = retarget(clip, in);
  }
  SceneFile scene;
  if (!given.scene.empty()) {
    if (extension_of(out) != "glb") throw Error(out, "only .glb holds a scene beside the motion");
    scene = read_scene_file(given.scene);
  }
  for (const std::string& file : clip_files(out, clips.size())) claim(file, in, written);
  write_clips(out, clips, given.writing, {}, given.scene.empty() ? nullptr : &scene.scene);
  const Clip clip = to_be_written(clips.front(), given.writing, out);
  return fmt::format("{}{} frames at {:g} a second ({:.2f} s), {} joints",
                     clips.size() == 1 ? ""
                     : extension_of(out) == "npz"
                         ? fmt::format("{} motions of ", clips.size())
                         : fmt::format("{} files, from ..._000.{} on, of ", clips.size(), extension_of(out)),
                     clip.frames(), clip.rate, clip.seconds(), clip.skeleton.size());
}

std::string convert_scene(const std::string& in, const std::string& out, const ConvertOptions& given,
                          Written* written) {
  SceneReadOptions options;
  options.up = given.reading.up;
  if (given.reading.scale > 0) options.scale = given.reading.scale;
  if (given.writing.any() || given.reading.rate > 0 || !given.reading.asf.empty() || given.reading.level ||
      given.retarget || !given.scene.empty() || !given.body.empty())
    throw Error(in,
                "is a scene: times, frame rates, --loop, --asf, --level, --retarget, --scene, --out-up and --body go "
                "with motions");
  const SceneFile file = read_scene_file(in, options);
  claim(out, in, written);
  write_scene(out, file.scene);
  return describe(file.report);
}

/// The files that a name stands for which can become `format`.
std::vector<std::string> files_as(const std::string& name, bool folder, const std::string& format) {
  if (!folder || (format != "ply" && format != "glb")) return motion_files({name});
  if (format == "ply") return scene_files(name);
  try {
    return motion_files({name});
  } catch (const Error&) {  // none
    return scene_files(name);
  }
}

}  // namespace

std::string convert_file(const std::string& in, const std::string& out, const ConvertOptions& options, Notes* notes,
                         std::map<std::string, std::string>* written) {
  // Of a file that may hold both, .ply takes the scene: no motion is written so.
  const bool is_motion = !is_scene_extension(extension_of(in)) || (extension_of(out) != "ply" && is_clip_file(in));
  return is_motion ? convert_motion(in, out, options, notes, written) : convert_scene(in, out, options, written);
}

std::vector<Conversion> conversions(const std::vector<std::string>& named, const std::string& out,
                                    const std::string& format, std::vector<std::string>* skipped,
                                    std::map<std::string, std::string>* inputs) {
  namespace fs = std::filesystem;
  std::vector<Conversion> all;
  Written of_inputs;
  std::set<std::pair<std::string, std::string>> known;  // inputs and what they become
  for (const std::string& name : named) {
    std::error_code none;
    const bool folder = fs::is_directory(name, none);
    for (const std::string& file : files_as(name, folder, format)) {
      const fs::path relative = folder ? fs::path(file).lexically_relative(name) : fs::path(file).filename();
      const std::string target = (fs::path(out) / relative).replace_extension(format).string();
      of_inputs.emplace(canonical(file), "");
      if (known.emplace(canonical(file), target).second) all.push_back({file, target});  // else named twice
    }
  }
  Written sources;
  const auto refused = [&](const Conversion& each) {
    std::string why;
    if (of_inputs.count(canonical(each.out)) != 0)
      why = canonical(each.in) == canonical(each.out)
                ? each.out + ": would be written over what it is made of"
                : each.in + ": would be written over " + each.out + ", which is to be converted too";
    else if (const auto [before, fresh] = sources.emplace(each.out, each.in); !fresh)
      why = each.in + ": would become " + each.out + ", as " + before->second + " does";
    if (!why.empty() && skipped != nullptr) skipped->push_back(why);
    return !why.empty();
  };
  all.erase(std::remove_if(all.begin(), all.end(), refused), all.end());
  if (inputs != nullptr) inputs->merge(of_inputs);
  return all;
}

}  // namespace inhabit
