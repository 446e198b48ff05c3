#include "inhabit/io/files.h"

#include <spdlog/fmt/fmt.h>

#include <cstdio>
#include <filesystem>

#include "inhabit/body/body_model.h"
#include "inhabit/error.h"
#include "inhabit/io/asf_amc.h"
#include "inhabit/io/assimp_motion.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/bvh.h"
#include "inhabit/io/clip_json.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/expmap_text.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/gltf.h"
#include "inhabit/io/ply.h"
#include "inhabit/io/upright.h"
#include "inhabit/motion/level.h"
#include "inhabit/motion/locomotion.h"
#include "inhabit/motion/plausible.h"
#include "inhabit/motion/retarget.h"

namespace inhabit {

namespace fs = std::filesystem;

namespace {

/// Formats of nodes, which may hold motion, a scene or both.
bool is_node_file(const std::string& extension) {
  return extension == "fbx" || extension == "dae" || extension == "glb" || extension == "gltf";
}

/// Makes the floor level: where it is asked for as far as it is known, otherwise where it is certain to slope.
void levelled(Clip& clip, bool asked, Notes& notes) {
  const FloorSlope slope = floor_slope(clip);
  if (asked && slope.stances < FloorSlope::kLeastStances)
    notes.emplace_back("not levelled: the feet stand too seldom to tell the floor");
  if (asked ? slope.stances < FloorSlope::kLeastStances : !slope.certain()) return;
  level(clip, slope);
  char text[96];
  std::snprintf(text, sizeof text, "levelled: the floor under the feet sloped by %.1f degrees (+- %.1f)", slope.degrees,
                slope.uncertainty);
  notes.emplace_back(text);
}

/// What the readers of recordings leave to the caller: the rate given by hand, which axis is up, who carries the body.
/// @param foreign false: of inhabit itself, whose +Y is up unless the user says otherwise, and whose root goes where it
/// was found to go.
Clip finished(SourceMotion motion, const std::string& path, const ClipReadOptions& options, Notes* notes,
              bool foreign = true) {
  if (options.rate != 0)
    motion.clip.rate = options.rate;
  else if (motion.rate_assumed)
    motion.notes.push_back(fmt::format("the file does not say its rate, {:g} frames a second taken", motion.clip.rate));
  validate(motion.clip, path);
  motion.clip.file.z_up = ((foreign && !motion.y_up) || options.up != UpAxis::automatic) &&
                          is_z_up(motion.clip, options.up, path, &motion.notes);
  if (motion.clip.file.z_up) rotate_upright(motion.clip);
  if (options.level || motion.slopes) levelled(motion.clip, options.level, motion.notes);
  if (const int carrier = foreign ? carry_by_root(motion.clip) : -1; carrier >= 0)
    motion.notes.push_back("the root goes where " + motion.clip.skeleton.names[static_cast<size_t>(carrier)] +
                           ", which carried the motion, goes");
  if (motion.clip.translations.defined()) {
    const torch::Tensor apart = (motion.clip.translations - motion.clip.skeleton.offsets).abs().amax({0, 2});
    motion.notes.push_back(std::to_string(apart.gt(0).sum().item<int64_t>()) + " joints translate");
  }
  if (notes != nullptr) notes->insert(notes->end(), motion.notes.begin(), motion.notes.end());
  return std::move(motion.clip);
}

void note_implausible(const Clip& clip, Notes* notes) {
  if (notes == nullptr) return;
  for (std::string& doubt : implausible(clip)) notes->push_back(std::move(doubt));
}

Clip read_any(const std::string& path, const ClipReadOptions& options, Notes* notes) {
  const std::string extension = extension_of(path);
  const std::optional<double> unit = options.scale > 0 ? std::optional(options.scale) : std::nullopt;
  if (extension == "npz" || extension == "npy") {
    Clip clip = read_clip_npz(path, options, notes);
    Notes own;
    if (options.level) levelled(clip, true, own);
    if (notes != nullptr) notes->insert(notes->end(), own.begin(), own.end());
    return clip;
  }
  if (is_node_file(extension)) return finished(std::move(read_node_motions(path, unit).front()), path, options, notes);
  if (extension == "bvh") return finished(read_bvh(path, unit), path, options, notes);
  if (extension == "amc") return finished(read_asf_amc(path, options.asf, unit), path, options, notes);
  if (unit && (extension == "txt" || extension == "json"))
    throw Error(path, "has a unit of its own: a scale given by hand is for .bvh, .amc and foreign .npz");
  if (extension == "txt") return finished(read_expmap_text(path), path, options, notes);
  if (extension == "json") {
    SourceMotion motion;
    motion.clip = read_clip_json(path);
    return finished(std::move(motion), path, options, notes, false);
  }
  if (!std::filesystem::exists(path)) throw Error(path, "there is no such file");
  throw Error(path, "is no motion format inhabit reads (.bvh .fbx .glb .gltf .dae .amc .txt .npz .npy .json)");
}

}  // namespace

Clip read_clip(const std::string& path, const ClipReadOptions& options, Notes* notes) {
  const torch::NoGradGuard no_gradient;
  Clip clip = read_any(path, options, notes);
  note_implausible(clip, notes);
  return clip;
}

std::vector<Clip> read_clips(const std::string& path, const ClipReadOptions& options, Notes* notes) {
  const torch::NoGradGuard no_gradient;
  if (extension_of(path) == "npz") {
    std::vector<Clip> clips = read_clips_npz(path, options, notes);
    Notes own;
    for (Clip& clip : clips)
      if (options.level) levelled(clip, true, own);
    if (notes != nullptr) notes->insert(notes->end(), own.begin(), own.end());
    if (!clips.empty()) note_implausible(clips.front(), notes);
    return clips;
  }
  if (is_node_file(extension_of(path))) {
    std::vector<Clip> clips;
    for (SourceMotion& motion :
         read_node_motions(path, options.scale > 0 ? std::optional(options.scale) : std::nullopt))
      clips.push_back(finished(std::move(motion), path, options, clips.empty() ? notes : nullptr));
    note_implausible(clips.front(), notes);
    return clips;
  }
  return {read_clip(path, options, notes)};
}

std::vector<Clip> read_samples(const std::string& path, const ClipReadOptions& options, Notes* notes) {
  std::vector<Clip> clips = read_clips(path, options, notes);
  if (extension_of(path) != "npz") clips.resize(1);
  return clips;
}

bool is_clip_file(const std::string& path) {
  const std::string extension = extension_of(path);
  if (extension == "npz" || extension == "npy") return holds_clip(read_npz(path));
  for (const char* known : {"bvh", "amc", "txt", "json"})
    if (extension == known) return true;
  // Most glTF is scenes: those without an animation are told from their text, without another process.
  if ((extension == "glb" || extension == "gltf") && read_whole_file(path).find("\"animations\"") == std::string::npos)
    return false;
  return is_node_file(extension) && holds_node_motion(path);
}

void write_clip(const std::string& path, const Clip& clip, const Scene* scene) {
  const torch::NoGradGuard no_gradient;
  const std::string extension = extension_of(path);
  if (extension == "npz") return write_clip_npz(path, clip);
  if (extension == "json") return write_clip_json(path, clip);
  if (extension != "bvh" && extension != "glb")
    throw Error(path, "is no motion format inhabit writes (.npz .json .bvh .glb)");
  const Clip posed = clip.rotations.defined() && clip.trans.defined() ? clip : retarget(clip, path);
  if (extension == "bvh") return write_bvh(path, posed);
  const bool standard = posed.skeleton.names == standard_joint_names();
  write_glb(path, {{&posed, standard ? &builtin_body() : nullptr}}, scene);
}

std::vector<std::string> clip_files(const std::string& path, size_t motions) {
  if (motions == 1 || extension_of(path) == "npz") return {path};
  const fs::path p(path);
  std::vector<std::string> out;
  for (size_t i = 0; i < motions; ++i)
    out.push_back(
        (p.parent_path() / (fmt::format("{}_{:03}{}", p.stem().string(), i, p.extension().string()))).string());
  return out;
}

void write_clips(const std::string& path, const std::vector<Clip>& clips, const WriteOptions& writing,
                 const std::map<std::string, torch::Tensor>& more, const Scene* scene) {
  std::vector<Clip> written;
  written.reserve(clips.size());
  for (const Clip& clip : clips) written.push_back(to_be_written(clip, writing, path));
  if (extension_of(path) == "npz" && (written.size() != 1 || !more.empty())) {
    std::map<std::string, torch::Tensor> rows = more;
    if (writing.any())
      for (auto& [name, array] : rows)
        if (array.defined()) array = array.index_select(1, frames_written(clips.front(), writing));
    return write_clips_npz(path, written, rows);
  }
  const std::vector<std::string> files = clip_files(path, written.size());
  for (const std::string& file : files)  // before the first is written
    if (std::error_code none; fs::is_directory(file, none)) throw Error(file, "cannot be written: it is a folder");
  for (size_t i = 0; i < written.size(); ++i) write_clip(files[i], written[i], scene);
}

void write_scene(const std::string& path, const Scene& scene) {
  const std::string extension = extension_of(path);
  if (extension == "glb") return write_glb(path, {}, &scene);
  if (extension == "ply") return write_ply(path, scene);
  throw Error(path, "is no scene format inhabit writes (.glb .ply)");
}

}  // namespace inhabit
