#include "inhabit/metrics/frechet.h"

#include <Eigen/Eigenvalues>

#include "inhabit/error.h"

namespace inhabit {

using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

FeatureGaussian feature_gaussian(const torch::Tensor& features) {
  if (features.dim() != 2 || features.size(0) < 2 || features.size(1) < 1)
    throw Error("Frechet distance", "needs two feature vectors or more");
  if (!features.isfinite().all().item<bool>()) throw Error("Frechet distance", "a feature is not finite");
  const torch::Tensor x = features.to(torch::kCPU, torch::kDouble).contiguous();
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const Rows> rows(x.data_ptr<double>(), x.size(0), x.size(1));
  FeatureGaussian out;
  out.mean = rows.colwise().mean();
  const Eigen::MatrixXd centred = rows.rowwise() - out.mean.transpose();
  out.covariance = centred.transpose() * centred / static_cast<double>(x.size(0) - 1);
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

}  // namespace inhabit
