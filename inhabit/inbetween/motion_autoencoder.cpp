#include "inhabit/inbetween/motion_autoencoder.h"

#include "inhabit/body/skeleton.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "inhabit/motion/local_pose.h"
#include "inhabit/nn/feature_scale.h"
#include "inhabit/nn/model_file.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;
namespace F = torch::nn::functional;

constexpr const char* kAutoencoder = "motion-autoencoder";
constexpr int64_t kChannels = (3 + 3 + 1) * kStandardJoints, kWidth = 96;
constexpr std::array<int64_t, 5> kLengths = {121, 61, 31, 16, 8};  // frames at each level

void require_windows(const Tensor& joints, const char* what) {
  if (!joints.defined() || joints.dim() != 4 || joints.size(0) < 1 || joints.size(1) != kFeatureFrames ||
      joints.size(2) != kStandardJoints || joints.size(3) != 3)
    throw Error(what, "are not windows of " + std::to_string(kFeatureFrames) + " frames of the standard joints");
  if (!joints.isfinite().all().item<bool>()) throw Error(what, "are not finite");
}

Tensor reconstruction_error(MotionAutoencoder& network, const Tensor& channels) {
  return F::mse_loss(network->decode(network->encode(channels)), channels);
}

/// Mean and deviation of the channels of windows, some at a time.
void set_scale(MotionAutoencoderImpl& network, const Tensor& joints) {
  const torch::NoGradGuard no_gradients;
  FeatureStatistics statistics;
  for (const Tensor& part : joints.split(256)) statistics.add(motion_channels(part).transpose(1, 2));
  const FeatureScale scale = statistics.scale();
  network.mean.copy_(scale.mean);
  // A channel that hardly changes would be noise at its own scale.
  network.deviation.copy_(scale.deviation.clamp_min(1e-3));
}

}  // namespace

Tensor motion_channels(const Tensor& joints) {
  const Tensor start = joints.narrow(1, 0, 1);                                   // (N, 1, 22, 3)
  const Tensor ground = start.narrow(2, 0, 1) * torch::tensor({1.F, 0.F, 1.F});  // heights stay
  const Tensor rotation = yaw_matrix(-headings(start)).transpose(-1, -2);        // (N, 1, 3, 3)
  const Tensor placed = torch::matmul(joints - ground, rotation);
  const Tensor root = placed.narrow(2, 0, 1), step = torch::diff(placed, 1, 1), none = torch::zeros_like(start);
  const Tensor swerve = torch::diff(step, 1, 1).norm(2, {3}), still = none.select(3, 0);
  return torch::cat({torch::cat({root, placed.slice(2, 1) - root, torch::cat({none, step}, 1)}, 2).flatten(2),
                     torch::cat({still, still, swerve}, 1)},
                    2)
      .transpose(1, 2)
      .contiguous();
}

MotionAutoencoderImpl::MotionAutoencoderImpl() {
  const auto convolution = [](int64_t in, int64_t out, int64_t stride) {
    return torch::nn::Conv1d(torch::nn::Conv1dOptions(in, out, 5).stride(stride).padding(2));
  };
  for (size_t level = 1; level < kLengths.size(); ++level) {
    encoder->push_back(convolution(level == 1 ? kChannels : kWidth, kWidth, 2));
    encoder->push_back(torch::nn::SiLU());
    const size_t up = kLengths.size() - 1 - level;
    decoder_layers->push_back(torch::nn::Upsample(
        torch::nn::UpsampleOptions().size(std::vector<int64_t>{kLengths[up]}).mode(torch::kNearest)));
    decoder_layers->push_back(convolution(kWidth, kWidth, 1));
    decoder_layers->push_back(torch::nn::SiLU());
  }
  decoder_layers->push_back(convolution(kWidth, kChannels, 1));
  register_module("encoder", encoder);
  register_module("decoder", decoder_layers);
  narrow = register_module("narrow", torch::nn::Linear(kWidth * kLengths.back(), kMotionFeatures));
  widen = register_module("widen", torch::nn::Linear(kMotionFeatures, kWidth * kLengths.back()));
  scale = register_module("scale", nn::BatchNorm(kMotionFeatures, nn::kNormEps, /*affine=*/false));
  mean = register_buffer("mean", torch::zeros({kChannels}));
  deviation = register_buffer("deviation", torch::ones({kChannels}));
}

Tensor MotionAutoencoderImpl::standardised(const Tensor& joints) {
  return FeatureScale{mean, deviation}.to_network(motion_channels(joints).transpose(1, 2)).transpose(1, 2);
}

Tensor MotionAutoencoderImpl::encode(const Tensor& channels) {
  return scale->forward(narrow->forward(encoder->forward(channels).flatten(1)));
}

Tensor MotionAutoencoderImpl::decode(const Tensor& features) {
  return decoder_layers->forward(F::silu(widen->forward(features)).unflatten(1, {kWidth, kLengths.back()}));
}

Tensor motion_features(MotionAutoencoder network, const Tensor& joints) {
  const torch::NoGradGuard no_gradients;
  require_windows(joints, "motion features");
  if (network->is_training()) network->eval();
  return network->encode(network->standardised(joints));
}

TrainTask motion_autoencoder_task(MotionAutoencoder network, const Tensor& train, const Tensor& validation) {
  require_windows(train, "training windows");
  require_windows(validation, "validation windows");
  set_scale(*network, train);
  TrainTask task;
  task.module = network.ptr();
  task.networks = {{"", network.ptr()}};
  task.samples = train.size(0);
  task.prepare = batches([train](const TrainStep& step) { return train.index_select(0, torch::tensor(step.indices)); },
                         [network](const Tensor& joints, const TrainStep&) mutable {
                           const Tensor channels = network->standardised(joints.to(network->mean.device()));
                           return Losses{{"total", reconstruction_error(network, channels)}};
                         });
  task.validate = [network, validation]() mutable {
    double sum = 0;
    for (const Tensor& part : validation.split(256))
      sum += reconstruction_error(network, network->standardised(part.to(network->mean.device()))).item<double>() *
             static_cast<double>(part.size(0));
    return sum / static_cast<double>(validation.size(0));
  };
  return task;
}

SafeTensors motion_autoencoder_header() { return nn::model_content(kAutoencoder, "{}"); }

MotionAutoencoder load_motion_autoencoder(const std::string& path) {
  const nn::ModelFile file = nn::read_model_file(path);
  file.config_of(kAutoencoder);
  MotionAutoencoder network;
  nn::load_parameters(*network, "", file.content, path);
  if ((network->deviation <= 0).any().item<bool>()) throw Error(path, "deviation is not positive");
  return network;
}

}  // namespace inhabit::inbetween
