#pragma once
#include <torch/torch.h>

#include <functional>
#include <vector>

namespace inhabit::nn {

/// What processes that train together do to tensors: every tensor becomes its mean over all of them, which all call it
/// with the same shapes.
using MeanOverRanks = std::function<void(std::vector<torch::Tensor>&)>;

/// While it lives, batch norms in training take their statistics over the batches of all ranks, as one process with all
/// of it would. One at a time.
class SharedBatchNorms {
 public:
  /// @param ranks how many there are
  SharedBatchNorms(int64_t ranks, MeanOverRanks mean);
  ~SharedBatchNorms();
  SharedBatchNorms(const SharedBatchNorms&) = delete;
  SharedBatchNorms& operator=(const SharedBatchNorms&) = delete;
};

/// What batch norms add to the variance unless they are told otherwise.
inline constexpr double kNormEps = 1e-5;

/// Batch normalisation over all dimensions but the second, (B, C, ...), with the parameters and buffers of torch's
/// BatchNorm1d to 3d. Unlike those, it can share its statistics over ranks (SharedBatchNorms).
struct BatchNormImpl : torch::nn::Module {
  /// @param epsilon added to the variance. @param affine with a scale and a shift to be learned
  explicit BatchNormImpl(int64_t channels, double epsilon = kNormEps, bool affine = true);
  /// (B, C, ...) as it came.
  torch::Tensor forward(const torch::Tensor& x);

  torch::Tensor weight;               ///< (C) the scale; undefined where it is not affine
  torch::Tensor bias;                 ///< (C) the shift; undefined where it is not affine
  torch::Tensor running_mean;         ///< (C) of the batches seen, in use outside of training
  torch::Tensor running_var;          ///< (C) of the batches seen, in use outside of training
  torch::Tensor num_batches_tracked;  ///< how many there were

 private:
  torch::Tensor shared(const torch::Tensor& x);
  double epsilon_;
};
TORCH_MODULE(BatchNorm);

}  // namespace inhabit::nn
