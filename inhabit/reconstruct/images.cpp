#include "inhabit/reconstruct/images.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "inhabit/error.h"
#include "inhabit/io/many_files.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/png_mask.h"

namespace inhabit::reconstruct {
namespace {

constexpr int64_t kMostMaps = 64;

/// The numbers in a file's name, one of more than 15 digits modulo 10^15.
std::vector<int64_t> numbers_in(const std::string& path) {
  const std::string name = std::filesystem::path(path).stem().string();
  std::vector<int64_t> out;
  bool within = false;
  for (const char c : name) {
    const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (digit && !within) out.push_back(0);
    if (digit) out.back() = (out.back() * 10 + (c - '0')) % 1000000000000000;
    within = digit;
  }
  return out;
}

/// @param files becomes those from number `first` on: what was before the first depth map counts for nothing.
ImageSequence sequence_of(std::vector<NumberedFile>& files, int64_t first) {
  ImageSequence out;
  out.name = files.empty() ? "" : files.front().path;
  files.erase(files.begin(),
              std::find_if(files.begin(), files.end(), [&](const auto& f) { return f.number >= first; }));
  out.frames.reserve(files.size());
  for (const NumberedFile& file : files) out.frames.push_back(file.number - first);
  return out;
}

}  // namespace

int64_t ImageSequence::index_of(int64_t frame) const {
  if (every_frame) return 0;
  const auto at = std::lower_bound(frames.begin(), frames.end(), frame);
  return at != frames.end() && *at == frame ? at - frames.begin() : -1;
}

std::vector<NumberedFile> numbered_files(const std::vector<std::string>& patterns) {
  std::set<std::string> paths;
  for (const std::string& pattern : patterns)
    for (std::string& path : files_matching(pattern)) paths.insert(std::move(path));
  const std::string& name = patterns.front();
  std::vector<std::vector<int64_t>> numbers;
  for (const std::string& path : paths) {
    numbers.push_back(numbers_in(path));
    if (numbers.back().empty()) throw Error(path, "has no number in its name that tells its frame");
    if (numbers.back().size() != numbers.front().size()) throw Error(path, "is not numbered as the others are");
  }
  size_t which = numbers.front().size() - 1;
  for (size_t g = numbers.front().size(); g-- > 0;)
    if (std::any_of(numbers.begin(), numbers.end(), [&](const auto& n) { return n[g] != numbers.front()[g]; }))
      which = g;
  std::vector<NumberedFile> out;
  out.reserve(paths.size());
  for (const std::string& path : paths) out.push_back({path, numbers[out.size()][which]});
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  for (size_t i = 1; i < out.size(); ++i)
    if (out[i].number == out[i - 1].number)
      throw Error(name,
                  "both " + out[i - 1].path + " and " + out[i].path + " have number " + std::to_string(out[i].number));
  return out;
}

ImageSequence open_depth(std::vector<NumberedFile> files, int64_t first, int64_t height, int64_t width) {
  ImageSequence out = sequence_of(files, first);
  out.read = [files = std::move(files), height, width](size_t i) {
    const std::string& path = files.at(i).path;
    // What it may hold is known: a file that is larger is not read.
    std::error_code failed;
    const uint64_t size = std::filesystem::file_size(path, failed);
    if (!failed && size > static_cast<uint64_t>(kMostMaps * height * width) * 8 + (1 << 20))
      throw Error(path, "is larger than " + std::to_string(kMostMaps) + " depth maps of the camera's size");
    const Npz file = read_npz(path);
    torch::Tensor maps = file.at("arr_0", path);
    if (maps.dim() == 2) maps = maps.unsqueeze(0);
    if (maps.dim() != 3 || maps.size(0) < 1 || maps.size(0) > kMostMaps || maps.size(1) != height ||
        maps.size(2) != width) {
      std::string shape;
      for (const int64_t n : file.at("arr_0", path).sizes()) shape += (shape.empty() ? "" : ", ") + std::to_string(n);
      throw Error(path, "its array is (" + shape + "), where the camera has depth maps (" + std::to_string(height) +
                            ", " + std::to_string(width) + "), or several, (K, " + std::to_string(height) + ", " +
                            std::to_string(width) + ")");
    }
    maps = maps.to(torch::kFloat32).contiguous();
    if (!torch::isfinite(maps).all().item<bool>())
      throw Error(path, "a depth is not finite; 0 says that it is unknown");
    return maps;
  };
  return out;
}

ImageSequence open_masks(std::vector<NumberedFile> files, int64_t first, int64_t height, int64_t width) {
  ImageSequence out = sequence_of(files, first);
  out.read = [files = std::move(files), height, width](size_t i) {
    return read_mask_png(files.at(i).path, height, width);
  };
  return out;
}

}  // namespace inhabit::reconstruct
