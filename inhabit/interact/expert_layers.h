#pragma once
#include <torch/torch.h>

#include <string>
#include <vector>

namespace inhabit::interact {

/// Linear layers with a rectifier after each, or between them alone; dropout before each where asked for. In a
/// Sequential whose indices are the released ones.
struct LayerSpec {
  std::vector<int64_t> widths;  ///< inputs, then the outputs of each layer
  double dropout = -1;          ///< before each layer; under 0: none, which takes no index either
  double leak = -1;             ///< slope under 0 of a leaky rectifier; 0: ReLU; under 0: ELU
  bool activate_last = false;   ///< a rectifier behind the last layer, too
};
/// Linear layers of these widths, with dropout before and rectifiers behind them: (..., first width) -> (..., last
/// width).
torch::nn::Sequential make_layers(const LayerSpec& spec);

/// Weights of the experts by a network of three layers, softmax at the end: (B, inputs) -> (B, experts), ELU between.
struct GatingNetworkImpl : torch::nn::Module {
  /// @param second width of the second hidden layer.
  GatingNetworkImpl(int64_t inputs, int64_t first, int64_t second, int64_t experts, double dropout);
  /// (B, inputs) -> (B, experts), rows sum to 1.
  torch::Tensor forward(const torch::Tensor& x);

  torch::nn::Linear fc0{nullptr};  ///< inputs to first
  torch::nn::Linear fc1{nullptr};  ///< first to second
  torch::nn::Linear fc2{nullptr};  ///< second to experts
  double dropout;                  ///< before each, in training
};
TORCH_MODULE(GatingNetwork);

/// Layers whose weights are blended from those of experts, ELU between. The layer's outputs are blended in their place,
/// which is the same before the ELU: no blended weight is ever formed.
struct ExpertLayersImpl : torch::nn::Module {
  /// @param widths inputs, then the outputs of each layer.
  ExpertLayersImpl(int64_t experts, const std::vector<int64_t>& widths, double dropout);
  /// @param x (B, inputs); @param gates (B, experts). @return (B, outputs)
  torch::Tensor forward(torch::Tensor x, const torch::Tensor& gates);

  std::vector<torch::Tensor> weights;  ///< (experts, out, in) of each layer
  std::vector<torch::Tensor> biases;   ///< (experts, out) of each layer
  double dropout;                      ///< before each, in training
};
TORCH_MODULE(ExpertLayers);

}  // namespace inhabit::interact
