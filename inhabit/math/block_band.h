#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace inhabit {

/// A symmetric positive definite matrix of `frames` x `frames` blocks of size `block`, zero where frames are more than
/// `band` apart. Its Cholesky factorisation eliminates frames from both ends at once, on two threads, which meet in the
/// middle; a frame's blocks lie beside each other in one panel (panel_kernel.h).
class BlockBand {
 public:
  /// A view of a block's numbers (block, block), where they are in the matrix.
  using Block = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

  /// Holds anything until it is cleared.
  BlockBand(int64_t frames, int block, int band);

  int64_t frames() const { return frames_; }  ///< blocks of a row or column of the matrix
  int block() const { return block_; }        ///< rows of a block
  int band() const { return band_; }          ///< how far apart frames are at most that meet

  /// Sets a frame's panel to zero.
  void clear(int64_t frame) { std::fill_n(panel(frame), block_ * stride_, 0.0); }
  /// Rows of frame + apart, columns of frame. Of the diagonal blocks the lower triangle counts.
  Block at(int64_t frame, int apart) {
    return {panel(frame) + apart * padded_, block_, block_, Eigen::OuterStride<>(stride_)};
  }

  /// A frame's blocks, apart = 0 to band, row by row: rows are columns of the frame, and those of the blocks lie side
  /// by side, each padded with zeros to padded() numbers; stride() numbers in all.
  double* panel(int64_t frame) { return values_.get() + frame * block_ * stride_; }
  int64_t padded() const { return padded_; }  ///< block(), rounded up to a multiple of kPanelWidth
  int64_t stride() const { return stride_; }  ///< padded() (band() + 1), from a row of a panel to the next

  /// Replaces the right-hand side (frames x block) by the solution, the matrix by what is left of it. False where it is
  /// not positive definite.
  /// @param fill writes a frame's blocks before they are needed, a little before the frame is eliminated, from either
  /// end: on two threads, each frame once
  bool solve(const std::function<void(int64_t frame)>& fill, Eigen::VectorXd& x);

 private:
  const double* panel(int64_t frame) const { return values_.get() + frame * block_ * stride_; }
  int64_t left_after(int64_t frame, int64_t end) const;
  bool eliminate_up(int64_t frame, int64_t end);
  bool eliminate_down(int64_t frame);

  int64_t frames_;
  int block_, band_;
  int64_t padded_, stride_;
  int64_t middle_, back_;  ///< [0, middle) upwards, [back, frames) downwards, then what is in between upwards
  std::unique_ptr<double[]> values_;  ///< (frames, block, stride)
};

}  // namespace inhabit
