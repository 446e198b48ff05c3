// Protects the depth's scale and offset: found exactly from a body without errors, through points that are none of
// the body's, from the floor where the body hardly comes nearer; disparity and frames without a person are refused.
#include "inhabit/reconstruct/align_depth.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "inhabit/math/random.h"
#include "refusal_of.h"

namespace inhabit::reconstruct {
namespace {

using Eigen::Vector3d;

constexpr double kScale = 0.4, kOffset = 0.6;  // metric = kScale raw + kOffset

double raw_of(double metres) { return (metres - kOffset) / kScale; }

/// The side that a round body of 30 cm shows a camera from `away` metres.
SeenBody ball_at(double away, double noise, std::mt19937_64& random) {
  SeenBody out;
  for (double x = -0.28; x < 0.29; x += 0.02)
    for (double y = -0.28; y < 0.29; y += 0.02) {
      const double square = 0.09 - x * x - y * y;
      if (square < 0.002) continue;
      const Vector3d at(x, y, away - std::sqrt(square));
      out.vertices.push_back(at);
      out.raw.push_back(raw_of(at.z()));
      out.person.push_back({at / at.z(), raw_of(at.z())});
    }
  for (Vector3d& v : out.vertices) v.z() += noise * normal(random);
  return out;
}

/// The floor 1.5 m below a level camera, from 2 to 6 m ahead, a third of it under furniture 40 cm high.
void add_floor_below(SeenBody& frame) {
  for (int i = 0; i < 200; ++i) {
    const double depth = 2 + 0.02 * i;
    frame.floor.push_back({raw_of(i % 3 == 0 ? depth * 1.1 / 1.5 : depth), depth});
  }
}

TEST(AlignDepth, ABodyThatComesNearerTellsScaleAndOffset) {
  std::mt19937_64 random(1);
  std::vector<SeenBody> frames;
  for (const double away : {2.0, 2.5, 3.0, 4.0}) frames.push_back(ball_at(away, 0, random));
  const DepthAlignment found = align_depth(frames, "maps");
  EXPECT_NEAR(found.scale.scale, kScale, 1e-3 * kScale);
  EXPECT_NEAR(found.scale.offset, kOffset, 2e-3);
  EXPECT_LT(found.after, 1e-3);
  EXPECT_EQ(found.floor, 0);
  // 2, 2.5, 3, 4 m: their standard deviation is 0.74 m.
  EXPECT_NEAR(found.spread, 0.74, 0.02);
}

TEST(AlignDepth, PixelsThatAreNoneOfThePersonsAreNotMinded) {
  std::mt19937_64 random(2);
  std::vector<SeenBody> frames;
  for (const double away : {2.0, 2.5, 3.0, 4.0}) {
    frames.push_back(ball_at(away, 0, random));
    SeenBody& frame = frames.back();
    for (size_t i = 0; i < frame.person.size(); i += 8) {  // the wall behind, through the mask's edge
      frame.person[i].depth = raw_of(6);
      frame.raw[i] = raw_of(6);
    }
  }
  EXPECT_NEAR(align_depth(frames, "maps").scale.scale, kScale, 0.02 * kScale);
}

TEST(AlignDepth, TheFloorTellsTheScaleOfABodyThatStands) {
  std::mt19937_64 random(3);
  std::vector<SeenBody> alone, with_floor;
  for (int i = 0; i < 6; ++i) {
    // The estimate is wrong by 6 cm along the line of sight, a frame this way and a frame that.
    SeenBody frame = ball_at(3 + 0.02 * i, 0.02, random);
    for (Vector3d& v : frame.vertices) v *= 1 + 0.02 * (i % 3 - 1);
    alone.push_back(frame);
    add_floor_below(frame);
    with_floor.push_back(frame);
  }
  const DepthAlignment a = align_depth(alone, "maps"), b = align_depth(with_floor, "maps");
  EXPECT_GT(b.floor, 0.5);
  EXPECT_LT(std::abs(b.scale.scale / kScale - 1), 0.02);
  EXPECT_LT(std::abs(b.scale.scale / kScale - 1), std::abs(a.scale.scale / kScale - 1));
}

TEST(AlignDepth, RefusesDisparityAndFramesWithoutAPerson) {
  std::mt19937_64 random(4);
  std::vector<SeenBody> frames;
  for (const double away : {2.0, 3.0, 4.0}) {
    frames.push_back(ball_at(away, 0, random));
    for (double& raw : frames.back().raw) raw = 1 / (kScale * raw + kOffset);
    for (DepthSample& s : frames.back().person) s.depth = 1 / (kScale * s.depth + kOffset);
  }
  EXPECT_NE(refusal_of([&] { align_depth(frames, "maps"); }).find("not disparity"), std::string::npos);
  EXPECT_NE(refusal_of([&] { align_depth({{}, {}}, "maps"); }).find("maps"), std::string::npos);
}

}  // namespace
}  // namespace inhabit::reconstruct
