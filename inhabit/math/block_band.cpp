#include "inhabit/math/block_band.h"

#include <ATen/Parallel.h>

#include <algorithm>

#include "inhabit/math/panel_kernel.h"

namespace inhabit {

BlockBand::BlockBand(int64_t frames, int block, int band)
    : frames_(frames),
      block_(block),
      band_(band),
      padded_(padded_to_panel(block)),
      stride_(padded_ * (band + 1)),
      middle_(frames),
      back_(frames) {
  // The middle is wide enough that neither end's updates reach what the other one's do.
  if (frames >= 8 * int64_t{band} && band > 0) {
    middle_ = (frames - 2 * band) / 2;
    back_ = middle_ + 2 * band;
  }
  values_.reset(new double[static_cast<size_t>(frames * block * stride_)]);
}

/// Frames after `frame` and before `end` that it meets.
int64_t BlockBand::left_after(int64_t frame, int64_t end) const { return std::min<int64_t>(band_, end - 1 - frame); }

/// Eliminates `frame` with those up to `end` (exclusive) left: its panel becomes a block row of R, Rᵀ R = matrix.
bool BlockBand::eliminate_up(int64_t frame, int64_t end) {
  const int64_t left = left_after(frame, end);
  double* own = panel(frame);
  if (!factor_panel(own, stride_, block_, padded_ * (left + 1))) return false;
  for (int64_t k = 1; k <= left; ++k) {
    const double* from = own + k * padded_;
    subtract_products(from, from, stride_, block_, panel(frame + k), stride_, block_, padded_, true);
    subtract_products(from, from + padded_, stride_, block_, panel(frame + k) + padded_, stride_, block_,
                      padded_ * (left - k), false);
  }
  return true;
}

/// The same from the other end. Its panel becomes a block row of R in the order frame, frame - band ... frame - 1: what
/// it had in these places went with the frames behind.
bool BlockBand::eliminate_down(int64_t frame) {
  const int64_t left = band_;
  double* own = panel(frame);
  for (int64_t k = 1; k <= left; ++k) {
    const double* beside = panel(frame - k) + k * padded_;
    double* to = own + (left - k + 1) * padded_;
    for (int64_t i = 0; i < block_; ++i) {
      for (int64_t j = 0; j < block_; ++j) to[i * stride_ + j] = beside[j * stride_ + i];
      std::fill(to + i * stride_ + block_, to + i * stride_ + padded_, 0.0);
    }
  }
  if (!factor_panel(own, stride_, block_, padded_ * (left + 1))) return false;
  for (int64_t k = left; k >= 1; --k) {
    const double* from = own + (left - k + 1) * padded_;
    subtract_products(from, from, stride_, block_, panel(frame - k), stride_, block_, padded_, true);
    subtract_products(from, from + padded_, stride_, block_, panel(frame - k) + padded_, stride_, block_,
                      padded_ * (k - 1), false);
  }
  return true;
}

bool BlockBand::solve(const std::function<void(int64_t frame)>& fill, Eigen::VectorXd& x) {
  std::vector<double> padded(static_cast<size_t>(frames_ * padded_), 0.0);
  const auto part = [&](int64_t frame) { return padded.data() + frame * padded_; };
  const auto forward = [&](int64_t t, int64_t left, int64_t rest) {
    substitute_forward(panel(t), stride_, block_, padded_, left * padded_, part(t), part(rest));
  };
  const auto backward = [&](int64_t t, int64_t left, int64_t rest) {
    substitute_backward(panel(t), stride_, block_, padded_, left * padded_, part(t), part(rest));
  };
  for (int64_t t = 0; t < frames_; ++t) std::copy_n(x.data() + t * block_, block_, part(t));
  const bool two = back_ < frames_ && at::get_num_threads() > 1;
  const int64_t seam = back_ < frames_ ? middle_ + band_ : frames_;  // frames before it are filled from the start
  bool good[2] = {true, true};
  // A frame goes through filling, elimination and forward substitution while its panel is in the cache.
  const auto from_start = [&] {
    int64_t filled = 0;
    const auto fill_to = [&](int64_t end) {
      for (; filled < end; ++filled) fill(filled);
    };
    for (int64_t t = 0; t < middle_ && good[0]; ++t) {
      fill_to(std::min(t + band_ + 1, seam));
      good[0] = eliminate_up(t, frames_);
      if (good[0]) forward(t, left_after(t, frames_), t + 1);
    }
    fill_to(seam);
  };
  const auto from_end = [&] {
    int64_t filled = frames_;
    const auto fill_to = [&](int64_t begin) {
      while (filled > begin) fill(--filled);
    };
    for (int64_t t = frames_ - 1; t >= back_ && good[1]; --t) {
      fill_to(std::max(t - band_, seam));
      good[1] = eliminate_down(t);
      if (good[1]) forward(t, band_, t - band_);
    }
    fill_to(seam);
  };
#pragma omp parallel for num_threads(2) schedule(static, 1) if (two)
  for (int side = 0; side < 2; ++side) side == 0 ? from_start() : from_end();
  for (int64_t t = middle_; t < back_ && good[0] && good[1]; ++t) {
    good[0] = eliminate_up(t, back_);
    if (good[0]) forward(t, left_after(t, back_), t + 1);
  }
  if (!good[0] || !good[1]) return false;
  for (int64_t t = back_ - 1; t >= middle_; --t) backward(t, left_after(t, back_), t + 1);
#pragma omp parallel for num_threads(2) schedule(static, 1) if (two)
  for (int side = 0; side < 2; ++side) {
    if (side == 0)
      for (int64_t t = middle_ - 1; t >= 0; --t) backward(t, left_after(t, frames_), t + 1);
    else
      for (int64_t t = back_; t < frames_; ++t) backward(t, band_, t - band_);
  }
  for (int64_t t = 0; t < frames_; ++t) std::copy_n(part(t), block_, x.data() + t * block_);
  return true;
}

}  // namespace inhabit
