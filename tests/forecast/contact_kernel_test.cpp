// Protects the fused contact features: the DCT coefficients of the contact map of Eq. 2, at every level of vector
// instructions.
#include "inhabit/forecast/contact_kernel.h"

#include <torch/torch.h>

#include "inhabit/math/dct.h"
#include "inhabit/scene/contact_map.h"
#include "simd_levels.h"

namespace inhabit::forecast {
namespace {

using torch::Tensor;

struct Given {
  static constexpr int64_t kPoints = 300, kFrames = 20, kCoefficients = 7;
  Tensor points, path, basis, by_axis;
  std::array<const float*, 3> axes{};

  Given() {
    torch::manual_seed(7);
    points = torch::rand({kPoints, 3}) * 4 - 2;
    path = torch::linspace(-1, 1, kFrames).unsqueeze(1) * torch::tensor({0.6F, 0.1F, -0.4F});
    basis = dct_matrix(kFrames, kCoefficients).contiguous();
    by_axis = points.t().contiguous();
    for (size_t a = 0; a < 3; ++a) axes[a] = by_axis.data_ptr<float>() + static_cast<int64_t>(a) * kPoints;
  }
  Tensor coefficients() const {
    Tensor out = torch::zeros({kCoefficients, kPoints});
    contact_coefficients_of_joint(axes.data(), kPoints, path.data_ptr<float>(), kFrames, basis.data_ptr<float>(),
                                  kCoefficients, 0.2F, out.data_ptr<float>(), kPoints);
    return out;
  }
};

TEST(ContactKernel, CoefficientsAreThoseOfTheContactMap) {
  const Given g;
  const Tensor expected = g.basis.mm(contact_map(g.path, g.points, 0.2));
  EXPECT_LT(largest(g.coefficients() - expected), 1e-5);
  EXPECT_GT(largest(expected), 0.1);
}

// With the identity as basis the coefficients are the contacts themselves. Far from the origin, where few digits are
// left for distances between joints and points, as near it.
TEST(ContactKernel, ContactsEqualThePlainOnesInScenesOfAnySize) {
  torch::manual_seed(1);
  constexpr int64_t kJoints = 4, kFrames = 5, kPoints = 777;
  const Tensor identity = torch::eye(kFrames);
  for (const double spread : {0.5, 5.0, 500.0}) {
    for (const double sigma : {0.05, 0.2, 1.0}) {
      const Tensor points = (torch::rand({kPoints, 3}) - 0.5) * spread, by_axis = points.t().contiguous();
      const Tensor joints = (torch::rand({kJoints, kFrames, 3}) - 0.5) * spread * 1.5;
      joints[0][0] = points[3];
      const float* axes[3];
      for (int64_t a = 0; a < 3; ++a) axes[a] = by_axis.data_ptr<float>() + a * kPoints;
      for (int64_t j = 0; j < kJoints; ++j) {
        Tensor found = torch::full({kFrames, kPoints}, 7.F);
        contact_coefficients_of_joint(axes, kPoints, joints[j].data_ptr<float>(), kFrames, identity.data_ptr<float>(),
                                      kFrames, static_cast<float>(sigma), found.data_ptr<float>(), kPoints);
        const Tensor apart = joints[j].to(torch::kFloat64).unsqueeze(1) - points.to(torch::kFloat64);
        const Tensor plain = torch::exp(-0.5 * apart.square().sum(-1) / (sigma * sigma));
        EXPECT_LT((found - plain).abs().max().item<double>(), 1.1e-6) << spread << ' ' << sigma << ' ' << j;
        if (j == 0) {
          EXPECT_NEAR(found[0][3].item<double>(), 1, 1.1e-6);
        }
      }
    }
  }
}

TEST(ContactKernel, LevelsAgree) {
  const Given g;
  expect_same_at_all_levels([&] { return g.coefficients(); }, 2e-6, "coefficients");
  const Tensor c = g.coefficients(), back = g.basis.t().contiguous();
  expect_same_at_all_levels(
      [&] {
        Tensor value = torch::zeros({Given::kFrames}), index = torch::zeros({Given::kFrames}, torch::kInt64);
        largest_contact_of_joint(c.data_ptr<float>(), Given::kPoints, Given::kPoints, back.data_ptr<float>(),
                                 Given::kCoefficients, Given::kFrames, -1, value.data_ptr<float>(),
                                 index.data_ptr<int64_t>());
        return index;
      },
      0, "largest contact");
  expect_same_at_all_levels(
      [&] {
        Tensor squared = torch::zeros({Given::kFrames}), index = torch::zeros({Given::kFrames}, torch::kInt64);
        closest_point_of_joint(g.axes.data(), Given::kPoints, g.path.data_ptr<float>(), Given::kFrames,
                               squared.data_ptr<float>(), index.data_ptr<int64_t>());
        return index;
      },
      0, "closest point");
}

TEST(ContactKernel, PointsThatCannotBeOverTheLeastAreLeftOutAndNoOthers) {
  const Given g;
  const Tensor c = g.coefficients(), back = g.basis.t().contiguous();
  const auto largest = [&](float least) {
    std::pair out{torch::zeros({Given::kFrames}), torch::zeros({Given::kFrames}, torch::kInt64)};
    largest_contact_of_joint(c.data_ptr<float>(), Given::kPoints, Given::kPoints, back.data_ptr<float>(),
                             Given::kCoefficients, Given::kFrames, least, out.first.data_ptr<float>(),
                             out.second.data_ptr<int64_t>());
    return out;
  };
  const auto [all, point] = largest(-1);
  const double middle = all.median().item<double>();
  int64_t over = 0;
  for (const double least : {0.1 * middle, middle, 0.99 * all.max().item<double>(), 2 * all.max().item<double>()}) {
    const auto [value, found] = largest(static_cast<float>(least));
    const Tensor counts = all > least;
    EXPECT_TRUE(torch::equal(value > least, counts)) << least;
    EXPECT_TRUE(torch::equal(value.masked_select(counts), all.masked_select(counts))) << least;
    EXPECT_TRUE(torch::equal(found.masked_select(counts), point.masked_select(counts))) << least;
    over += counts.sum().item<int64_t>();
  }
  EXPECT_GT(over, Given::kFrames);
}

}  // namespace
}  // namespace inhabit::forecast
