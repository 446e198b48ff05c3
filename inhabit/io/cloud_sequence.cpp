#include "inhabit/io/cloud_sequence.h"

#include <cctype>
#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/point_cloud.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// In metres and +Y up; `subject` has one frame's points.
Tensor converted_cloud(const Tensor& points, const CloudReadOptions& options, const std::string& subject) {
  if (points.size(0) == 0) throw Error(subject, "holds no points");
  Tensor out = points.to(torch::kFloat32) * options.scale;
  if (!torch::isfinite(out).all().item<bool>()) throw Error(subject, "a point is not finite");
  if (options.z_up) out = torch::stack({out.select(1, 0), out.select(1, 2), -out.select(1, 1)}, 1);
  return out.contiguous();
}

std::string frame_name(const std::string& path, int64_t frame) { return path + ", frame " + std::to_string(frame); }

/// A file's name cut into its numbers and what is between them.
struct NumberedName {
  std::string path, name;
  std::vector<int64_t> numbers;
};

NumberedName numbered(const std::filesystem::path& path) {
  NumberedName out{path.string(), path.stem().string(), {}};
  for (size_t i = 0; i < out.name.size();) {
    int64_t value = 0;
    size_t end = i;
    // A longer number than a timestamp counts modulo; neighbours differ by one all the same.
    for (; end < out.name.size() && std::isdigit(static_cast<unsigned char>(out.name[end])) != 0; ++end)
      value = (value * 10 + (out.name[end] - '0')) % 1000000000000000;
    if (end > i) out.numbers.push_back(value);
    i = std::max(end, i + 1);
  }
  return out;
}

/// Puts files in order of their g-th number. @return where the number does not go up by one, or files.size()
size_t order_by(std::vector<NumberedName>& files, size_t g) {
  std::sort(files.begin(), files.end(), [&](const NumberedName& a, const NumberedName& b) {
    return std::tie(a.numbers[g], a.name) < std::tie(b.numbers[g], b.name);
  });
  size_t i = 1;
  while (i < files.size() && files[i].numbers[g] == files[i - 1].numbers[g] + 1) ++i;
  return i;
}

CloudSequence clouds_in_folder(const std::string& path, const CloudReadOptions& options) {
  constexpr std::array<const char*, 5> kKnown = {"ply", "pcd", "xyz", "npy", "npz"};
  std::vector<NumberedName> files;
  std::string extension;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    const std::string own = extension_of(entry.path().string());
    if (!entry.is_regular_file() || std::find(kKnown.begin(), kKnown.end(), own) == kKnown.end()) continue;
    if (!extension.empty() && own != extension)
      throw Error(path, "holds both ." + std::min(extension, own) + " and ." + std::max(extension, own) + " files");
    extension = own;
    files.push_back(numbered(entry.path()));
  }
  if (files.empty()) throw Error(path, "holds no point clouds (.ply .pcd .xyz .npy .npz)");
  const size_t groups = files[0].numbers.size();
  for (const NumberedName& file : files)
    if (file.numbers.size() != groups || groups == 0)
      throw Error(path, "its files are not numbered alike: " + (groups == 0 ? files[0].name : file.name));
  // Names may hold several numbers, of a sequence or a time: the one that counts goes up by one.
  size_t g = 0;
  while (g < groups && order_by(files, g) < files.size()) ++g;
  if (g == groups) {
    // Told of the number that goes farthest.
    size_t best = 0, farthest = 0;
    for (size_t k = 0; k < groups; ++k)
      if (const size_t gap = order_by(files, k); gap > farthest) farthest = gap, best = k;
    const size_t gap = order_by(files, best);
    throw Error(path, "its files are not numbered one after another: after " + files[gap - 1].name + " comes " +
                          files[gap].name);
  }
  CloudSequence out{path, static_cast<int64_t>(files.size()), {}};
  out.read = [files, options](int64_t frame) {
    const std::string& file = files.at(static_cast<size_t>(frame)).path;
    return converted_cloud(read_point_cloud(file), options, file);
  };
  return out;
}

}  // namespace

CloudSequence clouds_from_npz(const Npz& npz, const std::string& subject, const CloudReadOptions& options) {
  const Tensor points = npz.at(npz.has("points") || !npz.has("arr_0") ? "points" : "arr_0", subject);
  std::vector<int64_t> first{0};
  Tensor rows = points;
  if (npz.has("counts")) {
    const Tensor counts = npz.at("counts", subject);
    if (counts.dim() != 1 || counts.is_floating_point() || points.dim() != 2)
      throw Error(subject, "'counts' wants to be (T) whole numbers, and 'points' (M, 3) beside it");
    const Tensor whole = counts.to(torch::kInt64);
    for (int64_t t = 0; t < whole.size(0); ++t) {
      const int64_t count = whole[t].item<int64_t>();
      if (count < 0 || count > points.size(0) - first.back())
        throw Error(subject, "'counts' do not add up to the " + std::to_string(points.size(0)) + " points");
      first.push_back(first.back() + count);
    }
    if (first.back() != points.size(0))
      throw Error(subject, "'counts' do not add up to the " + std::to_string(points.size(0)) + " points");
  } else {
    if (points.dim() != 3) throw Error(subject, "its points are not (T, N, 3), and there are no 'counts' beside them");
    for (int64_t t = 0; t < points.size(0); ++t) first.push_back(first.back() + points.size(1));
    rows = points.flatten(0, 1);
  }
  if (rows.size(-1) != 3) throw Error(subject, "its points do not have three coordinates");
  CloudSequence out{subject, static_cast<int64_t>(first.size()) - 1, {}};
  out.read = [subject, options, rows, first](int64_t frame) {
    const auto f = static_cast<size_t>(frame);
    return converted_cloud(rows.slice(0, first.at(f), first.at(f + 1)), options, frame_name(subject, frame));
  };
  return out;
}

CloudSequence open_clouds(const std::string& path, const CloudReadOptions& options) {
  if (std::filesystem::is_directory(path)) return clouds_in_folder(path, options);
  const std::string extension = extension_of(path);
  if (extension == "npz" || extension == "npy" || extension.empty() || !std::filesystem::exists(path))
    return clouds_from_npz(read_npz(path, {"points", "counts", "arr_0"}), path, options);
  throw Error(path, "is one cloud; a folder with one a frame is wanted, or an .npz with points (T, N, 3)");
}

}  // namespace inhabit
