#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace inhabit {

/// Exponential-map text of `frames` rows: everything swings a little, the root is `height` units high.
inline void write_expmap(const std::string& path, int columns, int64_t frames, double height) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream out(path);
  for (int64_t t = 0; t < frames; ++t)
    for (int k = 0; k < columns; ++k) {
      const double value = k == 1 && t == 0 ? height
                           : k < 3          ? (k == 1 && columns == 117 ? height : 0)
                                            : 0.1 * std::sin(0.05 * static_cast<double>(t) + k);
      out << value << (k + 1 < columns ? "," : "\n");
    }
}

/// CMU's text at 120 Hz of somebody who stands for a second, sits down in another one and a half, thighs level, and
/// stays for two: the feet stay where they are.
inline void write_sitting_expmap(const std::string& path) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream out(path);
  constexpr int kColumns = 117, kLeftThigh = 9, kLeftKnee = 12, kRightThigh = 27, kRightKnee = 30;  // about x
  constexpr double kThigh = 7.1;                                                                    // units, seen level
  for (int t = 0; t < 540; ++t) {
    const double angle = 1.5 * std::min(1.0, std::max(0.0, (t - 120) / 180.0));
    for (int k = 0; k < kColumns; ++k) {
      double value = 0;
      if (k == 1) value = 17 - kThigh * (1 - std::cos(angle));
      if (k == 2) value = -kThigh * std::sin(angle);
      if (k == kLeftThigh || k == kRightThigh) value = angle;
      if (k == kLeftKnee || k == kRightKnee) value = -angle;
      out << value << (k + 1 < kColumns ? "," : "\n");
    }
  }
}

}  // namespace inhabit
