#include "inhabit/refine/block_band.h"

#include <ATen/Parallel.h>

#include <Eigen/Cholesky>
#include <algorithm>

// BLAS, as Fortran names it.
extern "C" {
void dgemm_(const char* transpose_a, const char* transpose_b, const int* m, const int* n, const int* k,
            const double* alpha, const double* a, const int* lda, const double* b, const int* ldb, const double* beta,
            double* c, const int* ldc);
}

namespace inhabit::refine {
namespace {

using Eigen::MatrixXd;

using ConstView = Eigen::Map<const MatrixXd>;

/// c += alpha op(a) op(b). OpenBLAS spreads larger products than these over threads of its own, which two of ours would
/// fight for.
void multiply(char ta, char tb, int m, int n, int k, double alpha, const double* a, int lda, const double* b, int ldb,
              double* c, int ldc) {
  constexpr int kLargest = 250000, kDeepest = 72, kSmallest = 64;
  if (m * n * k <= kSmallest) {  // a call of BLAS takes longer
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < m; ++i) {
        double sum = 0;
        for (int l = 0; l < k; ++l)
          sum += (ta == 'N' ? a[l * lda + i] : a[i * lda + l]) * (tb == 'N' ? b[j * ldb + l] : b[l * ldb + j]);
        c[j * ldc + i] += alpha * sum;
      }
    return;
  }
  const double one = 1;
  for (int row = 0; row < k; row += kDeepest) {
    const int depth = std::min(kDeepest, k - row), columns = std::max(1, kLargest / std::max(1, m * depth));
    const double* left = a + (ta == 'N' ? int64_t{row} * lda : row);
    for (int first = 0; first < n; first += columns) {
      const int some = std::min(columns, n - first);
      const double* right = b + (tb == 'N' ? int64_t{first} * ldb + row : int64_t{row} * ldb + first);
      dgemm_(&ta, &tb, &m, &some, &depth, &alpha, left, &lda, right, &ldb, &one, c + int64_t{first} * ldc, &ldc);
    }
  }
}

/// A pivot becomes the inverse of its Cholesky factor, so that what remains are products; false where it has none.
bool invert_factor(BlockBand::Block pivot) {
  const Eigen::LLT<MatrixXd> llt(pivot.selfadjointView<Eigen::Lower>());
  if (llt.info() != Eigen::Success) return false;
  MatrixXd inverse = MatrixXd::Identity(pivot.rows(), pivot.cols());
  llt.matrixL().solveInPlace(inverse);
  pivot = inverse;
  return true;
}

}  // namespace

void add_products(const double* a, int a_stride, const double* b, int b_stride, int m, int n, int k, double* c,
                  int c_stride) {
  multiply('T', 'N', m, n, k, 1, a, a_stride, b, b_stride, c, c_stride);
}

BlockBand::BlockBand(int64_t frames, int block, int band)
    : frames_(frames), block_(block), band_(band), middle_(frames), back_(frames) {
  // The middle is wide enough that neither end's updates reach what the other one's do.
  if (frames >= 8 * int64_t{band} && band > 0) {
    middle_ = (frames - 2 * band) / 2;
    back_ = middle_ + 2 * band;
  }
  values_.assign(static_cast<size_t>(frames * (band + 1) * block * block), 0.0);
}

void BlockBand::clear() { std::fill(values_.begin(), values_.end(), 0.0); }

/// Eliminates `frame` with those up to `end` (exclusive) left: its column becomes that of the factor L, L Lᵀ = matrix.
bool BlockBand::eliminate_up(int64_t frame, int64_t end) {
  const Block pivot = at(frame, 0);
  if (!invert_factor(pivot)) return false;
  const auto left = static_cast<int>(std::min<int64_t>(band_, end - 1 - frame));
  MatrixXd column(block_, block_);
  for (int k = 1; k <= left; ++k) {
    Block below = at(frame, k);
    column.setZero();
    multiply('N', 'T', block_, block_, block_, 1, below.data(), block_, pivot.data(), block_, column.data(), block_);
    below = column;
  }
  for (int k = 1; k <= left; ++k)
    for (int i = k; i <= left; ++i)
      multiply('N', 'T', block_, block_, block_, -1, at(frame, i).data(), block_, at(frame, k).data(), block_,
               at(frame + k, i - k).data(), block_);
  return true;
}

/// The same from the other end, with the frames from `begin` on left: its row becomes that of the factor.
bool BlockBand::eliminate_down(int64_t frame, int64_t begin) {
  const Block pivot = at(frame, 0);
  if (!invert_factor(pivot)) return false;
  const auto left = static_cast<int>(std::min<int64_t>(band_, frame - begin));
  MatrixXd row(block_, block_);
  for (int k = 1; k <= left; ++k) {
    Block beside = at(frame - k, k);
    row.setZero();
    multiply('N', 'N', block_, block_, block_, 1, pivot.data(), block_, beside.data(), block_, row.data(), block_);
    beside = row;
  }
  for (int k = 1; k <= left; ++k)
    for (int i = k; i <= left; ++i)
      multiply('T', 'N', block_, block_, block_, -1, at(frame - k, k).data(), block_, at(frame - i, i).data(), block_,
               at(frame - i, i - k).data(), block_);
  return true;
}

bool BlockBand::factor() {
  bool good[2] = {true, true};
#pragma omp parallel for num_threads(2) schedule(static, 1) if (back_ < frames_ && at::get_num_threads() > 1)
  for (int side = 0; side < 2; ++side) {
    if (side == 0)
      for (int64_t t = 0; t < middle_ && good[0]; ++t) good[0] = eliminate_up(t, frames_);
    else
      for (int64_t t = frames_ - 1; t >= back_ && good[1]; --t) good[1] = eliminate_down(t, middle_ + band_);
  }
  for (int64_t t = middle_; t < back_ && good[0] && good[1]; ++t) good[0] = eliminate_up(t, back_);
  return good[0] && good[1];
}

void BlockBand::solve(Eigen::VectorXd& x) const {
  const auto block = [&](int64_t frame, int apart) {
    return ConstView(values_.data() + offset(frame, apart), block_, block_);
  };
  const auto part = [&](int64_t frame) { return x.segment(frame * block_, block_); };
  const auto up = [&](int64_t first, int64_t last, int64_t end) {
    for (int64_t t = first; t < last; ++t) {
      part(t) = (block(t, 0) * part(t)).eval();
      for (int k = 1; k <= band_ && t + k < end; ++k) part(t + k).noalias() -= block(t, k) * part(t);
    }
  };
  const auto back_up = [&](int64_t first, int64_t last, int64_t end) {
    for (int64_t t = last - 1; t >= first; --t) {
      for (int k = 1; k <= band_ && t + k < end; ++k) part(t).noalias() -= block(t, k).transpose() * part(t + k);
      part(t) = (block(t, 0).transpose() * part(t)).eval();
    }
  };
  up(0, middle_, frames_);
  for (int64_t t = frames_ - 1; t >= back_; --t) {
    part(t) = (block(t, 0) * part(t)).eval();
    for (int k = 1; k <= band_ && t - k >= middle_ + band_; ++k)
      part(t - k).noalias() -= block(t - k, k).transpose() * part(t);
  }
  up(middle_, back_, back_);
  back_up(middle_, back_, back_);
  for (int64_t t = back_; t < frames_; ++t) {
    for (int k = 1; k <= band_ && t - k >= middle_ + band_; ++k) part(t).noalias() -= block(t - k, k) * part(t - k);
    part(t) = (block(t, 0).transpose() * part(t)).eval();
  }
  back_up(0, middle_, frames_);
}

}  // namespace inhabit::refine
