#include "inhabit/anticipate/released_networks.h"

#include "inhabit/nn/batch_norm.h"
#include "inhabit/nn/last_state.h"

namespace inhabit::anticipate {

using torch::Tensor;
using torch::nn::GRU;
using torch::nn::GRUOptions;
using torch::nn::Linear;

namespace {

std::shared_ptr<torch::nn::Module> part(torch::nn::Module& of, const std::string& name) {
  return of.register_module(name, std::make_shared<torch::nn::Module>());
}

torch::nn::Sequential two_layers(int64_t inputs, int64_t hidden, int64_t outputs) {
  return torch::nn::Sequential(Linear(inputs, hidden), torch::nn::ReLU(), nn::BatchNorm(hidden),
                               Linear(hidden, outputs));
}

}  // namespace

ReleasedPoseNetworkImpl::ReleasedPoseNetworkImpl(const Config& c, int64_t features) {
  encoder = part(*this, "pose_encoder")->register_module("gru", GRU(GRUOptions(features, c.hidden).batch_first(true)));
  const auto own = part(*this, "pose_decoder");
  decoder = GRU(GRUOptions(features + c.intention_features, c.hidden + c.noise).batch_first(true));
  own->register_module("gru", decoder);
  look_ahead =
      part(*own, "decode_labels")
          ->register_module("0", torch::nn::Conv1d(torch::nn::Conv1dOptions(c.labels, c.intention_features, c.gamma)));
  out = own->register_module("pose_decoder", Linear(c.hidden + c.noise, features));
}

Tensor ReleasedPoseNetworkImpl::forward(const Tensor& past, const Tensor& z, const Tensor& labels, int64_t frames) {
  const Tensor ahead = look_ahead->forward(labels.transpose(1, 2)).transpose(1, 2);  // (B, T, E)
  Tensor state = torch::cat({nn::last_state(encoder, past), z}, 1).unsqueeze(0);
  const auto step = [&](const Tensor& pose, int64_t t) {
    state = std::get<1>(decoder->forward(torch::cat({pose, ahead.select(1, t)}, 1).unsqueeze(1), state));
  };
  for (int64_t t = kPast - kWarmUp; t < kPast - 1; ++t) step(past.select(1, t), t);
  Tensor pose = past.select(1, kPast - 1);
  std::vector<Tensor> poses;
  for (int64_t t = 0; t < frames; ++t) {
    step(pose, kPast + t);
    pose = pose + out->forward(state[0]);
    poses.push_back(pose);
  }
  return torch::stack(poses, 1);
}

ReleasedIntentionNetworkImpl::ReleasedIntentionNetworkImpl(const Config& c, int64_t features) {
  const auto layers = [&](int64_t inputs) {
    return GRU(GRUOptions(inputs, c.intention_hidden).num_layers(3).batch_first(true));
  };
  encoder = register_module("encoder", layers(features));
  decoder = register_module("decoder", layers(1));
  out = register_module("decode_label", Linear(c.intention_hidden, c.labels));
}

Tensor ReleasedIntentionNetworkImpl::forward(const Tensor& past) {
  const Tensor state = std::get<1>(encoder->forward(past));
  return out->forward(std::get<0>(decoder->forward(torch::zeros({past.size(0), kFuture, 1}, past.options()), state)));
}

LabelAutoencoderImpl::LabelAutoencoderImpl(int64_t hidden, int64_t code) {
  constexpr int64_t kInputs = kFrames * kJoints * 3;
  encoder = register_module("encoder", two_layers(kInputs, hidden, code));
  decoder = register_module("decoder", two_layers(code, hidden, kInputs));
}

Tensor LabelAutoencoderImpl::encode(const Tensor& poses) {
  Tensor legs = torch::zeros_like(poses);
  legs.narrow(2, 0, kLegs).copy_(poses.narrow(2, 0, kLegs));
  const Tensor code = encoder->forward(legs.flatten(1));
  return code / code.norm(2, 1, true).clamp_min(1e-12);
}

Tensor LabelAutoencoderImpl::decode(const Tensor& code) {
  return decoder->forward(code).view({-1, kFrames, kJoints, 3});
}

SequenceDiscriminatorImpl::SequenceDiscriminatorImpl(int64_t inputs, int64_t hidden) {
  layers = register_module("layers", two_layers(inputs, hidden, 1));
}

}  // namespace inhabit::anticipate
