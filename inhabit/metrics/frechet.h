#pragma once
#include <torch/types.h>

#include <Eigen/Core>

namespace inhabit {

/// What the Frechet distance sees of a set of feature vectors: the Gaussian with its mean and covariance.
struct FeatureGaussian {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

/// Of features (N, D), N > 1, all finite; the covariance is the unbiased one.
FeatureGaussian feature_gaussian(const torch::Tensor& features);

/// Squared Frechet distance between two Gaussians (the "FID" of feature vectors of a network, Heusel et al. 2017):
/// |m1 - m2|^2 + tr(C1 + C2 - 2 (C1^1/2 C2 C1^1/2)^1/2), roots by symmetric eigendecomposition.
double frechet_distance(const FeatureGaussian& first, const FeatureGaussian& second);

}  // namespace inhabit
