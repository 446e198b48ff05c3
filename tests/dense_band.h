#pragma once
#include <Eigen/Core>

#include "inhabit/math/block_band.h"

namespace inhabit {

/// All of a block-banded matrix, both triangles.
inline Eigen::MatrixXd dense(BlockBand& band) {
  const int64_t n = band.block();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(band.frames() * n, band.frames() * n);
  for (int64_t t = 0; t < band.frames(); ++t)
    for (int k = 0; k <= band.band() && t + k < band.frames(); ++k) out.block((t + k) * n, t * n, n, n) = band.at(t, k);
  return out.selfadjointView<Eigen::Lower>();
}

}  // namespace inhabit
