#include "inhabit/data/import_gta_im.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "inhabit/data/import_set.h"
#include "inhabit/data/import_smpl.h"
#include "inhabit/error.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/pickle.h"
#include "inhabit/io/upright.h"
#include "inhabit/motion/usual_skeleton.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

constexpr int64_t kGtaPiece = 1000;  ///< frames that have a cloud together
constexpr int64_t kGtaTestRooms[] = {10, 11, 13};

// The release's 21 joints; it counts the spine from the neck down, the tree here from the pelvis up.
const std::vector<std::string> kGtaNames = {
    "head",          "neck",       "right_clavicle", "right_shoulder", "right_elbow", "right_wrist", "left_clavicle",
    "left_shoulder", "left_elbow", "left_wrist",     "spine4",         "spine3",      "spine2",      "spine1",
    "pelvis",        "right_hip",  "right_knee",     "right_ankle",    "left_hip",    "left_knee",   "left_ankle"};
const std::vector<int> kGtaParents = {1, 10, 10, 2, 3, 4, 10, 6, 7, 8, 11, 12, 13, 14, -1, 14, 15, 16, 14, 18, 19};

/// Frames a second: that of a folder called FPS-5 on the way, else the paper's 30.
double gta_rate(const std::string& folder) {
  for (const fs::path& part : fs::path(folder))
    if (const std::string name = part.string();
        name.rfind("FPS-", 0) == 0 && name.size() < 8 && name.find_first_not_of("0123456789", 4) == std::string::npos)
      return std::max(1, std::atoi(name.c_str() + 4));
  return 30;
}

int64_t gta_room(const std::string& recording) {
  std::string file = recording + "/realtimeinfo.gz";
  if (!fs::exists(file)) file = recording + "/realtimeinfo.pickle";
  const Pickle pickle = read_pickle(file);
  return std::llround(pickle.number_at(pickle.at(*pickle.root, "setting"), "room"));
}

ImportedMotion read_gta_im(const std::string& recording, const ImportRecording& r) {
  const std::string path = recording + "/info_frames.npz";
  const UsualSkeleton usual = usual_skeleton(kGtaNames, kGtaParents, path);
  const std::vector<int64_t> order(usual.order.begin(), usual.order.end());
  ImportedMotion out;
  out.clip.skeleton = usual.skeleton;
  out.clip.rate = gta_rate(fs::absolute(recording).string());
  out.clip.joints = read_npz(path, {"joints_3d_world"})
                        .at("joints_3d_world", path)
                        .to(torch::kFloat64)
                        .slice(0, r.first, r.first + r.count)
                        .index_select(1, torch::tensor(order))
                        .to(torch::kFloat32);
  validate(out.clip, path);
  rotate_upright(out.clip);
  return out;
}

}  // namespace

// RECORDING/info_frames.npz, info_frames.pickle, realtimeinfo.gz (a pickle), NNNNN.png and NNNNN_id.png; metres, +Z up.
ImportSet open_gta_im(const std::string& folder, const ClipReadOptions&) {
  ImportSet set;
  set.splits = "the paper's rooms";
  std::vector<std::string> names;
  for (const std::string& path : files_below(folder, [](const std::string& f) { return f == "info_frames.npz"; }))
    names.push_back(fs::path(path).parent_path().lexically_relative(folder).generic_string());
  for (const std::string& name : names) {
    const std::string recording = (fs::path(folder) / name).string(), arrays = recording + "/info_frames.npz";
    try {
      const torch::Tensor joints = read_npz(arrays, {"joints_3d_world"}).at("joints_3d_world", arrays);
      if (joints.dim() != 3 || joints.size(1) != 21 || joints.size(2) != 3)
        throw Error(arrays, "its joints_3d_world is not (F, 21, 3)");
      const int64_t room = gta_room(recording), frames = joints.size(0);
      const bool test = std::find(std::begin(kGtaTestRooms), std::end(kGtaTestRooms), room) != std::end(kGtaTestRooms);
      if (!fs::exists(recording + "/info_frames.pickle")) throw Error(recording, "has no info_frames.pickle");
      // The last piece is the longest, as in the release.
      const int64_t pieces = std::max<int64_t>(1, frames / kGtaPiece);
      for (int64_t k = 0; k < pieces; ++k) {
        ImportRecording r{.name = name + "_sf" + std::to_string(k), .person = name, .split = test ? "test" : "train"};
        r.scene = r.name;
        r.first = k * kGtaPiece;
        r.count = k + 1 == pieces ? frames - r.first : kGtaPiece;
        set.recordings.push_back(std::move(r));
      }
    } catch (const Error& e) {
      set.broken.emplace_back(e.what());
    }
  }
  if (names.empty()) set.missing.emplace_back("RECORDING/info_frames.npz");
  set.read = [folder](const ImportRecording& r) { return read_gta_im(folder + "/" + r.person, r); };
  set.scene = [folder](const ImportRecording& r) {
    return gta_im_scene(folder + "/" + r.person, r.first, r.first + r.count);
  };
  return set;
}

}  // namespace inhabit
