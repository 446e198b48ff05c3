// Protects the built-in body's file: it is what scripts/make_body makes, and damage to it is told.
#include <gtest/gtest.h>

#include "inhabit/body/body_model.h"
#include "inhabit/body/builtin_body_data.h"
#include "refusal_of.h"
#include "skin.h"

namespace inhabit {
namespace {

using torch::Tensor;

TEST(MakeBody, MakesTheFileThatShips) {
  const BuiltinSkin file = builtin_skin_from(builtin_body_file());
  const TriangleSurface made = builtin_skin();
  // Another processor may round otherwise and collapse another edge: the surface is the same, not each number.
  ASSERT_NEAR(static_cast<double>(made.vertices.size()), static_cast<double>(file.vertices.size(0)), 40);
  Tensor vertices = torch::empty({static_cast<int64_t>(made.vertices.size()), 3});
  for (size_t v = 0; v < made.vertices.size(); ++v)
    Eigen::Map<Eigen::Vector3f>(vertices.data_ptr<float>() + 3 * v) = made.vertices[v].cast<float>();
  const auto [apart, nearest] = torch::cdist(vertices, file.vertices).min(1);
  EXPECT_LT(apart.mean().item<double>(), 0.001);
  const Tensor weights = builtin_skin_weights(made),
               difference = (weights - file.weights.index_select(0, nearest)).abs();
  EXPECT_LT(difference.mean().item<double>(), 0.002);
  const Tensor moves = builtin_shape_directions(made, weights);
  EXPECT_LT((moves - file.shape_dirs.index_select(0, nearest)).abs().mean().item<double>(), 1e-4);
}

TEST(MakeBody, BytesComeBackAsTheyWere) {
  const std::string bytes(builtin_body_file());
  EXPECT_EQ(builtin_skin_bytes(builtin_skin_from(bytes)), bytes);
  EXPECT_EQ(refusal_of([&] { builtin_skin_from(bytes.substr(0, bytes.size() - 1)); }),
            "the built-in body: is cut short");
  EXPECT_EQ(refusal_of([&] { builtin_skin_from(bytes + "x"); }), "the built-in body: goes on behind its end");
  EXPECT_NE(refusal_of([&] { builtin_skin_from(std::string(8, '\xff')); }), "");
}

}  // namespace
}  // namespace inhabit
