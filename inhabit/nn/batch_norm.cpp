#include "inhabit/nn/batch_norm.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace inhabit::nn {
namespace {

using torch::Tensor;

constexpr double kMomentum = 0.1;  // of the running statistics

struct Ranks {
  int64_t count;
  MeanOverRanks mean;
};
std::optional<Ranks> ranks;

/// The mean over the ranks. A rank's part of the loss is the mean over ranks too, so that gradients are averaged alike.
struct Mean : torch::autograd::Function<Mean> {
  static Tensor over_ranks(const Tensor& x) {
    std::vector<Tensor> sent = {x.detach().clone()};
    ranks->mean(sent);
    return sent[0];
  }
  static Tensor forward(torch::autograd::AutogradContext*, const Tensor& x) { return over_ranks(x); }
  static torch::autograd::variable_list backward(torch::autograd::AutogradContext*,
                                                 const torch::autograd::variable_list& gradients) {
    return {over_ranks(gradients[0])};
  }
};

}  // namespace

SharedBatchNorms::SharedBatchNorms(int64_t count, MeanOverRanks mean) { ranks = {count, std::move(mean)}; }
SharedBatchNorms::~SharedBatchNorms() { ranks.reset(); }

BatchNormImpl::BatchNormImpl(int64_t channels, double epsilon, bool affine) : epsilon_(epsilon) {
  if (affine) {
    weight = register_parameter("weight", torch::ones({channels}));
    bias = register_parameter("bias", torch::zeros({channels}));
  }
  running_mean = register_buffer("running_mean", torch::zeros({channels}));
  running_var = register_buffer("running_var", torch::ones({channels}));
  num_batches_tracked = register_buffer("num_batches_tracked", torch::zeros({}, torch::kInt64));
}

Tensor BatchNormImpl::forward(const Tensor& x) {
  if (is_training()) num_batches_tracked += 1;
  if (is_training() && ranks) return shared(x);
  return torch::batch_norm(x, weight, bias, running_mean, running_var, is_training(), kMomentum, epsilon_, true);
}

Tensor BatchNormImpl::shared(const Tensor& x) {
  std::vector<int64_t> others, shape(static_cast<size_t>(x.dim()), 1);
  shape[1] = x.size(1);
  for (int64_t d = 0; d < x.dim(); ++d)
    if (d != 1) others.push_back(d);
  const Tensor mean = Mean::apply(x.mean(others)), away = x - mean.view(shape),
               variance = Mean::apply(away.square().mean(others));
  {
    const torch::NoGradGuard no_gradients;
    const int64_t each = x.numel() / x.size(1);
    const auto samples = static_cast<double>(each * ranks->count);
    running_mean.lerp_(mean, kMomentum);
    running_var.lerp_(variance * (samples / std::max(1.0, samples - 1)), kMomentum);
  }
  const Tensor y = away * (variance + epsilon_).rsqrt().view(shape);
  return weight.defined() ? y * weight.view(shape) + bias.view(shape) : y;
}

}  // namespace inhabit::nn
