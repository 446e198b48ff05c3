#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "inhabit/data/import_frames.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/upright.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

// Zhang et al. 2020's split, which the paper follows (sec. 4.1); all other scenes are trained on.
constexpr std::array kProxTest = {"MPH16", "MPH1Library", "N0SittingBooth", "N3OpenArea"};
constexpr std::array kProxWomen = {"00162", "03452", "00159", "03403"};  // people; the others are men

std::string scene_of(const ImportRecording& r) { return "scenes/" + r.scene + ".ply"; }
std::string camera_of(const ImportRecording& r) { return "cam2world/" + r.scene + ".json"; }

/// The pickles of "s001_frame_00012__00.00.00.426/000.pkl", by their numbers (12).
std::vector<FrameFile> prox_frames(const std::string& results) {
  return frames_in(results, [](const fs::path& entry) -> std::optional<FrameFile> {
    const std::string name = entry.filename().string();
    const size_t at = name.find("frame_");
    const size_t digits = at == std::string::npos ? 0 : name.find_first_not_of("0123456789", at + 6) - (at + 6);
    if (at == std::string::npos || digits == 0 || digits > 9 || !fs::exists(entry / "000.pkl")) return std::nullopt;
    return FrameFile{std::stoll(name.substr(at + 6, digits)), (entry / "000.pkl").string()};
  });
}

ImportedMotion read_prox(const std::string& folder, const ImportRecording& recording, const std::string& results,
                         const ClipReadOptions& reading) {
  const std::string camera = folder + "/" + camera_of(recording);
  const torch::Tensor to_world =
      rigid_transform(numbers_of(parse_json(read_whole_file(camera, 1 << 20), camera), camera), camera);
  std::vector<FrameFile> frames = prox_frames(results);
  keep_piece(frames, recording);
  Npz npz = rows_of(frames, {"transl", "global_orient", "body_pose"},
                    {"jaw_pose", "left_hand_pose", "right_hand_pose", "expression", "betas"});
  const std::string person = recording.person;
  const bool woman = std::find(kProxWomen.begin(), kProxWomen.end(), person) != kProxWomen.end();
  npz.strings["gender"] = {{}, {woman ? "female" : "male"}};
  ImportedMotion out = smplx_motion(npz, results, reading);
  move_clip(out.clip, to_world);
  rotate_upright(out.clip);
  fill_missing(out, frames);
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
    for (const ImportRecording& piece : pieces_of(recording, prox_frames(place))) {
      set.recordings.push_back(piece);
      results[piece.name] = place;
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
