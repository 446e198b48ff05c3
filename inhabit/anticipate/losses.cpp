#include "inhabit/anticipate/losses.h"

namespace inhabit::anticipate {

using torch::Tensor;
namespace F = torch::nn::functional;

namespace {

constexpr double kGradientPenalty = 0.05;  // keeps the discriminator from cutting real from forecast too sharply (R1)

void set_trainable(torch::nn::Module& module, bool learn) {
  for (Tensor& p : module.parameters()) p.set_requires_grad(learn);
}

/// Mean over frames of the distance of poses, all joints together: (N) metres.
Tensor pose_distance(const Tensor& a, const Tensor& b, const FeatureScale& scale) {
  const Tensor difference = ((a - b) * scale.deviation).slice(2, 0, kPoseFeatures);
  return (difference.square().sum(2) + 1e-9).sqrt().mean(1);
}

}  // namespace

Tensor reconstruction_weights(int64_t frames, int64_t rec_frames) {
  if (rec_frames == 0) return torch::ones({frames});
  return (1 - torch::arange(1, frames + 1).to(torch::kFloat32) / static_cast<double>(rec_frames)).clamp_min(0);
}

Tensor pose_reconstruction_loss(const Tensor& features, const Tensor& truth, const Tensor& weights,
                                const FeatureScale& scale) {
  const Tensor difference =
      ((features - truth) * scale.deviation).slice(2, 0, kPoseFeatures).unflatten(2, {kPoseFeatures / 3, 3});
  return ((difference.square().sum(3) + 1e-12).sqrt().mean(2) * weights).mean();
}

Tensor root_reconstruction_loss(const Tensor& features, const Tensor& truth, const Tensor& weights) {
  return ((features - truth).slice(2, kPoseFeatures).abs().mean(2) * weights).mean();
}

Tensor intention_loss(const Tensor& logits, const Tensor& labels, const Tensor& weights) {
  const Tensor each =
      F::cross_entropy(logits.flatten(0, 1), labels.flatten(), F::CrossEntropyFuncOptions().reduction(torch::kNone));
  return (each * weights.flatten()).sum() / weights.sum().clamp_min(1);
}

Tensor discriminator_loss(const Tensor& real, const Tensor& forecast) {
  return F::softplus(-real).mean() + F::softplus(forecast).mean();
}

Tensor generator_loss(const Tensor& forecast) { return F::softplus(-forecast).mean(); }

void add_discriminator(Discriminator discriminator, const std::string& name, const Tensor& real, const Tensor& forecast,
                       double weight, Tensor& total, Losses& losses) {
  if (forecast.requires_grad()) {
    set_trainable(*discriminator, false);
    const Tensor generator = generator_loss(discriminator->forward(forecast));
    set_trainable(*discriminator, true);
    total = total + weight * generator;
    losses.emplace_back(name + "_generator", generator);
  }
  const Tensor seen = real.detach().clone().requires_grad_(torch::GradMode::is_enabled());
  const Tensor logits = discriminator->forward(seen);
  const Tensor judged = discriminator_loss(logits, discriminator->forward(forecast.detach()));
  total = total + judged;
  if (torch::GradMode::is_enabled()) {
    const Tensor slope = torch::autograd::grad({logits.sum()}, {seen}, {}, true, /*create_graph=*/true)[0];
    total = total + 0.5 * kGradientPenalty * slope.square().sum(1).mean();
  }
  losses.emplace_back(name + "_discriminator", judged);
}

double faster_discriminators(const std::string& parameter) {
  return parameter.find("discriminator") != std::string::npos ? 2.0 : 1.0;
}

Tensor diversity_loss(const Tensor& a, const Tensor& b, const FeatureScale& scale, const Tensor& enough) {
  return (1 - pose_distance(a, b, scale) / enough).clamp_min(0).mean();
}

Tensor pose_spread(const Tensor& frames, const FeatureScale& scale) {
  return pose_distance(frames, frames.roll(frames.size(1) / 3, 1), scale);
}

}  // namespace inhabit::anticipate
