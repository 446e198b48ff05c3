#include "inhabit/metrics/frechet.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "inhabit/error.h"

namespace inhabit {

using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

FeatureGaussian feature_gaussian(const torch::Tensor& features) {
  if (features.dim() != 2) throw Error("Frechet distance", "needs two feature vectors or more");
  return feature_gaussian(features, torch::ones({features.size(0)}, torch::kDouble));
}

FeatureGaussian feature_gaussian(const torch::Tensor& features, const torch::Tensor& counts) {
  if (features.dim() != 2 || features.size(0) < 2 || features.size(1) < 1)
    throw Error("Frechet distance", "needs two feature vectors or more");
  if (counts.dim() != 1 || counts.size(0) != features.size(0))
    throw Error("Frechet distance", "needs one count a vector");
  if (!features.isfinite().all().item<bool>()) throw Error("Frechet distance", "a feature is not finite");
  const torch::Tensor x = features.to(torch::kCPU, torch::kDouble).contiguous(),
                      c = counts.to(torch::kCPU, torch::kDouble).contiguous();
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Rows> rows(x.data_ptr<double>(), x.size(0), x.size(1));
  const Eigen::Map<const Eigen::VectorXd> weights(c.data_ptr<double>(), c.size(0));
  FeatureGaussian out;
  out.mean = rows.transpose() * weights / weights.sum();
  const Rows centred = rows.rowwise() - out.mean.transpose();
  out.covariance = centred.transpose() * weights.asDiagonal() * centred / (weights.sum() - 1);
  return out;
}

torch::Tensor principal_directions(const torch::Tensor& features, int64_t d) {
  const FeatureGaussian gaussian = feature_gaussian(features);
  const int64_t size = gaussian.mean.size();
  if (d < 1 || d > size) throw Error("principal directions", "are not from 1 to the number of features");
  const Solver axes(gaussian.covariance);  // the smallest eigenvalue first
  torch::Tensor out = torch::empty({size, d}, torch::kDouble);
  for (int64_t i = 0; i < size; ++i)
    for (int64_t k = 0; k < d; ++k) out.data_ptr<double>()[i * d + k] = axes.eigenvectors()(i, size - 1 - k);
  return out;
}

double frechet_distance(const FeatureGaussian& first, const FeatureGaussian& second) {
  if (first.mean.size() != second.mean.size())
    throw Error("Frechet distance", "the two sets have features of different sizes");
  // Rounding makes eigenvalues that are zero a little negative.
  const Solver own(first.covariance);
  const Eigen::MatrixXd root =
      own.eigenvectors() * own.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * own.eigenvectors().transpose();
  const Solver product(root * second.covariance * root, Eigen::EigenvaluesOnly);
  const double distance = (first.mean - second.mean).squaredNorm() + first.covariance.trace() +
                          second.covariance.trace() - 2 * product.eigenvalues().cwiseMax(0).cwiseSqrt().sum();
  return std::max(0.0, distance);
}

torch::Tensor FrechetReference::along(const torch::Tensor& others) const {
  return others.to(torch::kDouble).matmul(directions);
}

double FrechetReference::distance(const torch::Tensor& others) const {
  return frechet_distance(gaussian, feature_gaussian(along(others)));
}

FrechetReference frechet_reference(const torch::Tensor& features) {
  constexpr int64_t kPerDimension = 10;
  FrechetReference out;
  const torch::Tensor all = features.to(torch::kDouble);
  out.directions = principal_directions(
      all, std::clamp<int64_t>(all.size(0) / kPerDimension, 1, std::max<int64_t>(1, all.size(-1))));
  out.features = all.matmul(out.directions);
  out.gaussian = feature_gaussian(out.features);
  return out;
}

}  // namespace inhabit
