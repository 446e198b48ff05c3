// Protects routes to and from chairs: through the gap of a wall, from behind a chair to its front, none where there is
// none; and that a person's trajectory is drawn to them.
#include "inhabit/interact/route.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "inhabit/interact/guide.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/shapes.h"
#include "interact/chair_scene.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2d;

/// Boxes 2 m high from (x0, z0) to (x1, z1).
Scene walls(const std::vector<std::array<double, 4>>& boxes) {
  Scene scene = floor_scene();
  for (size_t i = 0; i < boxes.size(); ++i) {
    const auto& [x0, z0, x1, z1] = boxes[i];
    MeshBuilder builder;
    builder.box({(x0 + x1) / 2, 1, (z0 + z1) / 2}, {(x1 - x0) / 2, 1, (z1 - z0) / 2});
    scene.meshes.push_back(builder.mesh("wall_" + std::to_string(i), {0.5F, 0.5F, 0.5F}));
  }
  return scene;
}

FreeSpace floor_of(const Scene& scene) { return free_space(obstacles_of(scene)); }

TEST(Route, GoesThroughTheGapOfAWall) {
  // A closed room of 6 x 6 m, halved by a wall with a gap from x = 1 to x = 1 + width.
  const auto room = [](double width) {
    return floor_of(walls({{-3.1, -3.1, 3.1, -3},
                           {-3.1, 3, 3.1, 3.1},
                           {-3.1, -3, -3, 3},
                           {3, -3, 3.1, 3},
                           {-3, -0.05, 1, 0.05},
                           {1 + width, -0.05, 3, 0.05}}));
  };
  const Vector2d from(-1, -2), to(-1.5, 2);
  for (const double width : {1.2, 0.7}) {
    const auto path = find_route(room(width), from, to);
    ASSERT_TRUE(path.has_value()) << width;
    EXPECT_LT((path->points.front() - from).norm(), 1e-9);
    EXPECT_LT((path->points.back() - to).norm(), 0.021);
    const Vector2d gap(1 + width / 2, 0);
    double nearest = 1e9;
    for (const Vector2d& p : path->points) nearest = std::min(nearest, (p - gap).norm());
    EXPECT_LT(nearest, width / 2 - 0.2) << "through it, not along its edge";
    const double least = (from - Vector2d(1, 0)).norm() + (to - Vector2d(1, 0)).norm();
    EXPECT_GT(path->total(), least);
    EXPECT_LT(path->total(), least + 1.6);
  }
  EXPECT_FALSE(find_route(room(0.3), from, to).has_value()) << "nobody gets through";
  EXPECT_FALSE(find_route(room(1.2), from, Vector2d(0, 0)).has_value()) << "in the wall";
}

TEST(Route, ANarrowGapIsTakenWhereTheWideOneIsFarAway) {
  const FreeSpace floor = floor_of(walls({{-9, -0.05, -0.3, 0.05}, {0.3, -0.05, 9, 0.05}}));  // 0.6 m, or 9 m away
  const auto path = find_route(floor, {0, -1}, {0, 1});
  ASSERT_TRUE(path.has_value());
  EXPECT_LT(path->total(), 2.4);
}

TEST(Route, FromBehindAChairLeadsAroundItAndBack) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 6; ++i) {
    Furniture piece = i % 2 == 0 ? make_armchair(random) : make_sofa(random, 2);
    piece.place(0.3, -0.5, 1.1 * i);
    const Scene scene = scene_of({piece});
    const FreeSpace floor = floor_of(scene);
    const Chair chair = find_chair(scene, piece.kind + "_0");
    const Vector2d from = on_ground(chair.frame * Eigen::Vector3d(0.3, 0, -2.2));
    const auto path = find_route(floor, from, chair);
    ASSERT_TRUE(path.has_value());
    double clear = 1e9;
    for (const Vector2d& p : path->points) clear = std::min(clear, floor.at(p));
    EXPECT_GT(clear, 0.2);
    const Vector2d end = path->points.back();
    const Eigen::Vector3d own = chair.frame.inverse() * Eigen::Vector3d(end.x(), 0, end.y());
    EXPECT_NEAR(own.x(), 0, 0.03) << "before the seat";
    EXPECT_GT(own.z(), 0.45);
    EXPECT_LT(own.z(), 1.0);
    EXPECT_FALSE(straight(floor, from, end, 0.3));
    const auto off = find_route(floor, chair, from);
    ASSERT_TRUE(off.has_value());
    EXPECT_LT((off->points.front() - end).norm(), 1e-9);
    EXPECT_LT((off->at(0.5) - path->at(path->total() - 0.5)).norm(), 1e-6);
    EXPECT_NEAR(off->total(), path->total(), 1e-9);
  }
}

TEST(Route, ASeatWithATableBeforeItIsComeToFromTheSide) {
  std::mt19937_64 random(5);
  Furniture chair = make_chair(random, 0.45), table = make_table(random, 1.6, 0.8, 0.75);
  table.place(0, 0.8, 0);  // its edge is 0.4 m before the middle of the chair
  const Scene scene = scene_of({chair, table});
  const FreeSpace floor = floor_of(scene);
  const Chair found = find_chair(scene, "chair_0");
  const auto path = find_route(floor, Vector2d(0, -2), found);
  ASSERT_TRUE(path.has_value());
  EXPECT_GE(floor.at(path->points.back()), 0.2);
  EXPECT_LT((path->points.back() - on_ground(found.seat())).norm(), 1.0);
}

TEST(Guide, DrawsTheNextSecondToTheRoute) {
  const FreeSpace floor = free_space(Scene{});
  Guide guide(*find_route(floor, Vector2d(0, 0), Vector2d(0, 2)));
  State state;
  Sample still;
  still.root = {{0.4F, 0.5F}, {1, 0}};
  state.samples.fill(still);
  guide.draw(state);
  EXPECT_EQ(state.samples.back().root.position, still.root.position) << "who stands sets off by themselves";
  for (int i = kNow + 1; i < kSamples; ++i)  // now they walk
    state.samples[static_cast<size_t>(i)].root.position.y() += static_cast<float>(i - kNow) / 30;
  guide.follow({0.4, 0.3});
  EXPECT_NEAR(guide.left(), 1.7, 0.04) << "abreast of it";
  guide.follow({0.4, 1.9});
  EXPECT_NEAR(guide.left(), 1.2, 0.04) << "half a metre at once";
  guide.draw(state);
  EXPECT_EQ(state.now().root.position, still.root.position) << "where they are is where they are";
  for (int i = kNow + 1; i < kSamples; ++i) {
    const Place &root = state.samples[static_cast<size_t>(i)].root,
                &before = state.samples[static_cast<size_t>(i) - 1].root;
    EXPECT_LT(root.position.x(), before.position.x());
    EXPECT_GT(root.facing.y(), before.facing.y());
  }
  EXPECT_LT(state.samples.back().root.position.x(), 0.1);
  EXPECT_NEAR(state.samples.back().root.facing.norm(), 1, 1e-5);
}

TEST(Guide, DrawsToTheLineBeforeTheSeatOnly) {
  std::mt19937_64 random(7);
  Furniture piece = make_chair(random, 0.45);
  piece.place(1, 2, 0);
  const Chair chair = find_chair(scene_of({piece}), "chair_0");
  const Vector2d seat = on_ground(chair.seat());
  const auto drawn = [&](double x, double z) {
    State state;
    Sample still;
    still.root.position = (seat + Vector2d(x, z)).cast<float>();
    state.samples.fill(still);
    draw_before(chair, state);
    return Vector2d(state.samples.back().root.position.cast<double>() - seat);
  };
  EXPECT_LT((drawn(0.2, 0.5) - Vector2d(0, 0.5)).norm(), 0.02);
  EXPECT_LT((drawn(0.2, 1.5) - Vector2d(0.2, 1.5)).norm(), 1e-5);
  EXPECT_LT((drawn(0.2, -0.5) - Vector2d(0.2, -0.5)).norm(), 1e-5);
}

}  // namespace
}  // namespace inhabit::interact
