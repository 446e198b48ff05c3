#include "inhabit/scene/contact_map.h"

#include <gtest/gtest.h>

#include "inhabit/error.h"

namespace inhabit {
namespace {

torch::Tensor plain(const torch::Tensor& joints, const torch::Tensor& points, double sigma) {
  const torch::Tensor d2 = (joints.to(torch::kFloat64).unsqueeze(-2) - points.to(torch::kFloat64)).square().sum(-1);
  return torch::exp(-0.5 * d2 / (sigma * sigma));
}

TEST(ContactMap, EquationsAtKnownDistances) {
  const torch::Tensor joints = torch::tensor({0.F, 0.F, 0.F, 1.F, 0.F, 0.F}).view({2, 3});
  const torch::Tensor points = torch::tensor({0.F, 0.F, 0.F, 0.F, 0.3F, 0.F, 0.F, 0.F, 2.F}).view({3, 3});
  const torch::Tensor d = distance_map(joints, points);
  EXPECT_TRUE(torch::allclose(d[0], torch::tensor({0.F, 0.3F, 2.F})));
  EXPECT_TRUE(torch::allclose(d[1], torch::tensor({1.F, std::sqrt(1.09F), std::sqrt(5.F)})));
  const torch::Tensor c = contact_map(joints, points, 0.2);
  EXPECT_NEAR(c[0][0].item<float>(), 1, 1e-6);
  EXPECT_NEAR(c[0][1].item<float>(), 0.3246525, 1e-6);  // the threshold "within 0.3 m"
  EXPECT_NEAR(c[0][2].item<float>(), 0, 1e-6);
}

TEST(ContactMap, Batches) {
  torch::manual_seed(2);
  const torch::Tensor points = torch::rand({3, 50, 3}), joints = torch::rand({3, 7, 22, 3});
  const torch::Tensor together = contact_map(joints, points);
  ASSERT_EQ(together.sizes(), (torch::IntArrayRef{3, 7, 22, 50}));
  for (int64_t b = 0; b < 3; ++b) {
    EXPECT_TRUE(torch::allclose(together[b], contact_map(joints[b], points[b]), 0, 2e-6));
    EXPECT_TRUE(torch::allclose(distance_map(joints, points)[b], distance_map(joints[b], points[b]), 0, 1e-6));
  }
}

TEST(ContactMap, GradientsEqualFiniteDifferences) {
  torch::manual_seed(3);
  const torch::Tensor points = torch::rand({9, 3}, torch::kFloat64) * 0.4,
                      weights = torch::rand({2, 9}, torch::kFloat64);
  torch::Tensor joints = (torch::rand({2, 3}, torch::kFloat64) * 0.4).requires_grad_();
  (contact_map(joints, points) * weights).sum().backward();
  const auto value = [&](const torch::Tensor& at) { return (plain(at, points, 0.2) * weights).sum().item<double>(); };
  torch::NoGradGuard no_gradient;
  for (int64_t i = 0; i < 6; ++i) {
    torch::Tensor up = joints.clone(), down = joints.clone();
    up.view({-1})[i] += 1e-5;
    down.view({-1})[i] -= 1e-5;
    EXPECT_NEAR(joints.grad().view({-1})[i].item<double>(), (value(up) - value(down)) / 2e-5, 1e-6);
  }
  const torch::Tensor touching = torch::zeros({1, 3}).requires_grad_();
  torch::AutoGradMode with_gradient(true);
  contact_map(touching, torch::zeros({1, 3})).sum().backward();
  EXPECT_TRUE(torch::isfinite(touching.grad()).all().item<bool>());
}

TEST(ContactMap, WrongShapesAndEmptyScenes) {
  EXPECT_THROW(contact_map(torch::zeros({3}), torch::zeros({5, 3})), Error);
  EXPECT_THROW(contact_map(torch::zeros({2, 3}), torch::zeros({5, 2})), Error);
  EXPECT_THROW(contact_map(torch::zeros({2, 4, 3}), torch::zeros({3, 5, 3})), Error);
  EXPECT_EQ(contact_map(torch::zeros({2, 3}), torch::zeros({0, 3})).sizes(), (torch::IntArrayRef{2, 0}));
}

}  // namespace
}  // namespace inhabit
