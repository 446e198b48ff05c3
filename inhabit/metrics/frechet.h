#pragma once
#include <torch/types.h>

#include <Eigen/Core>

namespace inhabit {

/// What the Frechet distance sees of a set of feature vectors: the Gaussian with its mean and covariance.
struct FeatureGaussian {
  Eigen::VectorXd mean;        ///< (D)
  Eigen::MatrixXd covariance;  ///< (D, D)
};

/// Of features (N, D), N > 1, all finite; the covariance is the unbiased one.
FeatureGaussian feature_gaussian(const torch::Tensor& features);

/// The same of a resample in which row i counts counts[i] times (bootstrap.h).
FeatureGaussian feature_gaussian(const torch::Tensor& features, const torch::Tensor& counts);

/// The directions in which features (N, D) vary most: (D, d) orthonormal columns, double, eigenvectors of the
/// covariance with the largest eigenvalues, in their order. A covariance of D (D + 1) / 2 numbers needs more samples
/// than D; features.matmul(directions) needs fewer.
torch::Tensor principal_directions(const torch::Tensor& features, int64_t d);

/// Squared Frechet distance between two Gaussians (the "FID" of feature vectors of a network, Heusel et al. 2017):
/// |m1 - m2|^2 + tr(C1 + C2 - 2 (C1^1/2 C2 C1^1/2)^1/2), roots by symmetric eigendecomposition.
double frechet_distance(const FeatureGaussian& first, const FeatureGaussian& second);

/// What the features of a reference, real motion, are compared along: one of their principal directions for every ten
/// of them, for fewer do not tell a covariance.
struct FrechetReference {
  torch::Tensor directions;  ///< (D, d) double
  torch::Tensor features;    ///< (N, d) double, of the reference
  FeatureGaussian gaussian;  ///< of `features`

  /// d, the number of directions.
  int64_t dimensions() const { return directions.size(1); }
  /// (M, d) double from other features (M, D).
  torch::Tensor along(const torch::Tensor& others) const;
  /// Of other features (M, D), M > 1, from the reference.
  double distance(const torch::Tensor& others) const;
};

/// Of features (N, D), N > 1, all finite.
FrechetReference frechet_reference(const torch::Tensor& features);

}  // namespace inhabit
