#include "inhabit/metrics/npss.h"

#include "inhabit/error.h"

namespace inhabit {

using torch::Tensor;

Tensor npss_terms(const Tensor& truth, const Tensor& forecast, NpssForm form) {
  if (truth.dim() != 3 || truth.sizes() != forecast.sizes())
    throw Error("NPSS compares sequences of one shape (B, T, D)");
  const auto power = [&](const Tensor& x) {
    const Tensor spectrum = torch::fft_fft(x.to(torch::kFloat64), {}, 1);
    const Tensor real = torch::real(spectrum).square();
    return form == NpssForm::real_part ? real : real + torch::imag(spectrum).square();
  };
  const Tensor a = power(truth), b = power(forecast);   // (B, T, D)
  const Tensor total_a = a.sum(1), total_b = b.sum(1);  // (B, D)
  const Tensor known = (total_a > 1e-12) & (total_b > 1e-12);
  const auto fraction = [&](const Tensor& p, const Tensor& total) {
    return (p / torch::where(known, total, torch::ones_like(total)).unsqueeze(1)).cumsum(1);
  };
  const Tensor distance = (fraction(a, total_a) - fraction(b, total_b)).abs().sum(1);
  const Tensor weight = total_a * known.to(torch::kFloat64);
  return torch::stack({(distance * weight).sum(1), weight.sum(1)}, 1);
}

double npss(const Tensor& truth, const Tensor& forecast, NpssForm form) {
  const Tensor terms = npss_terms(truth, forecast, form).sum(0);
  if (terms[1].item<double>() <= 0) throw Error("NPSS: nothing moves in the sequences");
  return (terms[0] / terms[1]).item<double>();
}

}  // namespace inhabit
