#pragma once
#include <torch/types.h>

namespace inhabit {

/// Orthonormal DCT-II basis (Eq. 3-4), first `count` of `length` coefficients: (count, length) float32.
/// coefficients = dct_matrix @ sequence; row l is sqrt(2/length) / sqrt(1 + [l = 0]) cos(pi/length (p + 1/2) l).
torch::Tensor dct_matrix(int64_t length, int64_t count);

/// Its inverse (Eq. 5) from the first `count` coefficients: (length, count), the transpose.
torch::Tensor idct_matrix(int64_t length, int64_t count);

/// (count, past) float32: coefficients of a sequence of `past + future` frames whose last `future` frames repeat frame
/// `past - 1`, straight from the first `past` frames. The DCT is linear, so the columns of the repeated frames add up.
torch::Tensor padded_dct_matrix(int64_t past, int64_t future, int64_t count);

}  // namespace inhabit
