#pragma once
#include <torch/torch.h>

#include <map>
#include <string>

namespace inhabit {

/// Exponential moving average of a module's parameters and buffers (EMA).
class WeightAverage {
 public:
  /// Starts at the module's weights. @param decay weight of the old average in a step; early steps use a smaller one.
  WeightAverage(std::shared_ptr<torch::nn::Module> module, double decay);

  void update(int64_t step);  ///< after optimiser step `step`, counted from 1
  void swap();                ///< the module gets the average and this keeps its weights, until swapped back
  /// The average by the names of parameters and buffers, for checkpoints; while swapped, the module's own weights.
  std::map<std::string, torch::Tensor>& weights() { return weights_; }

 private:
  std::shared_ptr<torch::nn::Module> module_;
  double decay_;
  std::map<std::string, torch::Tensor> weights_;
};

}  // namespace inhabit
