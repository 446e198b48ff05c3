#include "inhabit/data/import_frames.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "inhabit/data/import_smpl.h"
#include "inhabit/error.h"
#include "inhabit/io/pickle.h"
#include "inhabit/motion/level.h"
#include "inhabit/motion/resample.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

constexpr int64_t kLongestGap = 15;  ///< frames at 30 Hz that are filled by interpolation

}  // namespace

std::vector<FrameFile> frames_in(const std::string& folder,
                                 const std::function<std::optional<FrameFile>(const fs::path&)>& told) {
  std::vector<FrameFile> out;
  std::error_code refused;
  for (fs::directory_iterator entry(folder, refused), end; !refused && entry != end; entry.increment(refused))
    if (auto frame = told(entry->path())) out.push_back(std::move(*frame));
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return std::tie(a.number, a.path) < std::tie(b.number, b.path); });
  out.erase(std::unique(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.number == b.number; }),
            out.end());
  return out;
}

std::vector<ImportRecording> pieces_of(const ImportRecording& recording, const std::vector<FrameFile>& frames) {
  std::vector<ImportRecording> out;
  for (size_t first = 0, k = 1; k <= frames.size(); ++k) {
    if (k < frames.size() && frames[k].number - frames[k - 1].number <= kLongestGap) continue;
    if (k - first >= 2) {
      ImportRecording& piece = out.emplace_back(recording);
      if (out.size() > 1) piece.name += "_" + std::to_string(out.size() - 1);
      piece.first = frames[first].number;
      piece.count = frames[k - 1].number - piece.first + 1;
    }
    first = k;
  }
  return out;
}

void keep_piece(std::vector<FrameFile>& frames, const ImportRecording& recording) {
  std::erase_if(frames, [&](const FrameFile& frame) {
    return frame.number < recording.first || frame.number >= recording.first + recording.count;
  });
  if (frames.size() < 2) throw Error(recording.name, "has fewer than two frames");
}

Npz rows_of(const std::vector<FrameFile>& frames, const std::vector<std::string>& needed,
            const std::vector<std::string>& wanted) {
  std::map<std::string, std::vector<torch::Tensor>> rows;
  for (const FrameFile& frame : frames) {
    const Pickle pickle = read_pickle(frame.path);
    for (const std::string& name : needed) rows[name].push_back(pickle.numbers_at(*pickle.root, name).reshape({-1}));
    for (const std::string& name : wanted)
      if (pickle.root->find(name) != nullptr) rows[name].push_back(pickle.numbers_at(*pickle.root, name).reshape({-1}));
  }
  Npz out;
  for (const auto& [name, all] : rows) {
    size_t alike = 0;
    while (alike < all.size() && all[alike].sizes() == all[0].sizes()) ++alike;
    if (alike == frames.size()) {
      out.tensors[name] = torch::stack(all);
    } else if (std::find(needed.begin(), needed.end(), name) != needed.end()) {
      throw Error(frames[alike].path, "its " + name + " has another length than in the frames before");
    }
  }
  return out;
}

ImportedMotion smplx_motion(Npz rows, const std::string& subject, const ClipReadOptions& reading) {
  rows.strings["surface_model_type"] = {{}, {"smplx"}};
  rows.tensors["mocap_framerate"] = torch::tensor(30.0);
  std::map<std::string, torch::Tensor> kept;
  for (const char* name : {"left_hand_pose", "right_hand_pose", "jaw_pose"})
    if (rows.has(name)) kept[name] = rows.tensors.at(name).to(torch::kFloat32);
  for (const char* name : {"left_hand_pose", "right_hand_pose"}) rows.tensors.erase(name);
  ImportedMotion out = smpl_motion(rows, subject, reading, false);
  for (const auto& [name, tensor] : kept) out.more[name] = tensor;
  return out;
}

void fill_missing(ImportedMotion& motion, const std::vector<FrameFile>& frames) {
  if (frames.back().number - frames.front().number + 1 == static_cast<int64_t>(frames.size())) return;
  std::vector<double> at;
  std::vector<int64_t> nearest;
  for (size_t k = 0; k < frames.size(); ++k) {
    const int64_t step = k + 1 < frames.size() ? frames[k + 1].number - frames[k].number : 1;
    for (int64_t i = 0; i < step; ++i) {
      at.push_back(static_cast<double>(k) + static_cast<double>(i) / static_cast<double>(step));
      nearest.push_back(static_cast<int64_t>(k) + (2 * i >= step ? 1 : 0));
    }
  }
  motion.clip = at_frames(motion.clip, at);
  for (auto& [name, tensor] : motion.more) tensor = tensor.index_select(0, torch::tensor(nearest));
}

torch::Tensor numbers_of(const nlohmann::json& rows, const std::string& path) {
  std::vector<double> out;
  const std::string wrong = "is no matrix: rows of numbers";
  if (!rows.is_array()) throw Error(path, wrong);
  for (const nlohmann::json& row : rows) {
    if (!row.is_array()) throw Error(path, wrong);
    for (const nlohmann::json& number : row) {
      if (!number.is_number()) throw Error(path, wrong);
      out.push_back(number.get<double>());
    }
  }
  return torch::tensor(out, torch::kFloat64);
}

torch::Tensor rigid_transform(const torch::Tensor& numbers, const std::string& path) {
  constexpr double kMostOff = 1e-3;  // of an entry of R R^T
  const torch::Tensor out = numbers.numel() == 16 ? numbers.to(torch::kFloat32).reshape({4, 4}) : torch::Tensor();
  const auto good = [&] {
    const torch::Tensor rotation = out.narrow(0, 0, 3).narrow(1, 0, 3);
    return torch::isfinite(out).all().item<bool>() &&
           (rotation.matmul(rotation.t()) - torch::eye(3)).abs().max().item<double>() <= kMostOff &&
           torch::linalg_det(rotation).item<double>() > 0;
  };
  if (!out.defined() || !good()) throw Error(path, "is no rotation and place, 4 rows of 4 numbers");
  return out;
}

void move_clip(Clip& clip, const torch::Tensor& transform) {
  const torch::Tensor shift = transform.narrow(0, 0, 3).select(1, 3);
  rotate_clip(clip, transform.narrow(0, 0, 3).narrow(1, 0, 3).contiguous());
  clip.joints = clip.joints + shift;
  clip.trans = clip.trans + shift;
}

Scene moved_scene(Scene scene, const torch::Tensor& transform) {
  const torch::Tensor rotation = transform.narrow(0, 0, 3).narrow(1, 0, 3).t(),
                      shift = transform.narrow(0, 0, 3).select(1, 3);
  for (Mesh& mesh : scene.meshes) mesh.vertices = mesh.vertices.matmul(rotation) + shift;
  if (scene.points.defined()) scene.points = scene.points.matmul(rotation) + shift;
  return scene;
}

}  // namespace inhabit
