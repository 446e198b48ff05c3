#include "inhabit/reconstruct/input_files.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/mesh.h"
#include "inhabit/io/scene_file.h"

namespace inhabit::reconstruct {
namespace {

namespace fs = std::filesystem;

/// Files of a folder in the order of their names.
std::vector<fs::path> files_in(const std::string& folder) {
  std::error_code failed;
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(folder, failed))
    if (entry.is_regular_file()) out.push_back(entry.path());
  if (failed) throw Error(folder, "is no folder that can be read");
  std::sort(out.begin(), out.end());
  return out;
}

/// Whether a mask's name is an object's, alone or before "_" and a frame's number. @param number -1: it stands alone
bool is_mask_of(const std::string& mask, const std::string& object, int64_t& number) {
  number = -1;
  if (mask == object) return true;
  if (mask.rfind(object + "_", 0) != 0) return false;
  const std::string digits = mask.substr(object.size() + 1);
  if (digits.empty() || digits.size() > 15 || digits.find_first_not_of("0123456789") != std::string::npos) return false;
  number = std::stoll(digits);
  return true;
}

std::vector<ObjectInput> open_objects(const InputFiles& files, int64_t first, const Camera& camera) {
  std::vector<ObjectInput> out;
  std::vector<fs::path> meshes;
  for (const fs::path& path : files_in(files.objects))
    if (is_scene_extension(extension_of(path.string()))) meshes.push_back(path);
  if (meshes.empty()) throw Error(files.objects, "holds no meshes");
  std::map<std::string, std::vector<NumberedFile>> masks;
  for (const fs::path& path : files_in(files.object_masks)) {
    if (extension_of(path.string()) != "png") continue;
    // "chair_1.png" is of "chair_1" where there is such an object, else frame 1 of "chair".
    std::string owner;
    NumberedFile file{path.string(), 0};
    for (const fs::path& mesh : meshes) {
      int64_t number = 0;
      const std::string name = mesh.stem().string();
      if (name.size() < owner.size() || !is_mask_of(path.stem().string(), name, number)) continue;
      owner = name;
      file.number = number;
    }
    if (owner.empty()) throw Error(path.string(), "is named after no mesh in " + files.objects);
    masks[owner].push_back(file);
  }
  for (const fs::path& path : meshes) {
    ObjectInput object;
    object.name = path.stem().string();
    object.meshes = read_meshes(path.string());
    for (Mesh& mesh : object.meshes) drop_degenerate_faces(mesh);
    std::vector<NumberedFile>& own = masks[object.name];
    if (own.empty())
      throw Error(path.string(),
                  "has no mask: " + object.name + ".png or " + object.name + "_NUMBER.png in " + files.object_masks);
    std::sort(own.begin(), own.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
    const bool alone = own.front().number < 0;
    if (alone && own.size() > 1) throw Error(own.front().path, "is of every frame, but there are masks of single ones");
    object.masks = open_masks(own, alone ? -1 : first, camera.height, camera.width);
    object.masks.every_frame = alone;
    if (alone) object.masks.frames.clear();
    out.push_back(std::move(object));
  }
  return out;
}

}  // namespace

Inputs open_inputs(const InputFiles& files, const ClipReadOptions& reading, Notes* notes) {
  if (files.objects.empty() != files.object_masks.empty())
    throw Error(files.objects.empty() ? "--object-masks" : "--objects", "meshes and their masks go together");
  Inputs out;
  out.camera = read_camera(files.camera);
  const Camera& camera = out.camera;
  const std::vector<NumberedFile> depth = numbered_files(files.depth);
  const int64_t first = depth.front().number;
  out.depth = open_depth(depth, first, camera.height, camera.width);
  out.masks = open_masks(numbered_files(files.masks), first, camera.height, camera.width);
  if (!files.objects.empty()) out.objects = open_objects(files, first, camera);
  out.motion = read_clip(files.motion, reading, notes);
  return out;
}

}  // namespace inhabit::reconstruct
