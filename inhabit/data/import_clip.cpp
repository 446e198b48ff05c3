#include "inhabit/data/import_clip.h"

#include <cctype>
#include <cmath>
#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/motion/resample.h"
#include "inhabit/motion/retarget.h"

namespace inhabit {
namespace {

constexpr double kImportRate = 30;

}  // namespace

std::string import_file_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == '.';
    out += c == '/' ? "__" : std::string(1, plain ? c : '_');
  }
  return out;
}

std::optional<DatasetClip> imported_clip(const Dataset& dataset, DatasetClip entry) {
  const std::string path = dataset.folder + "/" + entry.file;
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const Npz arrays = read_npz(path);
    const torch::Tensor& joints = arrays.at("joints", path);
    if (joints.dim() != 3) return std::nullopt;
    entry.frames = joints.size(0);
    clip_from_arrays(dataset, entry, arrays, path);
    return entry;
  } catch (const Error&) {
    return std::nullopt;
  }
}

ImportedMotion prepared_motion(const ImportSet& set, const ImportRecording& recording) {
  ImportedMotion motion = set.read(recording);
  const double before = motion.clip.rate;
  if (motion.clip.frames() < 2) throw Error(set.folder + ": " + recording.name, "is one pose, no motion");
  Clip clip = motion.clip;
  if (std::abs(clip.rate - kImportRate) > 1e-6) clip = resample(clip, kImportRate, recording.name);
  motion.clip = retarget(clip, recording.name);
  motion.clip.file = {};                // a data set is +Y up, whatever its source was
  motion.clip.betas = torch::Tensor();  // another body's, which are in source_betas
  std::vector<int64_t> rows;
  for (int64_t t = 0; t < motion.clip.frames(); ++t)
    rows.push_back(std::llround(static_cast<double>(t) * before / kImportRate));
  const torch::Tensor at = torch::tensor(rows);
  for (auto& [name, tensor] : motion.more) tensor = tensor.index_select(0, at.clamp_max(tensor.size(0) - 1));
  motion.more["source_rate"] = torch::tensor(before, torch::kFloat64);
  return motion;
}

}  // namespace inhabit
