#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>

#include "inhabit/data/import_frames.h"
#include "inhabit/data/vposer.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"
#include "inhabit/io/number_text.h"
#include "inhabit/io/scene_file.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

constexpr const char* kVposerFile = "vposer_v1_0/snapshots/TR00_E096.pt";
constexpr uint64_t kLargestTable = uint64_t{64} << 20;

/// A row of dataset.csv.
struct GimoTake {
  std::string folder;     ///< of the recording
  std::string transform;  ///< file in it
  std::string scene;      ///< folder
  double scale = 1;       ///< metres of the scan that are a metre
};

/// Cells of a line; GIMO quotes none.
std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> out;
  for (size_t at = 0; at <= line.size();) {
    const size_t end = std::min(line.find(',', at), line.size());
    std::string_view cell = line.substr(at, end - at);
    while (!cell.empty() && (cell.back() == '\r' || cell.back() == ' ')) cell.remove_suffix(1);
    out.emplace_back(cell);
    at = end + 1;
  }
  return out;
}

std::vector<FrameFile> gimo_frames(const std::string& take, int64_t first, int64_t end) {
  return frames_in(take + "/smplx_local", [&](const fs::path& entry) -> std::optional<FrameFile> {
    const std::string digits = entry.stem().string();
    if (entry.extension() != ".pkl" || digits.empty() || digits.size() > 9 ||
        digits.find_first_not_of("0123456789") != std::string::npos)
      return std::nullopt;
    const int64_t number = std::stoll(digits);
    if (number < first || number >= end) return std::nullopt;
    return FrameFile{number, entry.string()};
  });
}

nlohmann::json transform_of(const GimoTake& take) {
  const std::string path = take.folder + "/" + take.transform;
  return parse_json(read_whole_file(path, 1 << 20), path);
}

double scale_of(const GimoTake& take) {
  const nlohmann::json told = transform_of(take);
  const auto found = told.is_object() ? told.find("scale") : told.end();
  const bool number = told.is_object() && found != told.end() && found->is_number();
  const double scale = number ? found->get<double>() : 0;
  if (!(scale > 0.1 && scale < 10)) throw Error(take.folder + "/" + take.transform, "its scale is no number near 1");
  return scale;
}

/// The scan's place in the world, y up, metres of the scan.
torch::Tensor canonical(const std::string& folder, const GimoTake& take) {
  const std::string path = folder + "/" + take.scene + "/scene_obj/transform_norm.txt";
  const std::string text = read_whole_file(path, 1 << 16);
  std::string_view rest = text;
  std::vector<double> numbers;
  for (std::string_view token = next_token(rest); !token.empty(); token = next_token(rest)) {
    double number = 0;
    if (!parse_number(token, number)) throw Error(path, "is no matrix of 16 numbers");
    numbers.push_back(number);
  }
  return rigid_transform(torch::tensor(numbers, torch::kFloat64), path);
}

/// A transform of metres of the scan, of a person's metres.
torch::Tensor in_metres(torch::Tensor transform, double scale) {
  transform = transform.clone();
  transform.narrow(0, 0, 3).select(1, 3).div_(scale);
  return transform;
}

ImportedMotion read_gimo(const std::string& folder, const ImportRecording& recording, const GimoTake& take,
                         const Vposer& vposer, const ClipReadOptions& reading) {
  const std::string path = take.folder + "/" + take.transform;
  const nlohmann::json told = transform_of(take);
  const auto found = told.find("transformation");
  if (found == told.end()) throw Error(path, "has no \"transformation\"");
  const torch::Tensor to_scan = rigid_transform(numbers_of(*found, path), path);
  const torch::Tensor to_world = in_metres(canonical(folder, take), take.scale).matmul(in_metres(to_scan, take.scale));
  std::vector<FrameFile> frames = gimo_frames(take.folder, recording.first, recording.first + recording.count);
  keep_piece(frames, recording);
  const Npz rows = rows_of(frames, {"orient", "trans", "latent"}, {"beta", "jaw_pose", "expression", "lhand", "rhand"});
  if (rows.tensors.at("latent").size(1) != 32) throw Error(frames[0].path, "its latent is not VPoser's 32 numbers");
  Npz npz;
  const std::pair<const char*, const char*> names[] = {
      {"orient", "global_orient"}, {"trans", "transl"},          {"beta", "betas"},           {"jaw_pose", "jaw_pose"},
      {"lhand", "left_hand_pose"}, {"rhand", "right_hand_pose"}, {"expression", "expression"}};
  for (const auto& [from, to] : names)
    if (rows.has(from)) npz.tensors[to] = rows.tensors.at(from);
  npz.tensors["body_pose"] = vposer.decode(rows.tensors.at("latent"));
  ImportedMotion out = smplx_motion(npz, take.folder, reading);
  move_clip(out.clip, to_world);
  fill_missing(out, frames);
  return out;
}

}  // namespace

// dataset.csv: a recording, its first and last frame, its scene, the file that places it there and whether it is for
// training. SCENE/scene_obj has the scan and its place, SCENE/RECORDING/smplx_local a pickle a frame, 30 Hz: SMPL-X
// with VPoser's codes. People are metric, scans are not quite: each recording says by how much, and gets its scan so.
ImportSet open_gimo(const std::string& folder, const ClipReadOptions& reading) {
  ImportSet set;
  set.splits = "the owners' (dataset.csv)";
  const std::string table = folder + "/dataset.csv";
  if (!fs::exists(table)) {
    set.missing.emplace_back("dataset.csv");
    return set;
  }
  const std::string text = read_whole_file(table, kLargestTable);
  std::string_view rest = text;
  if (rest.substr(0, 3) == "\xEF\xBB\xBF") rest.remove_prefix(3);
  const std::vector<std::string> header = cells_of(next_line(rest));
  const auto column = [&](const char* name) {
    const auto found = std::find(header.begin(), header.end(), name);
    if (found == header.end()) throw Error(table, "has no column \"" + std::string(name) + "\"");
    return static_cast<size_t>(found - header.begin());
  };
  const size_t sequence = column("sequence_path"), first = column("start_frame"), last = column("end_frame"),
               scene = column("scene"), transform = column("transformation"), training = column("training");
  std::map<std::string, GimoTake> takes;
  while (!rest.empty()) {
    const std::vector<std::string> cells = cells_of(next_line(rest));
    if (cells.size() == 1 && cells[0].empty()) continue;
    if (cells.size() != header.size()) {
      set.broken.push_back(table + ": a line has another number of cells than the first");
      continue;
    }
    double from = 0, to = 0;
    GimoTake take{folder + "/" + cells[scene] + "/" + cells[sequence], cells[transform], cells[scene], 1};
    const bool inside = (cells[scene] + cells[sequence] + cells[transform]).find("..") == std::string::npos;
    if (!parse_number(cells[first], from) || !parse_number(cells[last], to) || !(from >= 0 && from < to && to < 1e9) ||
        !inside) {
      set.broken.push_back(take.folder + ": its line in dataset.csv is wrong");
      continue;
    }
    ImportRecording recording{.name = cells[scene] + "/" + cells[sequence] + "_" + cells[first]};
    const bool trained = cells[training] == "1" || cells[training] == "True" || cells[training] == "TRUE";
    recording.split = trained ? "train" : "test";
    try {
      take.scale = scale_of(take);
    } catch (const Error& e) {
      set.broken.emplace_back(e.what());
      continue;
    }
    char scale[32];
    std::snprintf(scale, sizeof scale, "%.4f", take.scale);
    recording.scene = cells[scene] + "_" + scale;
    for (const ImportRecording& piece :
         pieces_of(recording, gimo_frames(take.folder, static_cast<int64_t>(from), static_cast<int64_t>(to)))) {
      if (!takes.emplace(piece.name, take).second) continue;
      set.recordings.push_back(piece);
    }
  }
  const std::string weights = folder + "/" + kVposerFile;
  if (!fs::exists(weights))
    set.missing.push_back(std::string(kVposerFile) + " (VPoser 1.0, which turns codes into poses)");
  const auto vposer = std::make_shared<std::pair<std::once_flag, Vposer>>();
  set.read = [folder, takes, reading, weights, vposer](const ImportRecording& recording) {
    std::call_once(vposer->first, [&] { vposer->second = read_vposer(weights); });
    return read_gimo(folder, recording, takes.at(recording.name), vposer->second, reading);
  };
  set.scene = [folder, takes](const ImportRecording& recording) {
    const GimoTake& take = takes.at(recording.name);
    const std::string scan = folder + "/" + take.scene + "/scene_obj/";
    const char* file = fs::exists(scan + "textured_output.obj") ? "textured_output.obj" : "scene_downsampled.ply";
    return moved_scene(read_scene_file(scan + file, {.up = UpAxis::y, .scale = 1 / take.scale}).scene,
                       in_metres(canonical(folder, take), take.scale));
  };
  return set;
}

}  // namespace inhabit
