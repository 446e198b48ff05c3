#pragma once
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

}  // namespace inhabit
