#include "inhabit/anticipate/released_labels.h"

#include "inhabit/error.h"
#include "inhabit/math/random.h"

namespace inhabit::anticipate {

using torch::Tensor;

namespace {

constexpr int64_t kAutoencoderSteps = 2000, kAutoencoderBatch = 256;

}  // namespace

Tensor label_views(const Tensor& poses) {
  static const Tensor legs = torch::tensor({1, 4, 7, 2, 5, 8}) - 1;  // standard joints, of which poses lack the root
  const int64_t frames = poses.size(0), stride = ReleasedIntentionNetworkImpl::kStride;
  const Tensor joints = poses.unflatten(1, {21, 3}).index_select(1, legs);
  Tensor out = torch::zeros({frames, LabelAutoencoderImpl::kFrames, LabelAutoencoderImpl::kJoints, 3});
  for (int64_t k = 0; k < LabelAutoencoderImpl::kFrames; ++k) {
    const Tensor at = (torch::arange(frames) + (k - 1) * stride).clamp(0, frames - 1);
    out.select(1, k).narrow(1, 0, LabelAutoencoderImpl::kLegs).copy_(joints.index_select(0, at));
  }
  return out;
}

IntentionClusters cluster_released(const std::vector<Tensor>& sequences, int64_t labels, uint64_t seed) {
  if (sequences.empty()) throw Error("clustering: no motion");
  std::vector<Tensor> some;
  some.reserve(sequences.size());
  for (const Tensor& poses : sequences) some.push_back(label_views(poses));
  const Tensor all = torch::cat(some);
  torch::manual_seed(seed);
  LabelAutoencoder network(kLabelHidden, kLabelCode);
  torch::optim::Adam optimiser(network->parameters(), torch::optim::AdamOptions(1e-3));
  std::mt19937_64 random(item_seed(seed, 7));
  {
    const torch::AutoGradMode gradients(true);
    for (int64_t step = 0; step < kAutoencoderSteps; ++step) {
      std::vector<int64_t> rows;
      for (int64_t i = 0; i < kAutoencoderBatch; ++i)
        rows.push_back(uniform_int(random, 0, static_cast<int>(all.size(0) - 1)));
      const Tensor batch = all.index_select(0, torch::tensor(rows));
      optimiser.zero_grad();
      (network->decode(network->encode(batch)) - batch).square().mean().backward();
      optimiser.step();
    }
  }
  network->eval();
  const torch::NoGradGuard no_gradients;
  IntentionClusters out;
  out.encoder = network.ptr();
  out.codes = kmeans(network->encode(all), labels, seed);
  return out;
}

Tensor released_labels(const Tensor& poses, const IntentionClusters& clusters) {
  const torch::NoGradGuard no_gradients;
  return nearest_centre(clusters.encoder->encode(label_views(poses)), clusters.codes);
}

}  // namespace inhabit::anticipate
