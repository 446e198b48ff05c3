// Protects the smoother of noisy keys: it solves the least-squares problem it says, one axis of rotations is as a
// number, and what it gives is nearer to the truth than what it was given.
#include "inhabit/inbetween/key_smoother.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/inbetween/evaluate.h"
#include "inhabit/inbetween/interpolate.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/math/random.h"

namespace inhabit::inbetween {
namespace {

constexpr double kNoise = 0.02, kAcceleration = 3, kRate = 30;

std::vector<char> exact_ends(size_t keys) {
  std::vector<char> out(keys, 0);
  out.front() = out.back() = 1;
  return out;
}

// The same problem by dense QR of its residuals, each divided by its deviation.
TEST(KeySmoother, SolvesTheLeastSquaresOfItsModel) {
  const std::vector<int64_t> keys = {0, 2, 3, 7, 11};
  const KeySmoother smoother(12, keys, exact_ends(keys.size()), kNoise, kAcceleration, kRate);
  std::mt19937_64 random(3);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(12, 1);
  for (const int64_t key : keys) values(key, 0) = uniform(random, -0.1, 0.1);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(15, 12);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(15);
  for (int k = 0; k < 5; ++k) {
    const double sigma = k == 0 || k == 4 ? 1e-6 : kNoise;
    rows(k, keys[static_cast<size_t>(k)]) = 1 / sigma;
    right[k] = values(keys[static_cast<size_t>(k)], 0) / sigma;
  }
  for (int t = 1; t < 11; ++t)
    for (int i = -1; i <= 1; ++i) rows(4 + t, t + i) = (i == 0 ? -2 : 1) * kRate * kRate / kAcceleration;
  const Eigen::VectorXd expected = rows.colPivHouseholderQr().solve(right);
  EXPECT_LT((smoother.places(values) - expected).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(KeySmoother, RotatesAboutOneAxisAsItMovesOneNumber) {
  const std::vector<int64_t> keys = {0, 3, 6, 9, 12, 15};
  const KeySmoother smoother(16, keys, exact_ends(keys.size()), kNoise, kAcceleration, kRate);
  std::mt19937_64 random(4);
  Eigen::MatrixXd angles = Eigen::MatrixXd::Zero(16, 1);
  for (const int64_t key : keys) angles(key, 0) = 0.3 * static_cast<double>(key) + uniform(random, -0.1, 0.1);
  std::vector<Eigen::Quaterniond> rotations;
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, -1).normalized();
  for (int64_t t = 0; t < 16; ++t) {
    const int64_t before = t / 3 * 3, after = std::min<int64_t>(before + 3, 15);
    const double part = static_cast<double>(t - before) / 3;
    rotations.emplace_back(Eigen::AngleAxisd(angles(before, 0) + part * (angles(after, 0) - angles(before, 0)), axis));
  }
  const Eigen::MatrixXd expected = smoother.places(angles);
  const std::vector<Eigen::Quaterniond> smoothed = smoother.rotations(rotations);
  for (int64_t t = 0; t < 16; ++t)
    EXPECT_LT(
        smoothed[static_cast<size_t>(t)].angularDistance(Eigen::Quaterniond(Eigen::AngleAxisd(expected(t, 0), axis))),
        1e-6)
        << t;
}

TEST(KeySmoother, NoisyKeysComeNearerToTheTruthThanByInterpolation) {
  Clip truth;
  truth.skeleton = shaped_skeleton(builtin_body(), {});
  const torch::Tensor seconds = torch::arange(121) / 30.;
  truth.rotations = 0.4 * torch::sin(seconds.view({-1, 1, 1}) * torch::linspace(1, 4, 66).view({1, 22, 3}));
  truth.trans = torch::stack({0.8 * seconds, 0.9 + 0.03 * torch::sin(6 * seconds), torch::sin(seconds)}, 1);
  truth.rotations = truth.rotations.to(torch::kFloat32);
  truth.trans = truth.trans.to(torch::kFloat32);
  truth.joints = joint_positions(truth.skeleton, truth.rotations, truth.trans);
  const std::vector<int64_t> keys = key_frames("every:3", 121);
  const Clip noisy = noisy_keys(truth, 1, 5);
  const auto error = [&](const Clip& clip) { return (clip.joints - truth.joints).norm(2, {2}).mean().item<double>(); };
  const Clip smooth = smooth_keys(noisy, keys, 1);
  EXPECT_LT(error(smooth), 0.8 * error(interpolate_linear(noisy, keys)));
  EXPECT_LT(error(smooth), 0.8 * error(noisy));
  for (const int64_t end : {0, 120}) {
    EXPECT_TRUE(smooth.trans[end].equal(noisy.trans[end]));
    EXPECT_TRUE(smooth.rotations[end].equal(noisy.rotations[end]));
  }
  // Without noise it is a curve through the keys.
  const Clip through = smooth_keys(truth, keys, 0);
  for (const int64_t key : keys) EXPECT_LT((through.joints[key] - truth.joints[key]).norm().item<double>(), 1e-4);
}

}  // namespace
}  // namespace inhabit::inbetween
