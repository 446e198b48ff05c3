#include "inhabit/body/capsules.h"

#include <gtest/gtest.h>

#include "inhabit/body/proportions.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;

TEST(Capsules, CoverTheBodyWithoutSwellingOverIt) {
  const BodyModel& body = builtin_body();
  const torch::Tensor rest = body.skeleton.rest_joints();
  auto v = body.template_vertices.accessor<float, 2>();
  double furthest_out = 0, deepest = 0, mean = 0;
  for (int64_t i = 0; i < body.template_vertices.size(0); ++i) {
    const Vector3d p(v[i][0], v[i][1], v[i][2]);
    double nearest = 1e9;
    for (const Capsule& c : body.capsules) {
      const Vector3d joint(rest[c.joint][0].item<double>(), rest[c.joint][1].item<double>(),
                           rest[c.joint][2].item<double>()),
          a = joint + Vector3d(c.a[0], c.a[1], c.a[2]), along = joint + Vector3d(c.b[0], c.b[1], c.b[2]) - a;
      const double u = std::clamp((p - a).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
      nearest = std::min(nearest, (a + u * along - p).norm() - c.radius);
    }
    furthest_out = std::max(furthest_out, nearest);
    deepest = std::max(deepest, -nearest);
    mean += nearest / static_cast<double>(body.template_vertices.size(0));
  }
  EXPECT_LT(furthest_out, 0.06);  // skin outside every capsule
  EXPECT_LT(deepest, 0.05);       // capsule outside the skin
  EXPECT_LT(std::abs(mean), 0.012);
}

TEST(Capsules, GrowWithTheShape) {
  const BodyModel& body = builtin_body();
  torch::Tensor betas = torch::zeros({kBuiltinBetas});
  betas[kStature] = 2;
  const std::vector<Capsule> taller = shaped_capsules(body, betas);
  for (size_t i = 0; i < taller.size(); ++i) EXPECT_NEAR(taller[i].radius / body.capsules[i].radius, 1.08, 0.005);
  EXPECT_EQ(shaped_capsules(body, {}).size(), body.capsules.size());
}

}  // namespace
}  // namespace inhabit
