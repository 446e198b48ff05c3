#include "inhabit/metrics/forecast_error.h"

namespace inhabit {

torch::Tensor path_error(const torch::Tensor& predicted, const torch::Tensor& truth, int64_t root) {
  return (predicted.select(2, root) - truth.select(2, root)).norm(2, -1);
}

torch::Tensor pose_error(const torch::Tensor& predicted, const torch::Tensor& truth, int64_t root) {
  auto local = [root](const torch::Tensor& joints) { return joints - joints.narrow(2, root, 1); };
  // The root's own row is zero in both, so the sum over all joints is the sum over the others.
  return (local(predicted) - local(truth)).norm(2, -1).sum(-1) / static_cast<double>(truth.size(2) - 1);
}

FuturesError with_best(const torch::Tensor& each) { return {each, each[each.mean(1).argmin()]}; }

FuturesError futures_error(const torch::Tensor& futures, const torch::Tensor& truth) {
  return with_best(pose_error(futures, truth.unsqueeze(0), 0));
}

torch::Tensor nearest_future(const torch::Tensor& futures, const torch::Tensor& truth) {
  return (futures - truth.unsqueeze(1)).norm(2, {4}).mean({2, 3}).argmin(1);
}

}  // namespace inhabit
