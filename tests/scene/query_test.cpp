#include "inhabit/scene/query.h"

#include <gtest/gtest.h>

#include "inhabit/error.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/scene/basis_points.h"
#include "inhabit/scene/sampling.h"
#include "inhabit/scene/surface_place.h"
#include "inhabit/scene/triangle.h"
#include "shapes.h"
#include "shared.h"

namespace inhabit {
namespace {

torch::Tensor rows(const std::vector<float>& values) { return torch::tensor(values).view({-1, 3}); }

/// Distance to an axis-aligned box, negative inside.
torch::Tensor box_distance(const torch::Tensor& points, const torch::Tensor& center, const torch::Tensor& size) {
  const torch::Tensor q = (points - center).abs() - size / 2;
  return q.clamp_min(0).norm(2, 1) + std::get<0>(q.max(1)).clamp_max(0);
}

TEST(SceneQuery, SignedDistanceOfABox) {
  const SceneQuery query(scene_of({box_mesh({1, 2, 3}, {1, 0.5, 2})}));
  torch::manual_seed(1);
  const torch::Tensor center = torch::tensor({1.F, 2.F, 3.F});
  const torch::Tensor points = center + (torch::rand({2000, 3}) - 0.5) * 3;
  EXPECT_TRUE(torch::allclose(query.signed_distance(points),
                              box_distance(points, center, torch::tensor({1.F, 0.5F, 2.F})), 0, 2e-6));
}

// Inside or out, the place is on the box's surface, and its face's normal looks outwards.
TEST(SceneQuery, NearestPlacesOnABox) {
  const SceneQuery query(scene_of({box_mesh({1, 2, 3}, {1, 0.5, 2})}));
  const std::vector<SurfacePlace> at = nearest_places(query, {{1.1, 2.6, 3.2}, {1.4, 2, 3}, {2.5, 2, 4}});
  ASSERT_EQ(at.size(), 3U);
  EXPECT_TRUE(at[0].place.isApprox(Eigen::Vector3d(1.1, 2.25, 3.2), 1e-6));
  EXPECT_TRUE(at[0].normal.isApprox(Eigen::Vector3d::UnitY(), 1e-6));
  EXPECT_NEAR(at[0].distance, 0.35, 1e-6);
  EXPECT_TRUE(at[1].place.isApprox(Eigen::Vector3d(1.5, 2, 3), 1e-6));
  EXPECT_TRUE(at[1].normal.isApprox(Eigen::Vector3d::UnitX(), 1e-6));
  EXPECT_NEAR(at[1].distance, 0.1, 1e-6);
  EXPECT_NEAR(at[2].distance, 1, 1e-6);
  EXPECT_TRUE(nearest_places(query, {}).empty());
}

TEST(SceneQuery, SignedDistanceOfASphere) {
  const SceneQuery query(scene_of({sphere_mesh({0, 1, 0}, 0.7, 64)}));
  torch::manual_seed(2);
  const torch::Tensor points = (torch::rand({2000, 3}) - 0.5) * 3;
  const torch::Tensor expected = (points - torch::tensor({0.F, 1.F, 0.F})).norm(2, 1) - 0.7;
  // Facets lie up to 0.7 (1 - cos(pi / 64)) = 0.9 mm below the sphere.
  EXPECT_LT((query.signed_distance(points) - expected).abs().max().item<float>(), 1e-3F);
}

TEST(SceneQuery, ClosestNamesTheMeshTheFaceAndItsNormal) {
  const SceneQuery query(scene_of({floor_scene(4).meshes[0], box_mesh({0, 0.5, 0}, {1, 1, 1})}));
  const ClosestPoints closest = query.closest(rows({1.5F, 0.2F, 1.5F, 0.1F, 1.3F, 0.2F}));
  EXPECT_TRUE(torch::allclose(closest.points, rows({1.5F, 0.F, 1.5F, 0.1F, 1.F, 0.2F})));
  EXPECT_TRUE(torch::allclose(closest.distances, torch::tensor({0.2F, 0.3F})));
  EXPECT_TRUE(torch::allclose(closest.normals, rows({0, 1, 0, 0, 1, 0})));
  EXPECT_TRUE(torch::equal(closest.mesh, torch::tensor({0, 1}, torch::kInt64)));
  EXPECT_GE(closest.face[1].item<int64_t>(), 6);  // the side +y is the fourth of two triangles each
  EXPECT_LE(closest.face[1].item<int64_t>(), 7);
}

TEST(SceneQuery, ClosestEqualsBruteForce) {
  Mesh soup;
  torch::manual_seed(3);
  soup.vertices = (torch::rand({300, 1, 3}) * 4 + torch::rand({300, 3, 3})).view({-1, 3});
  soup.faces = torch::arange(900).view({-1, 3});
  const torch::Tensor points = torch::rand({500, 3}) * 6 - 1;
  const SceneQuery query(scene_of({soup}));
  const ClosestPoints closest = query.closest(points);
  const auto v = soup.vertices.accessor<float, 2>();
  const auto p = points.accessor<float, 2>();
  const auto vertex = [&](int64_t i) { return Eigen::Vector3d(v[i][0], v[i][1], v[i][2]); };
  for (int64_t i = 0; i < points.size(0); ++i) {
    const Eigen::Vector3d at(p[i][0], p[i][1], p[i][2]);
    double best = HUGE_VAL;
    for (int64_t f = 0; f < 300; ++f) {
      best = std::min(
          best, (closest_on_triangle<double>(at, vertex(3 * f), vertex(3 * f + 1), vertex(3 * f + 2)) - at).norm());
    }
    EXPECT_NEAR(closest.distances[i].item<double>(), best, 1e-5);
  }
}

bool inside(const Scene& scene, float x, float y, float z) {
  return SceneQuery(scene).inside(rows({x, y, z})).item<bool>();
}

TEST(Inside, BoxWithoutALid) {
  const Scene open = scene_of({box_mesh({0, 0, 0}, {1, 1, 1}, {3})});
  EXPECT_TRUE(inside(open, 0, 0, 0));
  EXPECT_TRUE(inside(open, 0.3F, -0.4F, 0.2F));
  EXPECT_FALSE(inside(open, 0, 0.6F, 0));
  EXPECT_FALSE(inside(open, 0, -0.6F, 0));
  EXPECT_FALSE(inside(open, 0.7F, 0, 0));
}

TEST(Inside, OverlappingBoxesAreOneSolid) {
  Scene two = scene_of({box_mesh({0, 0, 0}, {1, 1, 1}), box_mesh({0.5, 0.2, 0}, {1, 1, 1})});
  for (const float x : {-0.4F, 0.25F, 0.9F}) EXPECT_TRUE(inside(two, x, 0.1F, 0.05F));
  EXPECT_FALSE(inside(two, 1.1F, 0.1F, 0));
  // The same in one mesh, and one box turned inside out.
  two = scene_of({merged_mesh(two)});
  EXPECT_TRUE(inside(two, 0.25F, 0.1F, 0.05F));
  two = scene_of({box_mesh({0, 0, 0}, {1, 1, 1}), flipped(box_mesh({0.5, 0.2, 0}, {1, 1, 1}))});
  for (const float x : {-0.4F, 0.25F, 0.9F}) EXPECT_TRUE(inside(two, x, 0.1F, 0.05F));
}

TEST(Inside, FlippedFacesDoNotMatter) {
  for (const Mesh& mesh :
       {flipped(box_mesh({0, 0, 0}, {1, 1, 1})), flipped(box_mesh({0, 0, 0}, {1, 1, 1}), {2, 7, 8})}) {
    EXPECT_TRUE(inside(scene_of({mesh}), 0.1F, 0.2F, -0.3F));
    EXPECT_FALSE(inside(scene_of({mesh}), 0.6F, 0.2F, -0.3F));
  }
}

TEST(Inside, RoomsAreHollowAndFloorsHoldNothing) {
  const Mesh walls = flipped(box_mesh({0, 1.25, 0}, {4, 2.5, 5}));
  const Scene room = scene_of({walls, box_mesh({0.5, 0.4, 0}, {1, 0.8, 1})});
  EXPECT_FALSE(inside(room, -1, 1, 1));
  EXPECT_TRUE(inside(room, 0.5F, 0.4F, 0));  // furniture
  EXPECT_FALSE(inside(room, 3, 1, 0));
  const Scene without_ceiling =
      scene_of({flipped(box_mesh({0, 1.25, 0}, {4, 2.5, 5}, {3})), box_mesh({0.5, 0.4, 0}, {1, 0.8, 1})});
  EXPECT_FALSE(inside(without_ceiling, -1, 1, 1));
  EXPECT_TRUE(inside(without_ceiling, 0.5F, 0.4F, 0));
  EXPECT_FALSE(inside(floor_scene(), 0, -0.001F, 0));
  EXPECT_FALSE(inside(floor_scene(), 0, 0.001F, 0));
}

TEST(Inside, CavityIsNotSolid) {
  const Mesh chest =
      merged_mesh(scene_of({box_mesh({0, 0, 0}, {1, 1, 1}), flipped(box_mesh({0, 0, 0}, {0.8, 0.8, 0.8}))}));
  EXPECT_FALSE(inside(scene_of({chest}), 0, 0, 0));
  EXPECT_TRUE(inside(scene_of({chest}), 0.45F, 0, 0));
}

TEST(Inside, BoxOfLooseSides) {
  std::vector<Mesh> sides;
  for (int side = 0; side < 6; ++side) {
    std::vector<int> others;
    for (int other = 0; other < 6; ++other) {
      if (other != side) others.push_back(other);
    }
    // Every side a little apart from its neighbours, as files with rounded corners have it.
    sides.push_back(box_mesh({1e-4 * side, 0, 0}, {1, 1, 1}, others));
  }
  EXPECT_TRUE(inside(scene_of({merged_mesh(scene_of(sides))}), 0.1F, 0.2F, 0.3F));
}

TEST(SceneQuery, Rays) {
  const SceneQuery query(scene_of({floor_scene(4).meshes[0], box_mesh({0, 0.5, 0}, {1, 1, 1})}));
  const RayHits hits =
      query.cast(rows({0, 3, 0, 1.5F, 3, 0, 0, 3, 0, NAN, 0, 0}), rows({0, -2, 0, 0, -1, 0, 0, 1, 0, 0, 1, 0}));
  EXPECT_TRUE(torch::equal(hits.hit, torch::tensor({true, true, false, false})));
  EXPECT_NEAR(hits.distances[0].item<float>(), 2, 1e-5);
  EXPECT_NEAR(hits.distances[1].item<float>(), 3, 1e-5);
  EXPECT_TRUE(std::isinf(hits.distances[2].item<float>()));
  EXPECT_TRUE(torch::equal(hits.mesh, torch::tensor({1, 0, -1, -1}, torch::kInt64)));
  EXPECT_TRUE(torch::allclose(hits.points[0], torch::tensor({0.F, 1.F, 0.F})));
  EXPECT_TRUE(torch::allclose(hits.normals[0], torch::tensor({0.F, 1.F, 0.F})));
  EXPECT_FALSE(query.cast(rows({0, 3, 0}), rows({0, -1, 0}), 1.9).hit.item<bool>());
  EXPECT_THROW(query.cast(rows({0, 0, 0}), rows({0, 0, 0, 1, 1, 1})), Error);
}

TEST(SceneQuery, BadPointsAndEmptyScenes) {
  EXPECT_THROW(SceneQuery{Scene()}, Error);
  const SceneQuery query(floor_scene());
  EXPECT_THROW(query.closest(torch::zeros({3})), Error);
  const ClosestPoints closest = query.closest(rows({NAN, 0, 0, INFINITY, 0, 0, 0, 1, 0}));
  EXPECT_TRUE(std::isnan(closest.distances[0].item<float>()));
  EXPECT_TRUE(torch::equal(closest.mesh, torch::tensor({-1, -1, 0}, torch::kInt64)));
  EXPECT_EQ(query.closest(torch::zeros({0, 3})).points.size(0), 0);
}

TEST(SceneQuery, CloudsAndMeshesTogether) {
  Scene scene = floor_scene();
  scene.points = rows({0, 1, 0, 2, 1, 0});
  const SceneQuery query(scene);
  const ClosestPoints closest = query.closest(rows({1.8F, 0.9F, 0, 1, 0.1F, 0}));
  EXPECT_TRUE(torch::equal(closest.mesh, torch::tensor({-1, 0}, torch::kInt64)));
  EXPECT_EQ(closest.face[0].item<int64_t>(), 1);
  EXPECT_TRUE(torch::allclose(closest.points, rows({2, 1, 0, 1, 0, 0})));
  EXPECT_FALSE(query.inside(rows({0, 1, 0})).item<bool>());
}

TEST(CloudQuery, EqualsBruteForce) {
  torch::manual_seed(4);
  const torch::Tensor cloud = torch::rand({1000, 3}), points = torch::rand({200, 3});
  const Neighbours nearest = CloudQuery(cloud).nearest(points, 5);
  const auto [distances, indices] = torch::cdist(points, cloud, 2.0, 2).topk(5, 1, false);
  EXPECT_TRUE(torch::allclose(nearest.distances, distances, 0, 1e-5));
  EXPECT_TRUE(torch::equal(nearest.indices, indices));
  EXPECT_THROW(CloudQuery(cloud).nearest(points, 1001), Error);
  EXPECT_THROW(CloudQuery(torch::zeros({0, 3})), Error);
}

TEST(BasisPoints, OffsetsToAFloor) {
  torch::manual_seed(5);
  const torch::Tensor anchors = torch::rand({7, 64, 3});
  const torch::Tensor offsets = basis_point_offsets(SceneQuery(floor_scene()), anchors);
  ASSERT_EQ(offsets.sizes(), (torch::IntArrayRef{7, 64, 3}));
  EXPECT_TRUE(torch::allclose(offsets, anchors * torch::tensor({0.F, -1.F, 0.F}), 0, 1e-6));
}

TEST(SceneQuery, RecordedRoom) {
  const std::string shared = shared_folder();
  const std::string path = shared + "/data/trumans/room.glb";
  if (shared.empty() || !std::filesystem::exists(path)) GTEST_SKIP() << "no recorded room";
  const Scene scene = read_scene_file(path).scene;
  const SceneQuery query(scene);
  std::mt19937_64 random(1);
  const torch::Tensor surface = sample_points(scene, 2000, random);
  EXPECT_LT(query.closest(surface).distances.max().item<float>(), 1e-4F);
  // Most of a room is air.
  const torch::Tensor low = std::get<0>(surface.min(0)), high = std::get<0>(surface.max(0));
  const torch::Tensor air = low + (high - low) * torch::rand({4000, 3});
  EXPECT_LT(query.inside(air).to(torch::kFloat32).mean().item<float>(), 0.25F);
}

}  // namespace
}  // namespace inhabit
