#include "inhabit/metrics/ndms.h"

namespace inhabit {

using torch::Tensor;

Tensor ndms(const Tensor& words, const Tensor& others) {
  const auto velocity = [](const Tensor& w) {
    const Tensor d = w.to(torch::kFloat64);
    return d.slice(1, 1) - d.slice(1, 0, -1);
  };
  const Tensor a = velocity(words), b = velocity(others);
  const Tensor length_a = a.norm(2, {3}).clamp_min(1e-7), length_b = b.norm(2, {3}).clamp_min(1e-7);
  const Tensor direction = (a * b).sum(3) / (length_a * length_b);
  const Tensor ratio = torch::minimum(length_a, length_b) / torch::maximum(length_a, length_b);
  return (0.5 * (1 + direction) * ratio).mean({1, 2});
}

Tensor plausibility(const Tensor& words, const WordIndex& database) {
  return ndms(words, database.words().index_select(0, database.nearest(words)).view(words.sizes()));
}

}  // namespace inhabit
