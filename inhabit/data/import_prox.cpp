#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "inhabit/data/import_set.h"
#include "inhabit/data/import_smpl.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"
#include "inhabit/io/pickle.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/upright.h"
#include "inhabit/motion/level.h"
#include "inhabit/motion/resample.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

constexpr int64_t kLongestGap = 15;  ///< frames at 30 Hz that are filled by interpolation
constexpr double kProxRate = 30;
// Zhang et al. 2020's split, which the paper follows (sec. 4.1); all other scenes are trained on.
constexpr std::array kProxTest = {"MPH16", "MPH1Library", "N0SittingBooth", "N3OpenArea"};
constexpr std::array kProxWomen = {"00162", "03452", "00159", "03403"};  // people; the others are men

std::string scene_of(const ImportRecording& r) { return "scenes/" + r.scene + ".ply"; }
std::string camera_of(const ImportRecording& r) { return "cam2world/" + r.scene + ".json"; }

/// A frame's folder, "s001_frame_00012__00.00.00.426", and its number, 12.
struct ProxFrame {
  int64_t number = 0;
  std::string folder;
};

std::vector<ProxFrame> prox_frames(const std::string& results) {
  std::vector<ProxFrame> out;
  std::error_code refused;
  for (fs::directory_iterator entry(results, refused), end; !refused && entry != end; entry.increment(refused)) {
    const std::string name = entry->path().filename().string();
    const size_t at = name.find("frame_");
    const size_t digits = at == std::string::npos ? 0 : name.find_first_not_of("0123456789", at + 6) - (at + 6);
    if (at == std::string::npos || digits == 0 || digits > 9) continue;
    if (!fs::exists(entry->path() / "000.pkl")) continue;
    out.push_back({std::stoll(name.substr(at + 6, digits)), entry->path().string()});
  }
  std::sort(out.begin(), out.end(), [](const ProxFrame& a, const ProxFrame& b) { return a.number < b.number; });
  return out;
}

/// (4, 4) of a camera's place in the scene.
torch::Tensor camera_to_world(const std::string& path) {
  const nlohmann::json rows = parse_json(read_whole_file(path, 1 << 20), path);
  torch::Tensor out = torch::zeros({4, 4});
  bool good = rows.is_array() && rows.size() == 4;
  for (size_t r = 0; good && r < 4; ++r) {
    good = rows[r].is_array() && rows[r].size() == 4;
    for (size_t c = 0; good && c < 4; ++c) {
      good = rows[r][c].is_number();
      if (good) out[static_cast<int64_t>(r)][static_cast<int64_t>(c)] = rows[r][c].get<float>();
    }
  }
  const torch::Tensor turn = out.narrow(0, 0, 3).narrow(1, 0, 3);
  if (!good || !torch::isfinite(out).all().item<bool>() ||
      (turn.matmul(turn.t()) - torch::eye(3)).abs().max().item<float>() > 1e-3F)
    throw Error(path, "is no rotation and place of a camera, 4 rows of 4 numbers");
  return out;
}

ImportedMotion read_prox(const std::string& folder, const ImportRecording& recording, const std::string& results,
                         const ClipReadOptions& reading) {
  const torch::Tensor to_world = camera_to_world(folder + "/" + camera_of(recording));
  std::map<std::string, std::vector<torch::Tensor>> rows;
  std::vector<int64_t> numbers;
  for (const ProxFrame& frame : prox_frames(results)) {
    if (frame.number < recording.first || frame.number >= recording.first + recording.count) continue;
    const std::string path = frame.folder + "/000.pkl";
    const Pickle pickle = read_pickle(path);
    numbers.push_back(frame.number);
    for (const char* name : {"transl", "global_orient", "body_pose", "jaw_pose", "left_hand_pose", "right_hand_pose",
                             "expression", "betas"}) {
      const bool needed =
          std::string(name) == "transl" || std::string(name) == "global_orient" || std::string(name) == "body_pose";
      if (needed || pickle.root->find(name) != nullptr)
        rows[name].push_back(pickle.numbers_at(*pickle.root, name).reshape({-1}));
    }
  }
  Npz npz;
  if (numbers.size() < 2) throw Error(results, "has fewer than two frames");
  for (const auto& entry : rows) {
    const std::vector<torch::Tensor>& all = entry.second;
    const bool alike =
        std::all_of(all.begin(), all.end(), [&](const torch::Tensor& row) { return row.sizes() == all[0].sizes(); });
    if (all.size() == numbers.size() && alike) npz.tensors[entry.first] = torch::stack(all);
  }
  const std::string person = recording.person;
  const bool woman = std::find(kProxWomen.begin(), kProxWomen.end(), person) != kProxWomen.end();
  npz.strings["gender"] = {{}, {woman ? "female" : "male"}};
  npz.strings["surface_model_type"] = {{}, {"smplx"}};
  npz.tensors["mocap_framerate"] = torch::tensor(kProxRate);
  // The hands are coefficients of the model's own basis, no angles: kept as they are, not posed.
  Npz body = npz;
  for (const char* name : {"left_hand_pose", "right_hand_pose"}) body.tensors.erase(name);
  ImportedMotion out = smpl_motion(body, results, reading, false);
  for (const char* name : {"left_hand_pose", "right_hand_pose", "jaw_pose"})
    if (npz.has(name)) out.more[name] = npz.tensors.at(name).to(torch::kFloat32);
  rotate_clip(out.clip, to_world.narrow(0, 0, 3).narrow(1, 0, 3).contiguous());
  const torch::Tensor shift = to_world.select(1, 3).narrow(0, 0, 3);
  out.clip.joints = out.clip.joints + shift;
  out.clip.trans = out.clip.trans + shift;
  turn_upright(out.clip);
  // Frames that are missing lie between their neighbours.
  const int64_t whole = numbers.back() - numbers.front() + 1;
  if (whole != static_cast<int64_t>(numbers.size())) {
    std::vector<double> at;
    std::vector<int64_t> nearest;
    for (size_t k = 0; k < numbers.size(); ++k) {
      const int64_t step = k + 1 < numbers.size() ? numbers[k + 1] - numbers[k] : 1;
      for (int64_t i = 0; i < step; ++i) {
        at.push_back(static_cast<double>(k) + static_cast<double>(i) / static_cast<double>(step));
        nearest.push_back(static_cast<int64_t>(k) + (2 * i >= step ? 1 : 0));
      }
    }
    out.clip = at_frames(out.clip, at);
    for (auto& [name, tensor] : out.more) tensor = tensor.index_select(0, torch::tensor(nearest));
  }
  return out;
}

}  // namespace

// scenes/SCENE.ply, cam2world/SCENE.json, fittings/SCENE_PERSON_TAKE/results/FRAME/000.pkl (or PROXD/ in place of
// fittings/): SMPL-X in the camera's axes, one pickle a frame, 30 Hz; the scene is +Z up.
ImportSet open_prox(const std::string& folder, const ClipReadOptions& reading) {
  ImportSet set;
  set.splits = "the paper's scenes";
  std::string fittings;
  for (const char* sub : {"/fittings", "/PROXD"})
    if (fittings.empty() && fs::is_directory(folder + sub)) fittings = folder + sub;
  if (fittings.empty()) set.missing.emplace_back("fittings/ (or PROXD/)");
  std::map<std::string, std::string> results;  // of each recording
  std::error_code refused;
  std::vector<std::string> names;
  if (!fittings.empty())
    for (const auto& entry : fs::directory_iterator(fittings, refused))
      names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    const size_t cut = name.find('_'), end = name.find('_', cut + 1);
    std::string place = fittings;
    place.append("/").append(name).append("/results");
    if (cut == std::string::npos || !fs::is_directory(place)) continue;
    ImportRecording recording{
        .name = name, .person = name.substr(cut + 1, end - cut - 1), .scene = name.substr(0, cut)};
    recording.split =
        std::find(kProxTest.begin(), kProxTest.end(), recording.scene) == kProxTest.end() ? "train" : "test";
    bool there = true;
    for (const std::string& needed : {scene_of(recording), camera_of(recording)}) {
      if (fs::exists(fs::path(folder) / needed)) continue;
      there = false;
      if (std::find(set.missing.begin(), set.missing.end(), needed) == set.missing.end()) set.missing.push_back(needed);
    }
    if (!there) {
      set.broken.push_back(place + ": its scene or camera is missing");
      continue;
    }
    // A piece for each stretch without a long gap.
    const std::vector<ProxFrame> frames = prox_frames(place);
    for (size_t first = 0, k = 1, piece = 0; k <= frames.size(); ++k) {
      if (k < frames.size() && frames[k].number - frames[k - 1].number <= kLongestGap) continue;
      recording.name = piece == 0 ? name : name + "_" + std::to_string(piece);
      recording.first = frames[first].number;
      recording.count = frames[k - 1].number - recording.first + 1;
      if (k - first >= 2) {
        set.recordings.push_back(recording);
        results[recording.name] = place;
        ++piece;
      }
      first = k;
    }
  }
  set.read = [folder, results, reading](const ImportRecording& recording) {
    return read_prox(folder, recording, results.at(recording.name), reading);
  };
  set.scene = [folder](const ImportRecording& recording) {
    return read_scene_file(folder + "/" + scene_of(recording), {.up = UpAxis::z, .scale = 1}).scene;
  };
  return set;
}

}  // namespace inhabit
