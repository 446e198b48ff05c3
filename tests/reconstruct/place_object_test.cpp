// Protects the room: an object's scale, rotation and place from what a camera sees of it, whatever unit its mesh is in;
// the floor's height; points that were seen through.
#include "inhabit/reconstruct/place_object.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/reconstruct/scene_points.h"
#include "inhabit/scene/point_rows.h"
#include "inhabit/scene/query.h"
#include "refusal_of.h"
#include "scene/shapes.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

/// A chair of boxes in its own unit, its seat in the middle: the back makes it look different from every side.
std::vector<Mesh> chair() {
  return {box_mesh({0, 0, 0}, {2, 0.3, 1.8}), box_mesh({0, 1.1, -0.8}, {2, 2, 0.2}),
          box_mesh({0.85, -0.7, 0}, {0.2, 1.2, 1.6}), box_mesh({-0.85, -0.7, 0.6}, {0.2, 1.2, 0.4})};
}

Camera looking_down() {
  Camera out;
  out.width = 160, out.height = 120;
  out.fx = out.fy = 150, out.cx = 79.5, out.cy = 59.5;
  // From 1.6 m up along -Z, a quarter of a right angle down.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() =
      (Eigen::AngleAxisd(M_PI / 8, -Vector3d::UnitX()) * Eigen::AngleAxisd(M_PI, Vector3d::UnitX())).toRotationMatrix();
  pose.translation() = Vector3d(0, 1.6, 0);
  out.to_world = {pose};
  return out;
}

/// What the camera sees of a scene: depth 0 where there is nothing.
View view_of(const Scene& scene, const Camera& camera) {
  std::vector<Vector3d> rays;
  for (int64_t row = 0; row < camera.height; ++row)
    for (int64_t column = 0; column < camera.width; ++column)
      rays.emplace_back(camera.to_world[0].linear() *
                        camera.ray(static_cast<double>(column), static_cast<double>(row)));
  const Tensor directions = point_rows(rays),
               from = point_rows({camera.to_world[0].translation()}).expand_as(directions);
  const RayHits hits = SceneQuery(scene).cast(from, directions);
  View out;
  const Tensor depth = hits.distances / directions.norm(2, {1});
  out.depth = torch::where(hits.hit, depth, torch::zeros_like(depth)).view({camera.height, camera.width}).contiguous();
  out.person = torch::zeros({camera.height, camera.width}, torch::kBool);
  return out;
}

PlacedObject placed_again(const Placement& truth, double noise, bool someone_before) {
  const Camera camera = looking_down();
  Scene scene;
  for (Mesh mesh : chair()) {
    auto v = mesh.vertices.accessor<float, 2>();
    for (int64_t i = 0; i < v.size(0); ++i) {
      const Vector3d at = truth.place({v[i][0], v[i][1], v[i][2]});
      for (int c = 0; c < 3; ++c) v[i][c] = static_cast<float>(at[c]);
    }
    scene.meshes.push_back(mesh);
  }
  View view = view_of(scene, camera);
  torch::manual_seed(5);
  view.depth = view.depth * (1 + noise * torch::randn_like(view.depth));
  Tensor mask = view.depth.gt(0);
  if (someone_before) {
    view.person.slice(1, 60, 78) = true;
    mask = mask.logical_and(view.person.logical_not());
    view.depth.slice(1, 60, 78) = 1.2;
  }
  return place_object("chair", chair(), {{&view}, {mask}}, camera, 0);
}

/// Where the meshes' feet are on the floor: they reach 1.3 below their origin.
Placement on_floor(double scale, double yaw, double x, double z) { return {scale, yaw, {x, 1.3 * scale, z}}; }

void expect_near(const Placement& a, const Placement& b, double metres, double degrees, double part) {
  EXPECT_LT((a.shift - b.shift).norm(), metres);
  EXPECT_LT(std::abs(std::remainder(a.yaw - b.yaw, 2 * M_PI)) * 180 / M_PI, degrees);
  EXPECT_LT(std::abs(a.scale / b.scale - 1), part);
}

TEST(PlaceObject, AChairInAnyUnitAndRotationComesBack) {
  for (const double yaw : {0.4, 2.0, -2.5}) {
    const Placement truth = on_floor(0.3, yaw, 0.2, -2.6);
    expect_near(placed_again(truth, 0, false).placement, truth, 0.02, 1.5, 0.03);
  }
}

TEST(PlaceObject, NoiseOrSomebodyBeforeItMovesItLittle) {
  const Placement truth = on_floor(0.3, 0.7, 0, -2.6);
  for (const double noise : {0.0, 0.01}) {
    SCOPED_TRACE(noise);
    expect_near(placed_again(truth, noise, noise == 0).placement, truth, 0.05, 3, 0.04);
  }
}

TEST(PlaceObject, RefusesWhatIsHardlySeenAndWhatHasNoSurface) {
  const Camera camera = looking_down();
  View view;
  view.depth = torch::full({120, 160}, 2.0F), view.person = torch::zeros({120, 160}, torch::kBool);
  Tensor mask = torch::zeros({120, 160}, torch::kBool);
  const auto refusal = [&](const std::vector<Mesh>& meshes) {
    return refusal_of([&] { place_object("stool", meshes, {{&view}, {mask}}, camera, 0); });
  };
  EXPECT_THAT(refusal(chair()), ::testing::HasSubstr("only 0 points"));
  mask.slice(0, 20, 80).slice(1, 20, 80) = true;
  EXPECT_THAT(refusal({}), ::testing::HasSubstr("no faces"));
  Mesh point = box_mesh({0, 0, 0}, {0, 0, 0});
  EXPECT_THAT(refusal({point}), ::testing::HasSubstr("stool"));
}

TEST(ScenePoints, TheFullestLayerIsTheFloor) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 400; ++i) points.emplace_back(0.01 * i, 0.07 + 0.002 * (i % 5 - 2), 0.01 * (i % 37));
  for (int i = 0; i < 150; ++i) points.emplace_back(0.01 * i, -0.1 + 0.002 * i, 1);  // a wall
  EXPECT_NEAR(floor_height(points, 0, 0.3), 0.07, 0.005);
  points.resize(40);
  EXPECT_EQ(floor_height(points, 0.2, 0.3), 0.2);  // too few
}

TEST(ScenePoints, WhatIsSeenThroughGoes) {
  const Camera camera = looking_down();
  View a, b;
  a.depth = b.depth = torch::full({120, 160}, 4.0F);
  a.person = b.person = torch::zeros({120, 160}, torch::kBool);
  const auto at = [&](double depth) { return Vector3d(camera.to_world[0] * (depth * camera.ray(70, 50))); };
  const std::vector<Vector3d> kept = without_seen_through({at(2), at(4), at(4.1)}, {a, b}, camera, 0.06);
  ASSERT_EQ(kept.size(), 2U);
  EXPECT_NEAR((kept[0] - at(4)).norm(), 0, 1e-12);
}

TEST(ScenePoints, GrowBeyondNoMeasure) {
  Camera camera = looking_down();
  View view;
  view.depth = torch::full({120, 160}, 1e12F);
  PointGrid grid(0.03);
  EXPECT_THAT(refusal_of([&] {
                grid.add(view, torch::ones({120, 160}, torch::kBool), camera, "maps");
              }),
              ::testing::HasSubstr("beyond all measure"));
}

}  // namespace
}  // namespace inhabit::reconstruct
