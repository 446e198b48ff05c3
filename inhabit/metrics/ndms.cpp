#include "inhabit/metrics/ndms.h"

namespace inhabit {

using torch::Tensor;

namespace {

constexpr double kEpsilon = 1e-12;  // of Eq. 12: far under the square of any motion, so that it decides nothing else
constexpr double kRest = 1e-6;      // metres a frame: far under any motion, over the rounding of joints that rest

}  // namespace

Tensor ndms(const Tensor& words, const Tensor& others, NdmsForm form, double softness) {
  const bool floored = form == NdmsForm::package, soft = softness > 0;
  const auto velocity = [&](const Tensor& w) {
    const Tensor d = soft ? w : w.to(torch::kFloat64);
    return d.slice(1, 1) - d.slice(1, 0, -1);
  };
  const auto length = [&](const Tensor& v) {
    if (soft) return (v.square().sum(3) + softness * softness).sqrt();
    const Tensor l = v.norm(2, {3});
    return floored ? l.clamp_min(1e-7) : l.masked_fill(l < kRest, 0);
  };
  const double epsilon = floored || soft ? 0 : kEpsilon;
  const Tensor a = velocity(words), b = velocity(others), length_a = length(a), length_b = length(b);
  Tensor direction = (a * b).sum(3) / (length_a * length_b + epsilon);
  if (form == NdmsForm::coded)
    direction = direction.masked_fill((direction < 0.9999).logical_and((a - b).sum(3) < 1e-6), 1);
  const Tensor ratio = torch::minimum(length_a, length_b) / (torch::maximum(length_a, length_b) + epsilon);
  Tensor each = 0.5 * (1 + direction) * ratio;
  if (soft) each = each.masked_fill(torch::maximum(a.detach().norm(2, {3}), b.detach().norm(2, {3})) < kRest, 0);
  return each.mean({1, 2});
}

namespace {

Tensor nearest_words(const Tensor& words, const WordIndex& database) {
  return database.words().index_select(0, database.nearest(words)).view(words.sizes());
}

}  // namespace

Tensor plausibility(const Tensor& words, const WordIndex& database, NdmsForm form, double softness) {
  return ndms(words, nearest_words(words, database), form, softness);
}

WordScores word_scores(const Tensor& words, const WordIndex& database, WordKind kind) {
  const Tensor nearest = nearest_words(words, database);
  return {ndms(words, nearest, kind == WordKind::package ? NdmsForm::package : NdmsForm::equation),
          ndms(words, nearest, NdmsForm::coded)};
}

}  // namespace inhabit
