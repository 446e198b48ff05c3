// Protects which way the skin is pushed out of what it has gone into: to where it came in, also where it has come out
// again behind something thin, and where a limb has gone so far that the way out at the back is the shorter one, which
// the nearest surface would not tell.
#include "inhabit/refine/skin_terms.h"

#include <gtest/gtest.h>

#include "inhabit/scene/query.h"
#include "inhabit/scene/shapes.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr double kDepth = 0.01;

/// The planes that a body at rest meets at an upright board before its belly, whose near face is `in` metres behind
/// the foremost vertex there.
std::vector<PlaneTerm> at_a_board(double in, double thickness, double& face) {
  const BodyModel& body = builtin_body();
  const Skin skin = skin_of(body, {});
  double front = 0;
  for (const Vector3d& v : skin.rest)
    if (std::abs(v.x()) < 0.1 && v.y() > skin.joints[0].y() && v.y() < skin.joints[3].y() + 0.1)
      front = std::max(front, v.z());
  face = front - in;
  MeshBuilder builder;
  builder.box({0, skin.joints[3].y(), face + 0.5 * thickness}, {0.3, 0.25, 0.5 * thickness});
  Scene scene;
  scene.meshes.push_back(builder.mesh("board", {0.5F, 0.5F, 0.5F}));
  BonesPose pose;
  pose.positions = skin.joints;
  pose.rotations.assign(kStandardJoints, Eigen::Quaterniond::Identity());
  std::vector<Point> points = joint_points(kStandardJoints);
  const std::vector<PlaneTerm> out =
      Flesh(body, {}, body_balls(body, {})).planes(SceneQuery(scene), {pose}, kDepth, 1, points);
  for (const PlaneTerm& plane : out) {
    EXPECT_LT(plane.point, static_cast<int>(points.size()));
    EXPECT_LT(plane.normal.dot(place_of(points[static_cast<size_t>(plane.point)], pose)) - plane.height, 0.0081);
  }
  return out;
}

TEST(Flesh, IsPushedOutWhereItCameIn) {
  double face = 0;
  for (const double thickness : {0.3, 0.006}) {
    const std::vector<PlaneTerm> planes = at_a_board(0.03, thickness, face);
    EXPECT_FALSE(planes.empty());
    for (const PlaneTerm& plane : planes) {
      EXPECT_LT(plane.normal.z(), -0.99) << thickness;
      EXPECT_NEAR(plane.height, -face - kDepth, 1e-4) << thickness;
    }
  }
  EXPECT_TRUE(at_a_board(-0.05, 0.3, face).empty()) << "the board is before the belly";
}

TEST(Flesh, IsPushedToWhereItsLimbCameFrom) {
  const BodyModel& body = builtin_body();
  FramePose pose;
  pose.trans.setZero();
  pose.local.assign(kStandardJoints, Eigen::Quaterniond::Identity());
  pose.local[16] = Eigen::AngleAxisd(-0.5, Vector3d::UnitZ());  // the left arm slopes down
  const Poses poses = posed(bones_of(body.skeleton), {pose});
  const Vector3d elbow = poses[0].positions[18], wrist = poses[0].positions[20];
  const double top = 0.4 * elbow.y() + 0.6 * wrist.y(), thickness = 0.03;
  MeshBuilder builder;
  builder.box({wrist.x(), top - 0.5 * thickness, wrist.z()}, {wrist.x() - elbow.x(), 0.5 * thickness, 0.3});
  Scene scene;
  scene.meshes.push_back(builder.mesh("board", {0.5F, 0.5F, 0.5F}));
  std::vector<Point> points = joint_points(kStandardJoints);
  const std::vector<PlaneTerm> planes =
      Flesh(body, {}, body_balls(body, {})).planes(SceneQuery(scene), poses, kDepth, 1, points);
  int beyond = 0;
  for (const PlaneTerm& plane : planes) {
    const Point& point = points[static_cast<size_t>(plane.point)];
    if (point.front().joint != 18) continue;  // a hand may be on the other side
    EXPECT_GT(plane.normal.y(), 0.99);
    EXPECT_NEAR(plane.height, top - kDepth, 1e-4);
    beyond += place_of(point, poses[0]).y() < top - 0.6 * thickness ? 1 : 0;
  }
  EXPECT_GT(beyond, 0) << "else the nearest surface is the right one";
}

}  // namespace
}  // namespace inhabit::refine
