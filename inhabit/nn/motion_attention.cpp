#include "inhabit/nn/motion_attention.h"

#include "inhabit/math/dct.h"

namespace inhabit::nn {

using torch::Tensor;

namespace {

constexpr double kAttentionDropout = 0.3;  // the original's
constexpr double kAnyLikeness = 1e-15;     // where nothing is alike, all counts the same

/// (B, K, t) -> (B, hidden, t - M + 1), nowhere negative; of 10 frames kernels of 6 and 5, as in the original.
torch::nn::Sequential likeness(int64_t nodes, int64_t frames, int64_t hidden) {
  const int64_t first = frames / 2 + 1, second = frames - first + 1;
  const auto layer = [](int64_t inputs, int64_t outputs, int64_t kernel) {
    return torch::nn::Conv1d(torch::nn::Conv1dOptions(inputs, outputs, kernel).bias(false));
  };
  return torch::nn::Sequential(layer(nodes, hidden, first), torch::nn::ReLU(), layer(hidden, hidden, second),
                               torch::nn::ReLU());
}

}  // namespace

MotionAttentionImpl::MotionAttentionImpl(int64_t nodes, int64_t query_frames, int64_t future_frames, int64_t hidden,
                                         int64_t blocks)
    : ResidualGraphImpl(nodes, 2 * (query_frames + future_frames), hidden, query_frames + future_frames, blocks,
                        kAttentionDropout),
      query(query_frames),
      future(future_frames) {
  query_network = register_module("query", likeness(nodes, query, hidden));
  key_network = register_module("key", likeness(nodes, query, hidden));
  pad_ = padded_dct_matrix(query, future, query + future);  // (M+T, M)
  to_dct_ = dct_matrix(query + future, query + future);
}

Tensor MotionAttentionImpl::attention(const Tensor& past) {
  const Tensor course = past.transpose(1, 2);  // (B, K, P)
  const Tensor keys = key_network->forward(course.slice(2, 0, past.size(1) - future)),
               asked = query_network->forward(course.slice(2, past.size(1) - query));
  const Tensor alike = torch::matmul(asked.transpose(1, 2), keys).squeeze(1) + kAnyLikeness;
  return alike / alike.sum(1, true);
}

Tensor MotionAttentionImpl::forward(const Tensor& past) {
  const Tensor to_dct = to_dct_.to(past.device());
  const Tensor subsequences = past.unfold(1, query + future, 1);  // (B, N, K, M+T)
  const Tensor course = torch::einsum("bn,bnkt->bkt", {attention(past), subsequences});
  const Tensor dct =
      torch::matmul(past.slice(1, past.size(1) - query).transpose(1, 2), pad_.t().to(past.device()));  // (B, K, M+T)
  const Tensor corrected = convolved(torch::cat({dct, torch::matmul(course, to_dct.t())}, 2)) + dct;
  return torch::matmul(corrected, to_dct).slice(2, query).transpose(1, 2);
}

Tensor MotionAttentionImpl::continued(const Tensor& past, int64_t frames) {
  Tensor all = past;
  while (all.size(1) < past.size(1) + frames) all = torch::cat({all, forward(all)}, 1);
  return all.slice(1, past.size(1), past.size(1) + frames);
}

}  // namespace inhabit::nn
