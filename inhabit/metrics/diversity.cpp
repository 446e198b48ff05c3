#include "inhabit/metrics/diversity.h"

#include "inhabit/error.h"

namespace inhabit {

torch::Tensor average_pairwise_distance(const torch::Tensor& samples) {
  const int64_t count = samples.size(0);
  if (count < 2) throw Error("APD needs two futures or more");
  const torch::Tensor by_frame = samples.to(torch::kFloat64).transpose(0, 1);  // (T, S, D)
  return torch::cdist(by_frame, by_frame).sum({1, 2}) / static_cast<double>(count * (count - 1));
}

double sequence_pairwise_distance(const torch::Tensor& samples) {
  return average_pairwise_distance(samples.flatten(1).unsqueeze(1))[0].item<double>();
}

}  // namespace inhabit
