#include "inhabit/data/import_trumans.h"

#include <filesystem>
#include <map>

#include "inhabit/data/import_smpl.h"
#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/npy_format.h"
#include "inhabit/io/scene_file.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

constexpr SceneReadOptions kTrumansScene = {.up = UpAxis::y, .scale = 1};

/// The mesh of a scene or an object, whose name may be that of a file; empty where there is none.
std::string mesh_file(const std::string& folder, const std::vector<std::string>& places, const std::string& name) {
  const std::string stem = fs::path(name).stem().string();
  for (const std::string& place : places)
    for (const char* extension : {".obj", ".glb", ".ply"})
      if (std::string path = folder; fs::exists(path.append("/").append(place).append("/" + stem + extension)))
        return path;
  return "";
}

const std::vector<std::string> kRooms = {"Scene_mesh", "Scene"},
                               kPieces = {"Object_chairs/Object_mesh", "Object_mesh", "Object_all/Object_mesh"};

ImportedMotion read_trumans(const std::string& folder, const ImportRecording& r, const ClipReadOptions& reading) {
  Npz npz;
  const auto rows = [&](const char* file, const char* name, bool needed) {
    const std::string path = folder + "/" + file;
    if (!needed && !fs::exists(path)) return;
    npz.tensors[name] = read_npy_rows(path, r.first, r.count).at("arr_0", path);
    if (npz.tensors[name].size(0) != r.count) throw Error(path, "has not a row for each of seg_name.npy");
  };
  rows("human_orient.npy", "global_orient", true);
  rows("human_pose.npy", "body_pose", true);
  rows("human_transl.npy", "transl", true);
  rows("left_hand_pose.npy", "left_hand_pose", false);
  rows("right_hand_pose.npy", "right_hand_pose", false);
  npz.tensors["mocap_framerate"] = torch::tensor(30.0);
  npz.strings["surface_model_type"] = {{}, {"smplx"}};
  const std::string about = folder + ": " + r.name;
  ImportedMotion out = smpl_motion(npz, about, reading, false);
  std::vector<torch::Tensor> poses;
  for (const TrumansObject& object : trumans_objects(folder, r.first, r.count)) {
    out.clip.object_names.push_back(object.name);
    poses.push_back(object.pose);
  }
  if (!poses.empty()) out.clip.object_pose = torch::stack(poses, 1);
  return out;
}

/// The room, and the objects of a recording where each stands for the longest time.
Scene trumans_scene(const std::string& folder, const ImportRecording& r, const std::string& room) {
  Scene scene = read_scene_file(room, kTrumansScene).scene;
  for (const TrumansObject& object : trumans_objects(folder, r.first, r.count)) {
    const std::string path = mesh_file(folder, kPieces, object.name);
    if (path.empty()) throw Error(folder, "has no mesh of object " + object.name);
    int part = 0;
    for (Mesh mesh : read_scene_file(path, kTrumansScene).scene.meshes) {
      const torch::Tensor rotation = object.at_most.narrow(0, 0, 3).narrow(1, 0, 3);
      mesh.vertices = mesh.vertices.matmul(rotation.t()) + object.at_most.select(1, 3).narrow(0, 0, 3);
      mesh.name = object.name + (part == 0 ? "" : "." + std::to_string(part));
      scene.meshes.push_back(std::move(mesh));
      ++part;
    }
  }
  return scene;
}

/// Recordings as .npz in a furnished room, room.glb.
void add_single_recordings(const std::string& folder, ImportSet& set, const ClipReadOptions& reading) {
  for (const auto& entry : fs::directory_iterator(folder))
    if (extension_of(entry.path().string()) == "npz")
      set.recordings.push_back({.name = entry.path().stem().string(), .scene = "room"});
  if (set.recordings.empty()) return;
  if (!fs::exists(folder + "/room.glb")) throw Error(folder, "has recordings (.npz) but no room.glb");
  set.read = [folder, reading](const ImportRecording& r) {
    const std::string path = folder + "/" + r.name + ".npz";
    return smpl_motion(read_npz(path), path, reading, false);
  };
  set.scene = [folder](const ImportRecording&) { return read_scene_file(folder + "/room.glb", kTrumansScene).scene; };
}

}  // namespace

// human_pose.npy (N, 63), human_orient.npy and human_transl.npy (N, 3): SMPL-X, 30 Hz, +Y up, of all motions one after
// the other; seg_name.npy and scene_flag.npy (N) tell which motion and scene a row is of; bad_frames.npy rows to be
// left out; Scene_mesh/SCENE.obj; object_flag.npy (N, objects) slots of object_mat.npy (N, slots, 4, 4), below 0 for
// none.
ImportSet open_trumans(const std::string& folder, const ClipReadOptions& reading) {
  ImportSet set;
  if (!fs::exists(folder + "/human_pose.npy")) {
    add_single_recordings(folder, set, reading);
    if (set.recordings.empty()) set.missing.emplace_back("human_pose.npy");
    return set;
  }
  for (const char* needed :
       {"human_orient.npy", "human_transl.npy", "seg_name.npy", "scene_flag.npy", "scene_list.npy"})
    if (!fs::exists(folder + "/" + needed)) throw Error(folder, std::string("has no ") + needed);
  const bool objects = fs::exists(folder + "/object_flag.npy") && fs::exists(folder + "/object_mat.npy");
  if (!objects)
    set.missing.emplace_back("object_flag.npy, object_mat.npy: chairs that people move are not in the scenes");
  const std::string list = folder + "/scene_list.npy";
  const Npz listed = read_npz(list);
  const auto scenes = listed.strings.find("arr_0");
  if (scenes == listed.strings.end()) throw Error(list, "holds no names");
  std::map<std::string, std::string> rooms, room_of;  // file of each scene, and of that of each recording
  std::map<std::string, int> pieces;
  for (const TrumansPiece& piece : trumans_pieces(folder)) {
    if (piece.scene < 0 || piece.scene >= static_cast<int64_t>(scenes->second.values.size())) {
      set.broken.push_back(folder + ": " + piece.segment + ": its scene is not in scene_list.npy");
      continue;
    }
    const std::string& scene = scenes->second.values[static_cast<size_t>(piece.scene)];
    if (rooms.count(scene) == 0) {
      rooms[scene] = mesh_file(folder, kRooms, scene);
      if (rooms[scene].empty()) set.missing.push_back("Scene_mesh/" + fs::path(scene).stem().string() + ".obj");
    }
    if (rooms[scene].empty()) {
      set.broken.push_back(folder + ": " + piece.segment + ": the mesh of its scene is missing");
      continue;
    }
    const int number = pieces[piece.segment]++;
    ImportRecording r{.name = piece.segment + (number == 0 ? "" : "_" + std::to_string(number))};
    // Copies of a recording with other objects go where it goes: by person is not told.
    r.person = piece.segment.substr(0, piece.segment.find("_augment"));
    r.first = piece.first;
    r.count = piece.count;
    r.scene = fs::path(scene).stem().string() + (objects ? "_" + r.name : "");
    room_of[r.name] = rooms[scene];
    set.recordings.push_back(std::move(r));
  }
  set.read = [folder, reading](const ImportRecording& r) { return read_trumans(folder, r, reading); };
  set.scene = [folder, room_of](const ImportRecording& r) { return trumans_scene(folder, r, room_of.at(r.name)); };
  return set;
}

}  // namespace inhabit
