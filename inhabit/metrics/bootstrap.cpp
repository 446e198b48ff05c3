#include "inhabit/metrics/bootstrap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "inhabit/error.h"
#include "inhabit/math/random.h"

namespace inhabit {

using torch::Tensor;

Tensor bootstrap_counts(int64_t items, int64_t resamples, uint64_t seed) {
  if (items < 1 || resamples < 1) throw Error("bootstrap", "needs an item and a resample or more");
  Tensor out = torch::zeros({resamples, items}, torch::kDouble);
  double* counts = out.data_ptr<double>();
  for (int64_t r = 0; r < resamples; ++r, counts += items) {
    std::mt19937_64 random(item_seed(seed, static_cast<uint64_t>(r)));
    for (int64_t i = 0; i < items; ++i) counts[random() % static_cast<uint64_t>(items)] += 1;
  }
  return out;
}

double half_interval(std::vector<double> statistics) {
  statistics.erase(std::remove_if(statistics.begin(), statistics.end(), [](double s) { return !std::isfinite(s); }),
                   statistics.end());
  if (statistics.size() < 2) return 0;
  std::sort(statistics.begin(), statistics.end());
  const auto percentile = [&](double fraction) {
    const double at = fraction * static_cast<double>(statistics.size() - 1);
    const auto below = static_cast<size_t>(at);
    const size_t above = std::min(below + 1, statistics.size() - 1);
    return statistics[below] + (at - static_cast<double>(below)) * (statistics[above] - statistics[below]);
  };
  return (percentile(0.975) - percentile(0.025)) / 2;
}

std::vector<double> resampled_ratios(const Tensor& numerators, const Tensor& denominators, const Tensor& counts) {
  const Tensor above = counts.mv(numerators.to(torch::kDouble)), below = counts.mv(denominators.to(torch::kDouble));
  std::vector<double> out(static_cast<size_t>(counts.size(0)));
  for (size_t r = 0; r < out.size(); ++r) {
    const double d = below.data_ptr<double>()[r];
    out[r] = d != 0 ? above.data_ptr<double>()[r] / d : std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

}  // namespace inhabit
