// Protects skinning's copies for wider vectors: whoever touches something touches it on every processor.
#include "inhabit/body/skin_kernel.h"

#include "inhabit/body/kinematics.h"
#include "inhabit/math/rotation.h"
#include "simd_levels.h"

namespace inhabit {
namespace {

TEST(SkinKernel, GivesTheSameBitsAtAllLevels) {
  torch::manual_seed(5);
  const BodyModel& body = builtin_body();
  const torch::Tensor rotations = axis_angle_to_matrix(torch::randn({7, 22, 3})), trans = torch::randn({7, 3});
  expect_same_at_all_levels([&] { return skin(body, {}, rotations, trans); }, 0, "a skin");
}

/// One vertex, and the last of several: nothing is written behind a skin.
TEST(SkinKernel, WritesItsVerticesAlone) {
  const std::vector<SkinTransform> transforms = {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {10, 20, 30}}},  // moves
                                                 {{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 0, 0}}}};    // swaps x and y
  const std::vector<float> rest = {1, 2, 3, 4, 5, 6};
  for (const size_t vertices : {1, 2}) {
    const SparseWeights weights =
        vertices == 1 ? SparseWeights{{0, 1}, {0}, {1}} : SparseWeights{{0, 1, 3}, {0, 0, 1}, {1, 0.5F, 0.5F}};
    const auto skinned = [&] {
      torch::Tensor out = torch::full({static_cast<int64_t>(3 * vertices) + 1}, -7.F);
      skin_vertices(weights, transforms.data(), rest.data(), out.data_ptr<float>());
      return out;
    };
    std::vector<float> expected = {11, 22, 33, 9.5F, 14.5F, 21};
    expected.resize(3 * vertices);
    expected.push_back(-7);
    EXPECT_TRUE(torch::equal(skinned(), torch::tensor(expected))) << skinned();
    expect_same_at_all_levels(skinned, 0, std::to_string(vertices) + " vertices");
  }
}

}  // namespace
}  // namespace inhabit
