#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace inhabit::refine {

/// A symmetric positive definite matrix of `frames` x `frames` blocks of size `block`, zero where frames are more than
/// `band` apart. Its Cholesky factorisation eliminates frames from both ends at once, on two threads, which meet in the
/// middle; every product is a BLAS call on one block, small enough to stay on the calling thread.
class BlockBand {
 public:
  using Block = Eigen::Map<Eigen::MatrixXd>;

  BlockBand(int64_t frames, int block, int band);

  int64_t frames() const { return frames_; }
  int block() const { return block_; }
  int band() const { return band_; }

  void clear();
  /// Rows of frame + apart, columns of frame. Of the diagonal blocks the lower triangle counts.
  Block at(int64_t frame, int apart) { return {values_.data() + offset(frame, apart), block_, block_}; }

  /// In place; false where the matrix is not positive definite.
  bool factor();
  /// Replaces the right-hand side (frames x block) by the solution; after factor().
  void solve(Eigen::VectorXd& x) const;

 private:
  int64_t offset(int64_t frame, int apart) const { return (frame * (band_ + 1) + apart) * block_ * block_; }
  bool eliminate_up(int64_t frame, int64_t end);
  bool eliminate_down(int64_t frame, int64_t begin);

  int64_t frames_;
  int block_, band_;
  int64_t middle_, back_;       ///< [0, middle) upwards, [back, frames) downwards, then what is in between upwards
  std::vector<double> values_;  ///< (frames, band + 1) blocks, each column by column
};

/// c += aᵀ b for column-major a (k, m), b (k, n), on the calling thread.
void add_products(const double* a, int a_stride, const double* b, int b_stride, int m, int n, int k, double* c,
                  int c_stride);

}  // namespace inhabit::refine
