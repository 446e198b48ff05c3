#include "inhabit/body/capsules.h"

#include <gtest/gtest.h>

#include "inhabit/body/proportions.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;

TEST(Capsules, CoverTheBodyWithoutSwellingOverIt) {
  const BodyModel& body = builtin_body();
  const Bones bones = bones_of(body.skeleton);
  BonesPose pose;
  pose_bones(bones, std::vector<Eigen::Quaterniond>(22, Eigen::Quaterniond::Identity()), Vector3d::Zero(), pose);
  std::vector<WorldCapsule> capsules;
  place_capsules(body.capsules, pose, capsules);
  auto v = body.template_vertices.accessor<float, 2>();
  double furthest_out = 0, deepest = 0, mean = 0;
  for (int64_t i = 0; i < body.template_vertices.size(0); ++i) {
    const Vector3d p(v[i][0], v[i][1], v[i][2]);
    double nearest = 1e9;
    for (const WorldCapsule& c : capsules) nearest = std::min(nearest, capsule_distance(c, {0, p, p, 0.0}));
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

TEST(Capsules, DistancesHaveTheClosedForm) {
  const WorldCapsule upright{0, {0, 0, 0}, {0, 1, 0}, 0.1}, across{0, {-1, 0.5, 0.5}, {1, 0.5, 0.5}, 0.1};
  EXPECT_NEAR(capsule_distance(upright, across), 0.3, 1e-12);
  EXPECT_NEAR(capsule_distance(upright, {0, {0, 2, 0}, {0, 2, 0}, 0.2}), 0.7, 1e-12);
  EXPECT_NEAR(capsule_distance(upright, {0, {0.3, -1, 0}, {0.3, 3, 0}, 0.1}), 0.1, 1e-12);
}

}  // namespace
}  // namespace inhabit
