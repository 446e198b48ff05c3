#include "inhabit/synth/passages.h"

#include <gtest/gtest.h>

#include <cmath>

#include "inhabit/error.h"
#include "inhabit/io/files.h"
#include "inhabit/math/heading.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/synth/fit.h"

namespace inhabit {
namespace {

// The walk of the examples, its middle at the origin.
Clip example_walk() {
  const std::string file = INHABIT_SOURCE_DIR "/examples/data/walk.npz";
  const Clip clip = prepare_recording(read_clip(file), file, 12).front();
  const torch::Tensor root = clip.root_path().mean(0);
  return transformed(clip, {0, {-root[0].item<double>(), 0, -root[2].item<double>()}});
}

struct Passages {
  Room room;
  int count = 0;
};
Passages passages_of(const Clip& clip, const BodySweep& sweep, double tried, std::mt19937_64& random) {
  Passages out;
  out.room.size = {16, 16};
  Layout layout(out.room, {});
  layout.require([](const Furniture&) { return true; });
  out.count = add_passages(layout, clip, sweep, tried, random);
  return out;
}

// Metres from a ball to the nearest box of a piece; inside it, less its radius.
double gap(const BodySweep::Ball& ball, const Furniture& piece) {
  const Eigen::Vector3d own = piece.pose.inverse() * ball.center;
  double least = 1e9;
  for (const Box& box : piece.boxes)
    least = std::min(least, ((own - box.center).cwiseAbs() - box.half).cwiseMax(0).norm() - ball.radius);
  return least;
}

TEST(Passages, StandOnBothSidesOfAWalkAndCloseToTheBody) {
  const Clip walk = example_walk();
  const BodySweep sweep(walk, builtin_body());
  int passages = 0;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 random(seed);
    const Passages made = passages_of(walk, sweep, 1, random);
    ASSERT_EQ(made.room.furniture.size(), 2U * static_cast<size_t>(made.count));
    passages += made.count;
    for (size_t i = 0; i < made.room.furniture.size(); i += 2) {
      const Furniture &left = made.room.furniture[i], &right = made.room.furniture[i + 1];
      EXPECT_EQ(left.kind, right.kind);
      // The path goes between them.
      const Eigen::Vector2d a = on_ground(left.pose.translation()), b = on_ground(right.pose.translation());
      double nearest = 1e9;
      for (int64_t t = 0; t < walk.frames(); ++t) {
        const Eigen::Vector2d at(walk.joints[t][0][0].item<double>(), walk.joints[t][0][2].item<double>());
        nearest = std::min(nearest, (at - (a + b) / 2).norm());
      }
      EXPECT_LT(nearest, 0.35) << seed;
      const Eigen::Vector2d across = left_of(heading_of(on_ground(left.pose.linear().col(2))));
      for (const Eigen::Vector2d& place : {Eigen::Vector2d(a), Eigen::Vector2d(b)}) {
        double side = 0, least = 1e9;  // of the nearest frame
        for (int64_t t = 0; t < walk.frames(); ++t) {
          const Eigen::Vector2d at(walk.joints[t][0][0].item<double>(), walk.joints[t][0][2].item<double>());
          if ((at - place).norm() < least) least = (at - place).norm(), side = across.dot(place - at);
        }
        EXPECT_EQ(side > 0, place == a) << "the first is to the left";
      }
      for (const Furniture* piece : {&left, &right}) {
        double least = 1e9;
        for (const BodySweep::Ball& ball : sweep.balls()) least = std::min(least, gap(ball, *piece));
        EXPECT_GE(least, 0.04 - 1e-6) << seed;
        EXPECT_LT(least, 0.25) << seed;
      }
    }
  }
  EXPECT_GE(passages, 12) << "there is nothing else in these rooms";
}

TEST(Passages, NoneWhereSomebodyStands) {
  const Clip walk = example_walk();
  const Clip stands = slice(walk, 0, 1);
  Clip held = stands;
  held.rotations = stands.rotations.repeat({90, 1, 1});
  held.trans = stands.trans.repeat({90, 1});
  held.joints = stands.joints.repeat({90, 1, 1});
  std::mt19937_64 random(1);
  EXPECT_EQ(passages_of(held, BodySweep(held, builtin_body()), 1, random).count, 0);
}

// Data sets that were made without passages come out the same.
TEST(Passages, AFractionOf0DrawsNothing) {
  const Clip walk = example_walk();
  std::mt19937_64 random(3), untouched(3);
  EXPECT_EQ(passages_of(walk, BodySweep(walk, builtin_body()), 0, random).count, 0);
  EXPECT_EQ(random(), untouched());
  for (const double tried : {1.5, -0.1, std::nan("")}) EXPECT_THROW(check_passages(tried), Error);
}

}  // namespace
}  // namespace inhabit
