#include "inhabit/math/dct.h"

#include <cmath>

#include "inhabit/error.h"

namespace inhabit {
namespace {

torch::Tensor exact_dct_matrix(int64_t length, int64_t count) {
  if (length < 1 || count < 1 || count > length)
    throw Error("DCT of " + std::to_string(length) + " frames cannot have " + std::to_string(count) + " coefficients");
  torch::Tensor basis = torch::empty({count, length}, torch::kFloat64);
  auto entry = basis.accessor<double, 2>();
  const auto n = static_cast<double>(length);
  for (int64_t l = 0; l < count; ++l) {
    const double scale = std::sqrt((l == 0 ? 1.0 : 2.0) / n);
    for (int64_t p = 0; p < length; ++p)
      entry[l][p] = scale * std::cos(M_PI / n * (static_cast<double>(p) + 0.5) * static_cast<double>(l));
  }
  return basis;
}

}  // namespace

torch::Tensor dct_matrix(int64_t length, int64_t count) { return exact_dct_matrix(length, count).to(torch::kFloat32); }

torch::Tensor idct_matrix(int64_t length, int64_t count) {
  return exact_dct_matrix(length, count).t().contiguous().to(torch::kFloat32);
}

torch::Tensor padded_dct_matrix(int64_t past, int64_t future, int64_t count) {
  if (past < 1 || future < 0) throw Error("a padded DCT needs at least one frame");
  const torch::Tensor whole = exact_dct_matrix(past + future, count);
  torch::Tensor head = whole.slice(1, 0, past).clone();
  head.select(1, past - 1).copy_(whole.slice(1, past - 1).sum(1));
  return head.to(torch::kFloat32);
}

}  // namespace inhabit
