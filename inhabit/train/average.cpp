#include "inhabit/train/average.h"

namespace inhabit {
namespace {

template <class Visit>
void visit_weights(torch::nn::Module& module, const Visit& visit) {
  for (const auto& p : module.named_parameters()) visit(p.key(), p.value());
  for (const auto& b : module.named_buffers()) visit(b.key(), b.value());
}

}  // namespace

WeightAverage::WeightAverage(std::shared_ptr<torch::nn::Module> module, double decay)
    : module_(std::move(module)), decay_(decay) {
  visit_weights(*module_,
                [&](const std::string& name, const torch::Tensor& w) { weights_[name] = w.detach().clone(); });
}

void WeightAverage::update(int64_t step) {
  const torch::NoGradGuard no_gradients;
  const double decay = std::min(decay_, (1.0 + static_cast<double>(step)) / (10.0 + static_cast<double>(step)));
  visit_weights(*module_, [&](const std::string& name, const torch::Tensor& w) {
    torch::Tensor& average = weights_.at(name);
    if (w.is_floating_point())
      average.lerp_(w.detach(), 1 - decay);
    else
      average.copy_(w);
  });
}

void WeightAverage::swap() {
  const torch::NoGradGuard no_gradients;
  visit_weights(*module_, [&](const std::string& name, const torch::Tensor& w) {
    torch::Tensor& average = weights_.at(name);
    const torch::Tensor kept = w.detach().clone();
    w.detach().copy_(average);
    average.copy_(kept);
  });
}

}  // namespace inhabit
