#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "inhabit/data/import_frames.h"
#include "inhabit/data/import_smpl.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"
#include "inhabit/io/number_text.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/upright.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/level.h"
#include "inhabit/scene/floor.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

/// The pickles "t0012.033/person/fit01/person_fit.pkl", by their times: the folder's name is seconds.
std::vector<FrameFile> couch_frames(const std::string& sequence) {
  return frames_in(sequence, [](const fs::path& entry) -> std::optional<FrameFile> {
    const std::string name = entry.filename().string();
    double seconds = 0;
    if (name.size() < 2 || name[0] != 't' || !parse_number(std::string_view(name).substr(1), seconds) ||
        !(seconds >= 0 && seconds < 1e6))
      return std::nullopt;
    const fs::path fit = entry / "person/fit01/person_fit.pkl";
    if (!fs::exists(fit)) return std::nullopt;
    return FrameFile{std::llround(seconds * 30), fit.string()};
  });
}

/// The rotation that puts a person of camera axes upright: first by the trunk of the frames in which the pelvis is
/// high, for who sits leans, then by the feet that stand.
torch::Tensor upright_rotation(Clip clip) {
  torch::Tensor rotation = torch::eye(3);
  const auto put_up = [&](const Eigen::Vector3d& up) {
    const torch::Tensor by = rotation_upright(up);
    rotate_clip(clip, by);
    rotation = by.matmul(rotation);
  };
  for (int pass = 0; pass < 2; ++pass) {
    Clip high = clip;
    if (pass == 1) {  // the upper half of the frames
      const torch::Tensor height = clip.joints.select(1, 0).select(1, 1);
      const torch::Tensor frames = torch::nonzero(height >= height.median()).flatten();
      high.joints = clip.joints.index_select(0, frames);
    }
    const auto trunk = mean_trunk(high);
    if (!trunk) break;
    put_up(*trunk);
  }
  const FloorSlope slope = floor_slope(clip);
  if (slope.stances >= FloorSlope::kLeastStances) put_up(slope.normal);
  return rotation;
}

/// The folder of a frame, from its pickle.
fs::path frame_folder(const FrameFile& frame) { return fs::path(frame.path).parent_path().parent_path().parent_path(); }

/// A frame's mesh of an object.
std::string registered_mesh(const FrameFile& frame, const std::string& object) {
  return (frame_folder(frame) / object / "fit01" / (object + "_fit.ply")).string();
}

/// What the first of the frames has as registered meshes besides the person.
std::vector<std::string> registered_objects(const std::vector<FrameFile>& frames) {
  std::vector<std::string> out;
  std::error_code refused;
  for (fs::directory_iterator entry(frame_folder(frames.front()), refused), end; !refused && entry != end;
       entry.increment(refused)) {
    const std::string name = entry->path().filename().string();
    if (name != "person" && fs::exists(registered_mesh(frames.front(), name))) out.push_back(name);
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// (N, 3) of all meshes in a file, in the camera's axes; empty where there is no such file.
Eigen::MatrixX3d registered_vertices(const std::string& path) {
  Eigen::MatrixX3d out(0, 3);
  if (!fs::exists(path)) return out;
  for (const Mesh& mesh : read_scene_file(path, {.up = UpAxis::y, .scale = 1}).scene.meshes) {
    const torch::Tensor v = mesh.vertices.to(torch::kDouble).contiguous();
    const Eigen::Index before = out.rows();
    out.conservativeResize(before + v.size(0), 3);
    out.bottomRows(v.size(0)) =
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(v.data_ptr<double>(), v.size(0), 3);
  }
  return out;
}

/// Where the objects are, frame by frame: carried from their meshes in the first frame, where the scene has them, by
/// the rigid motion that fits best. In a frame without their mesh, or with another, they stay where they were. What an
/// object's own axes are is not told: it faces as the person does when their pelvis is lowest.
void add_object_poses(Clip& clip, const torch::Tensor& upright, const std::vector<FrameFile>& frames) {
  const torch::Tensor up = upright.to(torch::kDouble).contiguous();
  const Eigen::Matrix3d to_upright =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(up.data_ptr<double>());
  const auto lowest = static_cast<size_t>(clip.joints.select(1, 0).select(1, 1).argmin().item<int64_t>());
  const Eigen::AngleAxisd faces(heading(clip, static_cast<int64_t>(lowest)), Eigen::Vector3d::UnitY());
  std::vector<torch::Tensor> poses;
  for (const std::string& name : registered_objects(frames)) {
    const Eigen::MatrixX3d first = registered_vertices(registered_mesh(frames.front(), name));
    if (first.rows() < 3) continue;
    std::vector<Eigen::Isometry3d> moved;
    for (const FrameFile& frame : frames) {
      moved.push_back(moved.empty() ? Eigen::Isometry3d::Identity() : moved.back());
      const Eigen::MatrixX3d now = registered_vertices(registered_mesh(frame, name));
      if (now.rows() != first.rows()) continue;
      moved.back().matrix() = Eigen::umeyama(first.transpose(), now.transpose(), false);
    }
    const Eigen::Vector3d middle = first.colwise().mean();
    const Eigen::Matrix3d own = (to_upright * moved[lowest].linear()).transpose() * faces.toRotationMatrix();
    torch::Tensor pose = torch::zeros({static_cast<int64_t>(frames.size()), 6});
    auto row = pose.accessor<float, 2>();
    for (size_t t = 0; t < frames.size(); ++t) {
      const Eigen::Vector3d place = to_upright * (moved[t] * middle);
      const Eigen::AngleAxisd rotation(to_upright * moved[t].linear() * own);
      const Eigen::Vector3d angles = rotation.angle() * rotation.axis();
      for (int i = 0; i < 3; ++i) {
        row[static_cast<int64_t>(t)][i] = static_cast<float>(place[i]);
        row[static_cast<int64_t>(t)][3 + i] = static_cast<float>(angles[i]);
      }
    }
    clip.object_names.push_back(name);
    poses.push_back(pose);
  }
  if (!poses.empty()) clip.object_pose = torch::stack(poses, 1);
}

struct CouchMotion {
  ImportedMotion motion;
  torch::Tensor rotation;  ///< (3, 3), of the camera's axes to +Y up
};

std::string text_of(const nlohmann::json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

nlohmann::json info_of(const std::string& sequence) {
  const std::string path = sequence + "/info.json";
  return fs::exists(path) ? parse_json(read_whole_file(path, 16 << 20), path) : nlohmann::json();
}

/// @param objects whether to look where they are: a mesh a frame and object is read
CouchMotion read_couch(const std::string& sequence, const ImportRecording& recording, const ClipReadOptions& reading,
                       bool objects) {
  std::vector<FrameFile> frames = couch_frames(sequence);
  keep_piece(frames, recording);
  const Npz rows = rows_of(frames, {"pose", "trans"}, {"betas"});
  Npz npz;
  npz.tensors["poses"] = rows.tensors.at("pose");
  npz.tensors["trans"] = rows.tensors.at("trans");
  if (rows.has("betas")) npz.tensors["betas"] = rows.tensors.at("betas");
  npz.tensors["mocap_framerate"] = torch::tensor(30.0);
  const std::string gender = text_of(info_of(sequence), "gender");
  if (!gender.empty()) npz.strings["gender"] = {{}, {gender}};
  CouchMotion out{smpl_motion(npz, sequence, reading, false), {}};
  out.rotation = upright_rotation(out.motion.clip);
  rotate_clip(out.motion.clip, out.rotation);
  if (objects) add_object_poses(out.motion.clip, out.rotation, frames);
  fill_missing(out.motion, frames);
  return out;
}

}  // namespace

// sequences/NAME/tSECONDS/person/fit01/person_fit.pkl: SMPL-H in the axes of a camera, beside it the registered meshes
// of objects; split.json. The layout of BEHAVE, which is by the same group and public.
ImportSet open_couch(const std::string& folder, const ClipReadOptions& reading) {
  ImportSet set;
  std::map<std::string, std::string> split_of, folders;
  const std::string splits = folder + "/split.json";
  if (fs::exists(splits)) {
    const nlohmann::json told = parse_json(read_whole_file(splits, 16 << 20), splits);
    for (const char* split : {"train", "test"})
      if (told.is_object() && told.contains(split) && told[split].is_array())
        for (const nlohmann::json& name : told[split])
          if (name.is_string()) split_of[name.get<std::string>()] = split;
    set.splits = "the owners' (split.json)";
  } else {
    set.missing.emplace_back("split.json");
  }
  std::vector<std::string> names;
  std::error_code refused;
  const std::string sequences = folder + "/sequences";
  for (fs::directory_iterator entry(sequences, refused), end; !refused && entry != end; entry.increment(refused))
    if (entry->is_directory(refused)) names.push_back(entry->path().filename().string());
  if (names.empty()) set.missing.emplace_back("sequences/");
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    const std::string sequence = (fs::path(sequences) / name).string();
    ImportRecording recording{.name = name};
    // BEHAVE's names are Date01_Sub01_chairwood_sit.
    if (const size_t at = name.find("Sub"); at != std::string::npos)
      recording.person = name.substr(at, name.find('_', at) - at);
    if (const auto found = split_of.find(name); found != split_of.end()) recording.split = found->second;
    const std::vector<ImportRecording> pieces = pieces_of(recording, couch_frames(sequence));
    if (pieces.empty()) set.broken.push_back(sequence + ": no two frames of a person are within half a second");
    for (const ImportRecording& piece : pieces) {
      set.recordings.push_back(piece);
      std::vector<FrameFile> frames = couch_frames(sequence);
      keep_piece(frames, piece);
      // Each piece is put upright by itself.
      if (!registered_objects(frames).empty()) set.recordings.back().scene = piece.name;
      folders[piece.name] = sequence;
    }
  }
  set.read = [folders, reading](const ImportRecording& recording) {
    return read_couch(folders.at(recording.name), recording, reading, true).motion;
  };
  set.scene = [folders, reading](const ImportRecording& recording) {
    const std::string& sequence = folders.at(recording.name);
    const CouchMotion read = read_couch(sequence, recording, reading, false);
    torch::Tensor transform = torch::eye(4);
    transform.narrow(0, 0, 3).narrow(1, 0, 3).copy_(read.rotation);
    Scene out = assumed_floor(read.motion.clip);
    std::vector<FrameFile> frames = couch_frames(sequence);
    keep_piece(frames, recording);
    for (const std::string& name : registered_objects(frames)) {
      const std::string path = registered_mesh(frames.front(), name);
      Scene object = moved_scene(read_scene_file(path, {.up = UpAxis::y, .scale = 1}).scene, transform);
      for (Mesh& mesh : object.meshes) mesh.name = name;
      out.meshes.insert(out.meshes.end(), object.meshes.begin(), object.meshes.end());
    }
    return out;
  };
  return set;
}

}  // namespace inhabit
