#pragma once
#include <torch/types.h>

#include <string>

namespace inhabit {

/// The decoder of VPoser 1.0 (Pavlakos et al. 2019): 32 numbers to the rotations of 21 joints of the body. Its weights
/// are licensed and no part of this project.
struct Vposer {
  torch::Tensor weight[3];  ///< of its layers, (N, 32), (N, N), (126, N) float32
  torch::Tensor bias[3];    ///< (N), (N), (126)

  /// @param codes (T, 32). @return (T, 63) axis-angle, radians
  torch::Tensor decode(const torch::Tensor& codes) const;
};

/// Reads snapshots/TR00_E096.pt of vposer_v1_0. Throws Error(path, ...).
Vposer read_vposer(const std::string& path);

}  // namespace inhabit
