#include "inhabit/anticipate/futures.h"

#include "inhabit/anticipate/fast_futures.h"
#include "inhabit/anticipate/released_labels.h"
#include "inhabit/anticipate/sample.h"
#include "inhabit/error.h"
#include "inhabit/math/random.h"
#include "inhabit/nn/random_tensor.h"

namespace inhabit::anticipate {

using torch::Tensor;

FutureNoise draw_noise(const Config& config, int64_t samples, int64_t frames, uint64_t seed) {
  FutureNoise out{torch::empty({samples, config.noise}),
                  torch::empty({samples, frames + config.gamma - 1, config.labels}),
                  torch::empty({samples, frames + config.gamma - 1, 3})};
  float *z = out.z.data_ptr<float>(), *gumbel = out.gumbel.data_ptr<float>(), *choice = out.choice.data_ptr<float>();
  for (int64_t s = 0; s < samples; ++s) {
    std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(s)));
    for (int64_t i = 0; i < config.noise; ++i) *z++ = static_cast<float>(normal(random));
    // Of their own stream, so that a longer forecast begins as a shorter one does.
    std::mt19937_64 of_choice(item_seed(seed ^ 0x6d656d6f7279ULL, static_cast<uint64_t>(s)));
    for (int64_t i = 0; i < out.choice.stride(0); ++i) *choice++ = static_cast<float>(uniform(of_choice, 0, 1));
    for (int64_t i = 0; i < out.gumbel.stride(0); ++i)
      *gumbel++ = static_cast<float>(config.inference.label_temperature) * nn::gumbel(random);
  }
  return out;
}

Followed followed_motion(const Networks& networks, const Tensor& past, const FutureNoise& noise, int64_t frames) {
  if (!networks.memory) return {};
  const torch::NoGradGuard no_gradients;
  const Config& c = networks.config;
  const int64_t samples = noise.z.size(0);
  MotionMemory::LabelScores scores;
  MotionMemory::LabelsSeen seen;
  IntentionNetwork intention = networks.intention;
  Tensor state;
  if (c.intention) {
    const Tensor weight = intention->out->weight;
    state = intention->encode(networks.scale.to_network(past).to(weight.dtype())).expand({samples, -1});
    scores = [&] { return intention->out->forward(state).log_softmax(1) * c.inference.memory_label; };
    seen = [&](const Tensor& labels) {
      state = intention->decoder->forward(torch::nn::functional::one_hot(labels, c.labels).to(weight.dtype()), state);
    };
  }
  const Tensor choice = noise.choice.slice(1, 0, frames + c.gamma - 1);
  return networks.memory->follow(past, choice, {}, scores, seen).to_network(networks.scale);
}

Futures plain_futures(const Networks& networks, const Tensor& past, const FutureNoise& noise, int64_t frames) {
  const torch::NoGradGuard no_gradients;
  PoseNetwork pose = networks.pose;
  IntentionNetwork intention = networks.intention;
  const Tensor seen = networks.scale.to_network(past).expand({noise.z.size(0), -1, -1});
  Tensor labels;
  const Followed followed = followed_motion(networks, past, noise, frames);
  if (networks.config.intention && networks.memory)
    labels = torch::nn::functional::one_hot(followed.labels, networks.config.labels).to(seen.dtype());
  else if (networks.config.intention)
    labels = intention->draw(intention->encode(seen), noise.gumbel);
  PoseNetworkImpl::State state = pose->start(seen, noise.z);
  const Tensor x = pose->roll(state, labels, frames, followed);
  return {networks.scale.from_network(x), labels.defined() ? labels.argmax(2).slice(1, 0, frames) : labels};
}

Futures released_futures(const Networks& networks, const Tensor& past, const FutureNoise& noise, int64_t frames) {
  const torch::NoGradGuard no_gradients;
  ReleasedIntentionNetwork intention = networks.released_intention;
  ReleasedPoseNetwork pose = networks.released_pose;
  using Labels = ReleasedIntentionNetworkImpl;
  const Config& c = networks.config;
  const int64_t samples = noise.z.size(0), known = pose->kPast, chunk = Labels::kFuture * Labels::kStride - c.gamma + 1;
  Tensor all = networks.scale.to_network(past).expand({samples, -1, -1});
  std::vector<Tensor> labels;
  while (all.size(1) < past.size(1) + frames) {
    const int64_t now = all.size(1);
    const Tensor slow = all.slice(1, now - (Labels::kPast - 1) * Labels::kStride - 1, c10::nullopt, Labels::kStride);
    const Tensor ahead = intention->forward(slow).softmax(2).repeat_interleave(Labels::kStride, 1);
    const Tensor last = networks.scale.from_network(all.slice(1, now - c.observed));
    std::vector<Tensor> observed;  // labels of the last frames
    for (int64_t s = 0; s < samples; ++s)
      observed.push_back(torch::nn::functional::one_hot(
          released_labels(intention_poses(last[s]), networks.clusters).slice(0, c.observed - known), c.labels));
    const Tensor seen = torch::stack(observed).to(torch::kFloat32);
    all = torch::cat({all, pose->forward(all.slice(1, now - known), noise.z, torch::cat({seen, ahead}, 1), chunk)}, 1);
    labels.push_back(ahead.slice(1, 0, chunk).argmax(2));
  }
  return {networks.scale.from_network(all.slice(1, past.size(1), past.size(1) + frames)),
          torch::cat(labels, 1).slice(1, 0, frames)};
}

FutureFunction future_function(const Networks& networks) {
  if (!networks.forecasts()) throw Error("model", "lacks the networks that forecast intention and pose");
  if (networks.config.released)
    return [networks](const Tensor& past, const FutureNoise& noise, int64_t frames) {
      return released_futures(networks, past, noise, frames);
    };
  return
      [fast = std::make_shared<const FastFutures>(networks)](
          const Tensor& past, const FutureNoise& noise, int64_t frames) { return fast->forward(past, noise, frames); };
}

Tensor seq2seq_future(const Networks& networks, const Tensor& past, int64_t frames) {
  const torch::NoGradGuard no_gradients;
  Seq2SeqNetwork network = networks.seq2seq;
  return networks.scale.from_network(network->forward(networks.scale.to_network(past), frames));
}

Tensor ltd_future(const Networks& networks, const Tensor& past, int64_t frames) {
  const torch::NoGradGuard no_gradients;
  nn::TrajectoryGraph network = networks.ltd;
  Tensor all = networks.scale.to_network(past);
  while (all.size(1) < past.size(1) + frames)
    all = torch::cat({all, network->forward(all.slice(1, all.size(1) - network->past))}, 1);
  return networks.scale.from_network(all.slice(1, past.size(1), past.size(1) + frames));
}

Tensor hisrep_future(const Networks& networks, const Tensor& past, int64_t frames) {
  const torch::NoGradGuard no_gradients;
  nn::MotionAttention network = networks.hisrep;
  return networks.scale.from_network(network->continued(networks.scale.to_network(past), frames));
}

}  // namespace inhabit::anticipate
