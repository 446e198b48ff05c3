#include "inhabit/anticipate/network.h"

#include "inhabit/nn/last_state.h"

namespace inhabit::anticipate {

using torch::Tensor;
namespace F = torch::nn::functional;

IntentionNetworkImpl::IntentionNetworkImpl(const Config& config) {
  const int64_t hidden = config.intention_hidden;
  encoder = register_module("encoder", torch::nn::GRU(torch::nn::GRUOptions(kFeatureCount, hidden).batch_first(true)));
  decoder = register_module("decoder", torch::nn::GRUCell(config.labels, hidden));
  out = register_module("out", torch::nn::Linear(hidden, config.labels));
}

Tensor IntentionNetworkImpl::encode(const Tensor& past) { return nn::last_state(encoder, past); }

Tensor IntentionNetworkImpl::teacher_logits(Tensor state, const Tensor& labels) {
  std::vector<Tensor> logits;
  for (int64_t t = 0; t < labels.size(1); ++t) {
    logits.push_back(out->forward(state));
    state = decoder->forward(labels.select(1, t), state);
  }
  return torch::stack(logits, 1);
}

Tensor IntentionNetworkImpl::draw(Tensor state, const Tensor& gumbel) {
  std::vector<Tensor> labels;
  for (int64_t t = 0; t < gumbel.size(1); ++t) {
    const Tensor logits = out->forward(state) + gumbel.select(1, t);
    const Tensor soft = logits.softmax(1);
    const Tensor hard = F::one_hot(logits.argmax(1), logits.size(1)).to(soft.dtype());
    const Tensor label = hard + soft - soft.detach();
    state = decoder->forward(label, state);
    labels.push_back(label);
  }
  return torch::stack(labels, 1);
}

PoseNetworkImpl::PoseNetworkImpl(const Config& config)
    : intention_features(config.intention ? config.intention_features : 0), memory(config.memory) {
  const int64_t hidden = config.hidden, inputs = (memory ? 2 : 1) * kFeatureCount + intention_features;
  encoder = register_module(
      "encoder", torch::nn::GRU(torch::nn::GRUOptions(kFeatureCount, hidden - config.noise).batch_first(true)));
  for (int i = 0; i < 3; ++i)
    layers.push_back(
        register_module("decoder" + std::to_string(i), torch::nn::GRUCell(i == 0 ? inputs : hidden, hidden)));
  if (config.intention)
    look_ahead = register_module(
        "look_ahead", torch::nn::Conv1d(torch::nn::Conv1dOptions(config.labels, intention_features, config.gamma)));
  out = register_module("out", torch::nn::Linear(hidden, 2 * kFeatureCount));
  pull = register_parameter("pull", torch::full({kFeatureCount}, memory ? -1.5 : -3.0));
  if (memory) {  // begins by following
    const torch::NoGradGuard no_gradients;
    out->weight.mul_(0.1);
    out->bias.zero_();
  }
}

PoseNetworkImpl::State PoseNetworkImpl::start(const Tensor& past, const Tensor& z) {
  const Tensor state = torch::cat({nn::last_state(encoder, past), z}, 1);
  return {{state, state, state}, past.select(1, past.size(1) - 1)};
}

Tensor PoseNetworkImpl::roll(State& state, const Tensor& intention, int64_t frames, const Followed& followed) {
  Tensor ahead;  // (frames, B, intention_features)
  if (intention_features > 0)
    ahead = look_ahead
                ->forward(intention.slice(1, 0, frames + look_ahead->options.kernel_size()->at(0) - 1).transpose(1, 2))
                .permute({2, 0, 1})
                .contiguous();
  const Tensor target_weight = pull.sigmoid();
  std::vector<Tensor> poses;
  for (int64_t t = 0; t < frames; ++t) {
    std::vector<Tensor> seen = {state.pose};
    if (intention_features > 0) seen.push_back(ahead[t]);
    if (memory) seen.push_back(followed.features.select(1, t) - state.pose);
    Tensor x = torch::cat(seen, 1);
    for (size_t i = 0; i < layers.size(); ++i) x = state.layers[i] = layers[i]->forward(x, state.layers[i]);
    const Tensor y = out->forward(x);
    Tensor change = y.slice(1, 0, kFeatureCount), target = y.slice(1, kFeatureCount);
    if (memory) {
      change = change + followed.changes.select(1, t);
      target = target + followed.features.select(1, t);
    }
    state.pose = state.pose + change + target_weight * (target - state.pose);
    poses.push_back(state.pose);
  }
  return torch::stack(poses, 1);
}

DiscriminatorImpl::DiscriminatorImpl(int64_t inputs, int64_t hidden, int depth) {
  for (int i = 0; i < depth; ++i) {
    layers->push_back(torch::nn::Linear(i == 0 ? inputs : hidden, hidden));
    layers->push_back(torch::nn::LeakyReLU(torch::nn::LeakyReLUOptions().negative_slope(0.2)));
  }
  layers->push_back(torch::nn::Linear(hidden, 1));
  register_module("layers", layers);
}

Seq2SeqNetworkImpl::Seq2SeqNetworkImpl(const Config& config) {
  const int64_t hidden = config.baselines.seq2seq_hidden;
  gru = register_module("gru", torch::nn::GRU(torch::nn::GRUOptions(kFeatureCount, hidden).batch_first(true)));
  out = register_module("out", torch::nn::Linear(hidden, kFeatureCount));
}

Tensor Seq2SeqNetworkImpl::forward(const Tensor& past, int64_t frames) {
  Tensor state = std::get<1>(gru->forward(past.slice(1, 0, -1))), pose = past.slice(1, past.size(1) - 1);  // (B, 1, F)
  std::vector<Tensor> poses;
  for (int64_t t = 0; t < frames; ++t) {
    Tensor code;
    std::tie(code, state) = gru->forward(pose, state);
    pose = pose + out->forward(code);
    poses.push_back(pose);
  }
  return torch::cat(poses, 1);
}

}  // namespace inhabit::anticipate
