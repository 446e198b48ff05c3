#pragma once
#include <torch/torch.h>

#include <memory>

#include "inhabit/forecast/network.h"

namespace inhabit::forecast {

/// Inference-only evaluation of a contact network on the CPU: the same outputs (to about 1e-6 of the largest) several
/// times faster:
/// - Batch norms are folded into weights.
/// - Voxel convolutions run only where their result is not one of a few constants.
/// - Scene points that no joint is near carry three channels instead of all.
/// - Repeated neighbours are counted once.
/// - The first layer of every neighbourhood MLP runs once per point instead of once per neighbour.
///
/// Holds a copy of the weights and its workspaces, which later calls reuse: one instance per thread of the caller.
class FastContactNetwork {
 public:
  explicit FastContactNetwork(const ContactNetwork& network);
  ~FastContactNetwork();
  FastContactNetwork(FastContactNetwork&&) noexcept;
  FastContactNetwork& operator=(FastContactNetwork&&) noexcept;

  /// As ContactNetworkImpl::forward() in evaluation mode, without gradients. CPU tensors.
  torch::Tensor forward(const torch::Tensor& scene, const torch::Tensor& contact_dct, const torch::Tensor& past);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace inhabit::forecast
