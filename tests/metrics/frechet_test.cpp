// Protects the Frechet distance: closed forms where Gaussians are known, and that it grows with what is wrong.
#include "inhabit/metrics/frechet.h"

#include <gmock/gmock.h>

#include <Eigen/QR>
#include <random>

#include "inhabit/math/random.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

using testing::HasSubstr;

Eigen::MatrixXd drawn(int rows, int columns, uint64_t seed) {
  std::mt19937_64 random(seed);
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

torch::Tensor normal_features(int64_t count, int64_t size, double mean, double deviation, uint64_t seed) {
  std::mt19937_64 random(seed);
  torch::Tensor out = torch::empty({count, size}, torch::kDouble);
  for (int64_t i = 0; i < out.numel(); ++i) out.data_ptr<double>()[i] = normal(random, mean, deviation);
  return out;
}

TEST(FrechetDistance, OfOneDimensionIsMeansAndDeviationsApart) {
  const FeatureGaussian a{Eigen::VectorXd::Constant(1, 2), Eigen::MatrixXd::Constant(1, 1, 9)},
      b{Eigen::VectorXd::Constant(1, -1), Eigen::MatrixXd::Constant(1, 1, 4)};
  EXPECT_NEAR(frechet_distance(a, b), 9 + 1, 1e-12);  // (2 + 1)^2 + (3 - 2)^2
}

TEST(FrechetDistance, OfCovariancesThatCommuteIsThatOfTheirRoots) {
  // Both have the same axes, turned somehow: the distance is the sum over them.
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(drawn(4, 4, 1)).householderQ();
  const Eigen::Vector4d s(1, 2, 0, 5), r(3, 2, 4, 0.5);  // one axis without spread
  const FeatureGaussian a{Eigen::Vector4d(1, 0, 0, 2), q * s.cwiseAbs2().asDiagonal() * q.transpose()},
      b{Eigen::Vector4d(0, 0, 3, 2), q * r.cwiseAbs2().asDiagonal() * q.transpose()};
  EXPECT_NEAR(frechet_distance(a, b), 10 + (s - r).squaredNorm(), 1e-6);
}

TEST(FrechetDistance, OfTwoByTwoIsItsClosedForm) {
  // tr (A B)^1/2 of 2 x 2 matrices is (tr AB + 2 (det AB)^1/2)^1/2; these two do not commute.
  Eigen::Matrix2d a, b;
  a << 2, 1, 1, 3;
  b << 4, -1, -1, 1;
  const Eigen::Matrix2d ab = a * b;
  const double expected = a.trace() + b.trace() - 2 * std::sqrt(ab.trace() + 2 * std::sqrt(ab.determinant()));
  const Eigen::Vector2d zero = Eigen::Vector2d::Zero();
  EXPECT_NEAR(frechet_distance({zero, a}, {zero, b}), expected, 1e-12);
  EXPECT_NEAR(frechet_distance({zero, b}, {zero, a}), expected, 1e-12);
}

TEST(FrechetDistance, OfASetToItselfIsZeroAndRisesWithShiftAndSpread) {
  const torch::Tensor real = normal_features(400, 6, 0, 1, 1);
  const FeatureGaussian gaussian = feature_gaussian(real);
  EXPECT_NEAR(frechet_distance(gaussian, gaussian), 0, 1e-9);
  EXPECT_NEAR(frechet_distance(gaussian, feature_gaussian(real + 0.5)), 6 * 0.25, 1e-9);
  EXPECT_NEAR(frechet_distance(gaussian, feature_gaussian(real * 2)),
              gaussian.covariance.trace() + gaussian.mean.squaredNorm(),
              1e-9);  // roots differ by the root itself, means by the mean itself
  const double other = frechet_distance(gaussian, feature_gaussian(normal_features(400, 6, 0, 1, 2)));
  EXPECT_GT(other, 0);
  EXPECT_LT(other, 0.15);  // two draws of 400 from the same
}

TEST(FeatureGaussian, IsMeanAndUnbiasedCovariance) {
  const FeatureGaussian g = feature_gaussian(torch::tensor({1., 2., 3., 6., 5., 1.}).view({3, 2}));
  EXPECT_TRUE(g.mean.isApprox(Eigen::Vector2d(3, 3)));
  Eigen::Matrix2d expected;
  expected << 4, -1, -1, 7;
  EXPECT_TRUE(g.covariance.isApprox(expected));
}

TEST(FeatureGaussian, RefusesWhatHasNone) {
  EXPECT_THAT(refusal_of([] { feature_gaussian(torch::zeros({1, 4})); }), HasSubstr("two feature vectors"));
  EXPECT_THAT(refusal_of([] { feature_gaussian(torch::full({3, 2}, NAN)); }), HasSubstr("not finite"));
  const FeatureGaussian two = feature_gaussian(torch::rand({4, 2})), three = feature_gaussian(torch::rand({4, 3}));
  EXPECT_THAT(refusal_of([&] { frechet_distance(two, three); }), HasSubstr("different sizes"));
}

TEST(FeatureGaussian, CountsRowsAsOftenAsToldTo) {
  const torch::Tensor features = normal_features(6, 3, 1, 2, 4), counts = torch::tensor({2., 0., 1., 1., 3., 1.});
  const FeatureGaussian counted = feature_gaussian(features, counts),
                        repeated = feature_gaussian(features.index_select(0, torch::tensor({0, 0, 2, 3, 4, 4, 4, 5})));
  EXPECT_LT((counted.mean - repeated.mean).norm(), 1e-12);
  EXPECT_LT((counted.covariance - repeated.covariance).norm(), 1e-12);
  EXPECT_THAT(refusal_of([&] { feature_gaussian(features, counts.slice(0, 1)); }), HasSubstr("one count"));
}

TEST(PrincipalDirections, AreThoseOfTheLargestVariance) {
  // Deviations 5, 3, 1 and 0.1 along turned axes.
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(drawn(4, 4, 5)).householderQ();
  const Eigen::Vector4d deviations(5, 3, 1, 0.1);
  const Eigen::MatrixXd samples = drawn(20000, 4, 6) * deviations.asDiagonal() * q.transpose();
  torch::Tensor features = torch::empty({20000, 4}, torch::kDouble);
  for (int64_t i = 0; i < 20000; ++i)
    for (int64_t k = 0; k < 4; ++k) features.data_ptr<double>()[4 * i + k] = samples(i, k);
  const torch::Tensor directions = principal_directions(features, 2);
  EXPECT_TRUE(directions.t().matmul(directions).allclose(torch::eye(2, torch::kDouble), 0, 1e-9));
  for (int64_t d = 0; d < 2; ++d) {
    double along = 0;
    for (int64_t i = 0; i < 4; ++i) along += directions.data_ptr<double>()[2 * i + d] * q(i, d);
    EXPECT_NEAR(std::abs(along), 1, 1e-3) << d;
  }
  EXPECT_NEAR(features.matmul(directions).std(0)[0].item<double>(), 5, 0.1);
  // The Frechet distance along all axes is the one of the features themselves.
  const torch::Tensor other = features + 0.3, all = principal_directions(features, 4);
  EXPECT_NEAR(frechet_distance(feature_gaussian(features.matmul(all)), feature_gaussian(other.matmul(all))), 4 * 0.09,
              1e-6);
  for (const int64_t d : {0, 5})
    EXPECT_THAT(refusal_of([&] { principal_directions(features, d); }), HasSubstr("principal directions"));
}

}  // namespace
}  // namespace inhabit
