#include <gtest/gtest.h>

#include <map>
#include <set>

#include "inhabit/body/body_model.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/body/proportions.h"
#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "largest.h"

namespace inhabit {
namespace {

using torch::Tensor;

double volume(const Tensor& vertices, const Tensor& faces) {
  const Tensor a = vertices.index_select(0, faces.select(1, 0)), b = vertices.index_select(0, faces.select(1, 1)),
               c = vertices.index_select(0, faces.select(1, 2));
  return ((a * torch::cross(b, c, 1)).sum() / 6).item<double>();
}

Tensor rest_skin(const Tensor& betas) {
  const Tensor rotations = torch::eye(3).expand({22, 3, 3}).contiguous();
  return skin(builtin_body(), betas, rotations, torch::zeros({3}));
}

TEST(BuiltinBody, SkinIsOneClosedSurface) {
  const BodyModel& body = builtin_body();
  const int64_t vertices = body.template_vertices.size(0), faces = body.faces.size(0);
  EXPECT_GE(vertices, 1500);
  EXPECT_LE(vertices, 5000);
  std::map<std::pair<int64_t, int64_t>, int> edges;
  std::set<int64_t> used;
  auto f = body.faces.accessor<int64_t, 2>();
  for (int64_t t = 0; t < faces; ++t)
    for (int i = 0; i < 3; ++i) {
      ++edges[{f[t][i], f[t][(i + 1) % 3]}];
      used.insert(f[t][i]);
    }
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);                                    // once in this direction,
    ASSERT_EQ(edges.count({edge.second, edge.first}), 1U);  // once in the other
  }
  EXPECT_EQ(static_cast<int64_t>(used.size()), vertices);
  EXPECT_EQ(vertices - static_cast<int64_t>(edges.size()) / 2 + faces, 2);  // one sphere
  const double v = volume(body.template_vertices, body.faces);
  EXPECT_GT(v, 0.055);  // 1.72 m and about a kilogram a litre
  EXPECT_LT(v, 0.075);
}

TEST(BuiltinBody, SkinIsMirrorSymmetric) {
  const Tensor v = builtin_body().template_vertices;
  const Tensor mirrored = v * torch::tensor({-1.0F, 1.0F, 1.0F});
  EXPECT_LT(torch::cdist(mirrored, v).amin(1).max().item<double>(), 1e-3);
}

TEST(BuiltinBody, StandsAsTallAsItSays) {
  const BodyModel& body = builtin_body();
  const Tensor y = body.template_vertices.select(1, 1);
  EXPECT_NEAR(y.min().item<double>(), -kBuiltinPelvisHeight, 0.004);
  EXPECT_NEAR((y.max() - y.min()).item<double>(), kBuiltinStature, 0.01);
  // Every joint lies inside its flesh: the trunk around the spine, the foot around the ball.
  const Tensor near = torch::cdist(body.joint_template, body.template_vertices).amin(1);
  EXPECT_GT(near.min().item<double>(), 0.012);
}

TEST(BuiltinBody, WeightsAreFewSmoothAndSumToOne) {
  const BodyModel& body = builtin_body();
  EXPECT_LT(largest(body.skin_weights.sum(1) - 1), 1e-5);
  EXPECT_GE(body.skin_weights.min().item<double>(), 0);
  EXPECT_LE((body.skin_weights > 0).sum(1).max().item<int64_t>(), 4);
  for (int j = 0; j < kStandardJoints; ++j)
    EXPECT_GT(body.skin_weights.select(1, j).max().item<double>(), 0.5) << standard_joint_names()[j];
  const Tensor a = body.faces.select(1, 0), b = body.faces.select(1, 1);
  const Tensor difference = (body.skin_weights.index_select(0, a) - body.skin_weights.index_select(0, b)).abs();
  EXPECT_LT(difference.max().item<double>(), 0.75);
}

TEST(BuiltinBody, ShapeParametersChangeWhatTheySay) {
  const BodyModel& body = builtin_body();
  ASSERT_EQ(body.betas(), kBuiltinBetas);
  const auto with = [&](int beta, float value) {
    Tensor b = torch::zeros({kBuiltinBetas});
    b[beta] = value;
    return b;
  };
  const auto bone = [&](const Tensor& betas, int j) {
    return shaped_skeleton(body, betas).offsets[j].norm().item<double>();
  };
  const auto height = [&](const Tensor& betas) {
    const Tensor y = rest_skin(betas).select(1, 1);
    return (y.max() - y.min()).item<double>();
  };
  const Tensor mean = torch::zeros({kBuiltinBetas});
  EXPECT_NEAR(height(with(kStature, 2)) / height(mean), 1.08, 1e-3);
  EXPECT_NEAR(bone(with(kLegs, 2), 4) / bone(mean, 4), 1.08, 1e-4);
  EXPECT_NEAR(bone(with(kArms, -2), 18) / bone(mean, 18), 0.92, 1e-4);
  EXPECT_NEAR(bone(with(kTorso, 1), 6) / bone(mean, 6), 1.04, 1e-4);
  EXPECT_NEAR(bone(with(kHips, 1), 4), bone(mean, 4), 1e-6);
  EXPECT_GT(bone(with(kShoulders, 2), 16), bone(mean, 16) * 1.05);
  EXPECT_LT(largest(shaped_skeleton(body, with(kGirth, 3)).offsets - body.skeleton.offsets), 1e-7);
  EXPECT_GT(volume(rest_skin(with(kGirth, 2)), body.faces), 1.2 * volume(rest_skin(mean), body.faces));
  EXPECT_GT(volume(rest_skin(with(kBelly, 2)), body.faces), 1.02 * volume(rest_skin(mean), body.faces));
  EXPECT_THROW(shaped_skeleton(body, torch::zeros({kBuiltinBetas + 1})), Error);
  EXPECT_LT(largest(shaped_skeleton(body, {}).offsets - body.skeleton.offsets), 1e-9);
}

TEST(BuiltinBody, ExtremeShapesDoNotTurnInsideOut) {
  const BodyModel& body = builtin_body();
  const auto normals = [&](const Tensor& v) {
    const Tensor a = v.index_select(0, body.faces.select(1, 0)), b = v.index_select(0, body.faces.select(1, 1)),
                 c = v.index_select(0, body.faces.select(1, 2));
    return torch::cross(b - a, c - a, 1);
  };
  const Tensor mean = normals(body.template_vertices);
  for (int beta = 0; beta < kBuiltinBetas; ++beta)
    for (float value : {-3.0F, 3.0F}) {
      Tensor b = torch::zeros({kBuiltinBetas});
      b[beta] = value;
      const Tensor shaped = normals(rest_skin(b));
      const Tensor turned = (shaped * mean).sum(1) <= 0;
      EXPECT_EQ(turned.sum().item<int64_t>(), 0) << beta << " " << value;
    }
}

TEST(BuiltinBody, AnchorsAreSpreadOverTheSkin) {
  const BodyModel& body = builtin_body();
  ASSERT_EQ(body.anchors.sizes(), torch::IntArrayRef({64}));
  const Tensor points = body.template_vertices.index_select(0, body.anchors);
  const Tensor apart = torch::cdist(points, points) + torch::eye(64) * 10;
  const double nearest = apart.min().item<double>();
  EXPECT_GT(nearest, 0.05);
  // No vertex is further from the anchors than the anchors are from each other.
  EXPECT_LE(torch::cdist(body.template_vertices, points).amin(1).max().item<double>(), nearest + 1e-6);
}

TEST(BuiltinBody, LimitsAreOrderedSymmetricAndHoldTheRestPose) {
  const Tensor limits = builtin_body().joint_limits;
  EXPECT_TRUE((limits.select(2, 0) <= 0).all().item<bool>());
  EXPECT_TRUE((limits.select(2, 1) >= 0).all().item<bool>());
  for (int left : {1, 4, 7, 10, 13, 16, 18, 20}) {
    EXPECT_FLOAT_EQ(limits[left][1][0].item<float>(), -limits[left + 1][1][1].item<float>());
    EXPECT_FLOAT_EQ(limits[left][0][0].item<float>(), limits[left + 1][0][0].item<float>());
  }
}

TEST(Skinning, RestPoseIsTheTemplateAndRotationsAreRigid) {
  const BodyModel& body = builtin_body();
  EXPECT_LT(largest(rest_skin({}) - body.template_vertices), 1e-6);
  Tensor rotations = torch::zeros({1, 22, 3});
  rotations[0][0] = torch::tensor({0.3F, -1.0F, 0.4F});
  const Tensor r = axis_angle_to_matrix(rotations);
  const Tensor moved = skin(body, {}, r, torch::tensor({{1.0F, 2.0F, 3.0F}}));
  const Tensor expected = body.template_vertices.matmul(r[0][0].t()) + torch::tensor({1.0F, 2.0F, 3.0F});
  EXPECT_LT(largest(moved[0] - expected), 1e-5);
}

TEST(Skinning, FastAndDifferentiablePathsAgree) {
  torch::manual_seed(4);
  BodyModel body = builtin_body();
  const Tensor rotations = axis_angle_to_matrix(torch::randn({2, 3, 22, 3}) * 0.5), trans = torch::randn({2, 3, 3});
  const Tensor betas = torch::randn({5});
  for (bool pose_dirs : {false, true}) {
    if (pose_dirs) body.pose_dirs = torch::randn({body.template_vertices.size(0), 3, 9 * 21}) * 1e-3;
    const Tensor fast = skin(body, betas, rotations, trans);
    const Tensor tracked = skin(body, betas.clone().requires_grad_(true), rotations, trans);
    EXPECT_TRUE(tracked.requires_grad());
    EXPECT_EQ(fast.sizes(), torch::IntArrayRef({2, 3, body.template_vertices.size(0), 3}));
    EXPECT_LT(largest(fast - tracked), 2e-5);
  }
  EXPECT_EQ(skin(body, betas, rotations[0].slice(0, 0, 0), trans[0].slice(0, 0, 0)).size(0), 0);
}

TEST(Skinning, GradientsAgreeWithDifferences) {
  torch::manual_seed(6);
  BodyModel body = builtin_body();
  body.pose_dirs = torch::randn({body.template_vertices.size(0), 3, 9 * 21}) * 1e-2;
  const Tensor weights = torch::randn({body.template_vertices.size(0), 3}, torch::kDouble);
  const auto f = [&](const std::vector<Tensor>& x) {
    return (skin(body, x[0], axis_angle_to_matrix(x[1]), x[2]) * weights).sum();
  };
  for (double size : {0.0, 0.6}) {
    const std::vector<Tensor> x = {torch::randn({kBuiltinBetas}, torch::kDouble),
                                   torch::randn({22, 3}, torch::kDouble) * size, torch::randn({3}, torch::kDouble)};
    std::vector<Tensor> in;
    for (const Tensor& t : x) in.push_back(t.clone().requires_grad_(true));
    f(in).backward();
    for (size_t which = 0; which < x.size(); ++which)
      for (int64_t i = 0; i < x[which].numel(); i += which == 1 ? 5 : 1) {
        std::vector<Tensor> plus, minus;
        for (const Tensor& t : x) {
          plus.push_back(t.clone());
          minus.push_back(t.clone());
        }
        plus[which].view(-1)[i] += 1e-5;
        minus[which].view(-1)[i] -= 1e-5;
        const double numeric = (f(plus) - f(minus)).item<double>() / 2e-5;
        EXPECT_NEAR(in[which].grad().view(-1)[i].item<double>(), numeric, 1e-5 * (1 + std::abs(numeric)))
            << which << " " << i;
      }
  }
}

}  // namespace
}  // namespace inhabit
