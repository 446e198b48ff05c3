#include "inhabit/nn/trajectory_graph.h"

#include "inhabit/math/dct.h"

namespace inhabit::nn {

using torch::Tensor;

constexpr double kDropout = 0.5;  // the original's

TrajectoryGraphImpl::TrajectoryGraphImpl(int64_t nodes, int64_t past_frames, int64_t future_frames, int64_t hidden,
                                         int64_t blocks)
    : ResidualGraphImpl(nodes, past_frames + future_frames, hidden, past_frames + future_frames, blocks, kDropout),
      past(past_frames),
      future(future_frames) {
  const int64_t frames = past + future;
  to_dct_ = padded_dct_matrix(past, future, frames);  // (P+T, P)
  from_dct_ = idct_matrix(frames, frames);            // (P+T, P+T)
}

Tensor TrajectoryGraphImpl::forward(const Tensor& past_frames) {
  const Tensor dct = torch::matmul(past_frames.transpose(1, 2), to_dct_.t().to(past_frames.device()));  // (B, K, P+T)
  const Tensor course = torch::matmul(convolved(dct) + dct, from_dct_.t().to(past_frames.device()));
  return course.slice(2, past).transpose(1, 2);
}

}  // namespace inhabit::nn
