#include <algorithm>
#include <filesystem>
#include <set>

#include "inhabit/data/import_trumans.h"
#include "inhabit/error.h"
#include "inhabit/io/npy_format.h"
#include "inhabit/math/rotation.h"

namespace inhabit {
namespace {

constexpr int64_t kRowsAtOnce = 1 << 16;
constexpr int64_t kShortestPiece = 60;  ///< frames
constexpr double kStays = 0.01;         ///< metres from frame to frame: an object that moves less stands

}  // namespace

std::vector<TrumansPiece> trumans_pieces(const std::string& folder) {
  const std::string names = folder + "/seg_name.npy", flags = folder + "/scene_flag.npy";
  std::set<int64_t> bad;
  if (const std::string path = folder + "/bad_frames.npy"; std::filesystem::exists(path)) {
    const torch::Tensor frames = read_npz(path).at("arr_0", path).to(torch::kInt64).reshape({-1});
    for (int64_t i = 0; i < frames.size(0); ++i) bad.insert(frames[i].item<int64_t>());
  }
  std::vector<TrumansPiece> out;
  TrumansPiece piece;
  const auto close = [&] {
    if (piece.count >= kShortestPiece) out.push_back(piece);
    piece.count = 0;
  };
  int64_t rows = 1;
  for (int64_t first = 0; first < rows; first += kRowsAtOnce) {
    const Npz some = read_npy_rows(names, first, kRowsAtOnce, &rows);
    const auto texts = some.strings.find("arr_0");
    if (texts == some.strings.end()) throw Error(names, "holds no names");
    const torch::Tensor scenes = read_npy_rows(flags, first, kRowsAtOnce).at("arr_0", flags).to(torch::kInt64);
    if (scenes.dim() != 1 || scenes.size(0) != static_cast<int64_t>(texts->second.values.size()))
      throw Error(flags, "has not a row for each of seg_name.npy");
    const auto scene = scenes.accessor<int64_t, 1>();
    for (int64_t k = 0; k < scenes.size(0); ++k) {
      const std::string& segment = texts->second.values[static_cast<size_t>(k)];
      const bool usable = bad.count(first + k) == 0;
      if (piece.count > 0 && (!usable || segment != piece.segment || scene[k] != piece.scene)) close();
      if (!usable) continue;
      if (piece.count == 0) piece = {segment, scene[k], first + k, 0};
      ++piece.count;
    }
  }
  close();
  return out;
}

std::vector<TrumansObject> trumans_objects(const std::string& folder, int64_t first, int64_t count) {
  const std::string flags = folder + "/object_flag.npy", places = folder + "/object_mat.npy",
                    names = folder + "/object_list.npy";
  std::vector<TrumansObject> out;
  for (const std::string& path : {flags, places, names})
    if (!std::filesystem::exists(path)) return out;
  const Npz listed = read_npz(names);
  const auto texts = listed.strings.find("arr_0");
  if (texts == listed.strings.end()) throw Error(names, "holds no names");
  const torch::Tensor slot = read_npy_rows(flags, first, count).at("arr_0", flags).to(torch::kInt64);
  const torch::Tensor place = read_npy_rows(places, first, count).at("arr_0", places).to(torch::kFloat32);
  if (slot.dim() != 2 || slot.size(0) != count || slot.size(1) > static_cast<int64_t>(texts->second.values.size()))
    throw Error(flags, "has not a column for each object of object_list.npy");
  if (place.dim() != 4 || place.size(0) != count || place.size(2) != 4 || place.size(3) != 4)
    throw Error(places, "is not (N, objects, 4, 4)");
  for (int64_t object = 0; object < slot.size(1); ++object) {
    const torch::Tensor in = slot.select(1, object);
    if (in.min().item<int64_t>() < 0 || in.max().item<int64_t>() >= place.size(1)) continue;  // not all the time there
    torch::Tensor mat = place.gather(1, in.view({-1, 1, 1, 1}).expand({-1, 1, 4, 4})).squeeze(1).clone();
    if (!torch::isfinite(mat).all().item<bool>()) continue;
    // The release multiplies rows of points by the upper left part: its transpose rotates columns.
    const torch::Tensor rotation = mat.narrow(1, 0, 3).narrow(2, 0, 3).transpose(1, 2).contiguous();
    mat.narrow(1, 0, 3).narrow(2, 0, 3).copy_(rotation);
    const torch::Tensor at = mat.narrow(1, 0, 3).select(2, 3);
    std::string name = std::filesystem::path(texts->second.values[static_cast<size_t>(object)]).stem().string();
    // The longest time that it stays.
    int64_t longest = 0, middle = 0;
    for (int64_t t = 1, since = 0; t <= count; ++t) {
      if (t < count && (at[t] - at[t - 1]).norm().item<double>() < kStays) continue;
      if (t - since > longest) longest = t - since, middle = (t + since) / 2;
      since = t;
    }
    out.push_back({std::move(name), torch::cat({at, matrix_to_axis_angle(rotation)}, 1), mat[middle]});
  }
  return out;
}

}  // namespace inhabit
