#include "inhabit/scene/distance_field.h"

#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "shapes.h"

namespace inhabit {
namespace {

using Eigen::Vector3d;

Eigen::AlignedBox3d cube(double half) { return {Vector3d::Constant(-half), Vector3d::Constant(half)}; }

std::vector<Vector3d> random_points(int count, double half) {
  torch::manual_seed(4);
  const torch::Tensor p = ((torch::rand({count, 3}, torch::kFloat64) * 2 - 1) * half).contiguous();
  std::vector<Vector3d> out;
  for (int i = 0; i < count; ++i) out.emplace_back(Eigen::Map<const Vector3d>(p.data_ptr<double>() + 3 * i));
  return out;
}

/// Of a sphere the interpolation errs by h^2 / 8 times the curvature of each direction at most, plus the facets' sag.
TEST(DistanceField, ComesNearASpheresDistance) {
  const SceneQuery query(scene_of({sphere_mesh({0, 0, 0}, 0.7, 64)}));
  const DistanceField field(query, cube(1), 0.05);
  for (const Vector3d& p : random_points(2000, 1)) {
    const double expected = p.norm() - 0.7;
    if (p.norm() < 0.2) continue;  // the centre is where the distance has no slope
    Vector3d gradient;
    EXPECT_NEAR(field.distance(p, &gradient), expected, 0.05 * 0.05 / 8 * 3 / 0.2 + 1e-3);
    EXPECT_GT(gradient.normalized().dot(p.normalized()), 0.98);
  }
}

/// What interpolation must be: exact beside a plane, in value and slope.
TEST(DistanceField, IsExactBesideAPlane) {
  const SceneQuery query(scene_of({box_mesh({0, -2, 0}, {20, 4, 20})}));
  const DistanceField field(query, cube(1.5), 0.07);
  for (const Vector3d& p : random_points(500, 1.5)) {
    Vector3d gradient;
    EXPECT_NEAR(field.distance(p, &gradient), p.y(), 1e-5);
    EXPECT_LT((gradient - Vector3d::UnitY()).norm(), 1e-3);
  }
}

TEST(DistanceField, GradientIsThatOfTheDistance) {
  const SceneQuery query(scene_of({box_mesh({0.1, 0.2, 0}, {0.8, 0.5, 0.9})}));
  const DistanceField field(query, cube(1), 0.1);
  constexpr double kStep = 1e-6;
  for (const Vector3d& p : random_points(500, 1.4)) {  // beyond the grid too
    Vector3d gradient, numeric;
    field.distance(p, &gradient);
    for (int i = 0; i < 3; ++i)
      numeric[i] =
          (field.distance(p + kStep * Vector3d::Unit(i)) - field.distance(p - kStep * Vector3d::Unit(i))) / (2 * kStep);
    EXPECT_LT((gradient - numeric).norm(), 1e-4) << p.transpose();
  }
}

/// The promise that lets collisions skip rays: what it says is what the rays say, of closed shapes everywhere, and it
/// says something about nearly every point that is farther from surfaces than a cell.
TEST(DistanceField, WhatIsSaidToBeInsideIs) {
  const SceneQuery query(scene_of({sphere_mesh({0, 0, 0}, 0.6, 24), box_mesh({0.3, -0.3, 0}, {0.7, 0.02, 0.7}),
                                   box_mesh({-0.5, 0.6, 0.1}, {0.3, 0.3, 0.3})}));
  const DistanceField field(query, cube(1), 0.06);
  torch::manual_seed(5);
  const torch::Tensor points = (torch::rand({20000, 3}) * 2 - 1).contiguous(), inside = query.inside(points),
                      distance = query.closest(points).distances;
  int far = 0, told = 0;
  for (int64_t i = 0; i < points.size(0); ++i) {
    const Eigen::Vector3f p = Eigen::Map<const Eigen::Vector3f>(points.data_ptr<float>() + 3 * i);
    const float d = distance.data_ptr<float>()[i];
    const bool in = inside.data_ptr<bool>()[i];
    EXPECT_LE(field.clearance(p), d);
    EXPECT_EQ(field.inside(p).value_or(in), in) << p.transpose();
    EXPECT_EQ(field.inside(p, d).value_or(in), in) << p.transpose();
    if (d < 0.06F * 1.01F) continue;
    far += 1;
    told += field.inside(p).has_value() ? 1 : 0;
  }
  EXPECT_GT(far, 10000);
  EXPECT_EQ(told, far);
}

TEST(DistanceField, SaysNothingAtTheRimOfAnOpenShell) {
  const SceneQuery query(scene_of({box_mesh({0, 0, 0}, {1, 1, 1}, {5})}));
  const DistanceField field(query, cube(0.9), 0.05);
  const torch::Tensor points = (torch::rand({20000, 3}) * 1.8 - 0.9).contiguous(), inside = query.inside(points);
  int wrong = 0;
  for (int64_t i = 0; i < points.size(0); ++i) {
    const auto said = field.inside(Eigen::Map<const Eigen::Vector3f>(points.data_ptr<float>() + 3 * i));
    wrong += said && *said != inside.data_ptr<bool>()[i] ? 1 : 0;
  }
  EXPECT_LT(wrong, 40);  // two in a thousand: where the rim bends through one cell
}

/// Bricks are sampled by whoever needs them first: the answers must not depend on who does.
TEST(DistanceField, AnswersManyThreadsAlike) {
  const SceneQuery query(scene_of({sphere_mesh({0, 0, 0}, 0.7, 16)}));
  const DistanceField one(query, cube(1), 0.05), many(query, cube(1), 0.05);
  const std::vector<Vector3d> points = random_points(4000, 1);
  std::vector<double> got(points.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(4)
  for (size_t i = 0; i < points.size(); ++i) got[i] = many.distance(points[i]);
  for (size_t i = 0; i < points.size(); ++i) EXPECT_EQ(got[i], one.distance(points[i]));
}

TEST(DistanceField, SampledBeforehandAnswersTheSame) {
  const SceneQuery query(scene_of({sphere_mesh({0, 0, 0}, 0.7, 16)}));
  const DistanceField later(query, cube(1), 0.05), before(query, cube(1), 0.05);
  int asked = 0;
  before.sample(cube(0.3), [&] {
    ++asked;
    return false;
  });
  EXPECT_EQ(asked, 27) << "three bricks of 0.4 m in each direction";
  asked = 0;
  before.sample(cube(5), [&] { return ++asked == 4; });
  EXPECT_EQ(asked, 4) << "left off where it was told to";
  before.sample(cube(5));
  before.sample({});
  for (const Vector3d& point : random_points(1000, 1.2)) EXPECT_EQ(before.distance(point), later.distance(point));
}

TEST(DistanceField, RefusesWhatIsNoGrid) {
  const SceneQuery query(scene_of({box_mesh({0, 0, 0}, {1, 1, 1})}));
  EXPECT_THROW(DistanceField(query, cube(1), 0), Error);
  EXPECT_THROW(DistanceField(query, cube(1), NAN), Error);
  EXPECT_THROW(DistanceField(query, Eigen::AlignedBox3d(), 0.1), Error);
  EXPECT_THROW(DistanceField(query, cube(1000), 0.05), Error);
  EXPECT_THROW(DistanceField(query, cube(1)).distance(Vector3d::Constant(NAN)), Error);
  // Beyond the grid nothing is certain.
  EXPECT_FALSE(DistanceField(query, cube(1)).inside({5, 0, 0}).has_value());
  EXPECT_EQ(DistanceField(query, cube(1)).clearance({5, 0, 0}), 0);
}

}  // namespace
}  // namespace inhabit
