#include "inhabit/anticipate/train_released.h"

#include "inhabit/anticipate/losses.h"
#include "inhabit/nn/random_tensor.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;
using Labels = ReleasedIntentionNetworkImpl;

constexpr int64_t kReleasedFrames = 20;      // that poses are trained on
constexpr int64_t kLabelledFrames = 10;      // labels of the cross-entropy
constexpr int64_t kLabelDiscriminator = 32;  // its hidden width
constexpr double kRecWeight = 10, kInputNoise = 0.001, kLabelNoise = 0.1;

struct ReleasedModelImpl : torch::nn::Module {
  explicit ReleasedModelImpl(const Config& c) {
    intention = register_module("intention", ReleasedIntentionNetwork(c, kFeatureCount));
    pose = register_module("pose", ReleasedPoseNetwork(c, kFeatureCount));
    label_discriminator =
        register_module("label_discriminator", SequenceDiscriminator(Labels::kFuture * c.labels, kLabelDiscriminator));
    pose_discriminator = register_module(
        "pose_discriminator", SequenceDiscriminator(kReleasedFrames * kFeatureCount, c.training.discriminator_hidden));
  }
  ReleasedIntentionNetwork intention{nullptr};
  ReleasedPoseNetwork pose{nullptr};
  SequenceDiscriminator label_discriminator{nullptr}, pose_discriminator{nullptr};
};
TORCH_MODULE(ReleasedModel);

struct ReleasedBatch {
  Tensor frames;        // (B, observed + future, F)
  Tensor labels;        // (B, T) int64
  Tensor known;         // (B, 20) 1 for frames that were recorded
  Tensor known_labels;  // (B, 50) likewise
  Tensor z, jitter;     // (B, Z), and what is added to the observed poses
  Tensor label_noise;   // (2, B, 50, C)

  ReleasedBatch on(torch::Device d) const {
    return {frames.to(d), labels.to(d), known.to(d), known_labels.to(d), z.to(d), jitter.to(d), label_noise.to(d)};
  }
};

ReleasedBatch released_batch(const Data& data, const Config& c, const std::vector<int64_t>& indices, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Tensor> frames, labels, known, known_labels;
  for (const int64_t index : indices) {
    const auto window = data.sample(index, chance(random, 0.5));
    frames.push_back(window.frames);
    labels.push_back(window.labels);
    known.push_back((torch::arange(c.observed, c.observed + kReleasedFrames) < window.last).to(torch::kFloat32));
    known_labels.push_back(
        (c.observed + 1 + Labels::kStride * torch::arange(Labels::kFuture) < window.last_label).to(torch::kFloat32));
  }
  const auto count = static_cast<int64_t>(indices.size());
  return {torch::stack(frames),
          torch::stack(labels),
          torch::stack(known),
          torch::stack(known_labels),
          nn::normal_tensor(random, {count, c.noise}),
          nn::normal_tensor(random, {count, c.observed, kFeatureCount}, kInputNoise),
          nn::normal_tensor(random, {2, count, Labels::kFuture, c.labels}, kLabelNoise)};
}

/// Adds the discriminator's loss and that of what it judges, which the discriminator does not learn from.
void add_judgement(SequenceDiscriminator discriminator, const std::string& name, const Tensor& real,
                   const Tensor& forecast, Tensor& total, Losses& losses) {
  for (Tensor& p : discriminator->parameters()) p.set_requires_grad(false);
  const Tensor generator = generator_loss(discriminator->forward(forecast));
  for (Tensor& p : discriminator->parameters()) p.set_requires_grad(true);
  const Tensor judged = discriminator_loss(discriminator->forward(real), discriminator->forward(forecast.detach()));
  total = total + generator + judged;
  losses.emplace_back(name + "_generator", generator);
  losses.emplace_back(name + "_discriminator", judged);
}

Losses released_losses(ReleasedModel model, const ReleasedBatch& b, const Config& c, const FeatureScale& scale) {
  const int64_t now = c.observed, first = now - ReleasedPoseNetworkImpl::kPast;
  const Tensor past = b.frames.slice(1, 0, now) + b.jitter, truth = b.frames.slice(1, now, now + kReleasedFrames);
  const Tensor labels = F::one_hot(b.labels, c.labels).to(torch::kFloat32);
  const Tensor forecast = model->pose->forward(
      past.slice(1, first), b.z, labels.slice(1, first, now + kReleasedFrames + c.gamma - 1), kReleasedFrames);
  const Tensor frame = torch::arange(1, kReleasedFrames + 1, b.known.options());
  const Tensor weights =
      b.known * ((kReleasedFrames + 1 - frame) / static_cast<double>(kReleasedFrames)) *
      (c.training.rec_frames == 0 ? torch::ones_like(frame) : (frame <= c.training.rec_frames).to(torch::kFloat32));
  const Tensor rec = pose_reconstruction_loss(forecast, truth, weights, scale),
               root = root_reconstruction_loss(forecast, truth, weights);
  Tensor total = kRecWeight * (rec + root);
  Losses losses = {{"rec", rec}, {"root", root}};
  if (c.training.pose_discriminator) add_judgement(model->pose_discriminator, "pose", truth, forecast, total, losses);

  const Tensor slow = past.slice(1, now - 1 - (Labels::kPast - 1) * Labels::kStride, c10::nullopt, Labels::kStride);
  const Tensor logits = model->intention->forward(slow);
  const Tensor later = b.labels.slice(1, now + 1, now + Labels::kFuture * Labels::kStride, Labels::kStride);
  const Tensor sym =
      intention_loss(logits.slice(1, 0, kLabelledFrames), later.slice(1, 0, kLabelledFrames).contiguous(),
                     b.known_labels.slice(1, 0, kLabelledFrames).contiguous());
  total = total + sym;
  losses.emplace_back("intention", sym);
  if (c.training.label_discriminator)
    add_judgement(model->label_discriminator, "label", F::one_hot(later, c.labels) + b.label_noise[0],
                  logits.softmax(2) + b.label_noise[1], total, losses);
  losses.insert(losses.begin(), {"total", total});
  return losses;
}

}  // namespace

TrainTask released_task(Networks& networks, const Data& data, std::function<double()> validate, torch::Device device) {
  const Config& c = networks.config;
  ReleasedModel model(c);
  networks.released_intention = model->intention;
  networks.released_pose = model->pose;
  TrainTask task;
  task.average = c.training.average;
  task.module = model.ptr();
  task.networks = {{"pose_net.", model->pose.ptr()}, {"intention_net.", model->intention.ptr()}};
  task.tensors = cluster_tensors(networks.clusters);
  task.samples = data.size();
  task.prepare =
      batches([&](const TrainStep& step) { return released_batch(data, c, step.indices, step.seed); },
              [&, model, device, scale = networks.scale.to(device)](const ReleasedBatch& b, const TrainStep&) {
                return released_losses(model, b.on(device), c, scale);
              });
  task.validate = std::move(validate);
  return task;
}

}  // namespace inhabit::anticipate
