// Protects what a body is kept out of: asked about a whole motion, where most of what is far is left out and sides are
// carried from frame to frame, the answer is that of each frame by itself, also for furniture that is no closed body.
#include "inhabit/refine/scene_terms.h"

#include <gtest/gtest.h>

#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/shapes.h"
#include "metrics/standing.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;

constexpr int kFirst = kStandardJoints;
constexpr double kReach = 0.05;

std::string example_file(const std::string& name) { return std::string(INHABIT_SOURCE_DIR) + "/examples/data/" + name; }

/// How many planes there are.
size_t expect_frame_by_frame(const Clip& clip, const Scene& scene) {
  const Surroundings surroundings(scene);
  const std::vector<BodyBall> balls = body_balls(builtin_body(), {});
  const Poses poses = posed(bones_of(clip.skeleton), trajectory_of(clip));
  const std::vector<PlaneTerm> all = surroundings.planes(balls, kFirst, poses, 0, kReach, 1);
  std::vector<PlaneTerm> each;
  for (size_t t = 0; t < poses.size(); ++t)
    for (PlaneTerm term : surroundings.planes(balls, kFirst, {poses[t]}, 0, kReach, 1)) {
      term.frame = static_cast<int64_t>(t);
      each.push_back(term);
    }
  EXPECT_EQ(all.size(), each.size());
  for (size_t i = 0; i < std::min(all.size(), each.size()); ++i) {
    EXPECT_EQ(all[i].frame, each[i].frame);
    EXPECT_EQ(all[i].point, each[i].point);
    EXPECT_EQ(all[i].normal, each[i].normal);
    EXPECT_EQ(all[i].height, each[i].height);
  }
  return all.size();
}

TEST(Surroundings, AMotionAsAWholeMeetsWhatItsFramesMeet) {
  const Scene room = read_scene_file(example_file("sit_room.glb")).scene;
  EXPECT_GT(expect_frame_by_frame(read_clip(example_file("sit.npz")), room), 500U);
}

TEST(Surroundings, AlsoWhereFurnitureIsNoClosedBody) {
  Scene room = read_scene_file(example_file("sit_room.glb")).scene;
  for (Mesh& mesh : room.meshes)
    if (!is_floor(mesh.name)) mesh.faces = mesh.faces.slice(0, 0, mesh.faces.size(0) * 4 / 5).clone();
  EXPECT_GT(expect_frame_by_frame(read_clip(example_file("sit.npz")), room), 300U);
}

TEST(Surroundings, NothingIsMetInAnEmptyRoomOrFarAway) {
  const Clip walk = read_clip(example_file("walk.npz"));
  EXPECT_EQ(expect_frame_by_frame(walk, {}), 0U);
  Scene room = read_scene_file(example_file("sit_room.glb")).scene;
  for (Mesh& mesh : room.meshes) mesh.vertices = mesh.vertices + 50;
  EXPECT_EQ(expect_frame_by_frame(walk, room), 0U);
}

/// A ball of a forearm that goes 0.6 m ahead, through a board of 6 cm across its path, and the planes it meets at.
/// @param step metres a frame that the pelvis goes, in a circle
std::vector<PlaneTerm> past_the_end_of_a_board(double rate, double end, double step = 0) {
  MeshBuilder builder;
  builder.box({end + 1, 1, 0}, {1, 1, 0.03});
  Scene scene;
  scene.meshes.push_back(builder.mesh("board", {0.5F, 0.5F, 0.5F}));
  Poses poses;
  for (int t = 0; t < 13; ++t) {
    BonesPose pose;
    pose.positions.assign(kStandardJoints, Vector3d(-1, 1, 0));
    pose.rotations.assign(kStandardJoints, Eigen::Quaterniond::Identity());
    pose.positions[0] += Vector3d(std::sin(step * t), 0, 1 - std::cos(step * t));
    pose.positions[18] = Vector3d(0, 1, -0.3 + 0.05 * t);
    poses.push_back(pose);
  }
  const BodyBall ball = {{Attachment{18, 1, Vector3d::Zero()}}, 0.04, 0.03};
  return Surroundings(scene).planes({ball}, kFirst, poses, rate, kReach, 1);
}

TEST(Surroundings, WhatGoesThroughAThinBoardIsPushedPastItsEnd) {
  // 0.1 m in from the end of the board, 1.5 m/s.
  const std::vector<PlaneTerm> past = past_the_end_of_a_board(30, -0.1);
  int aside = 0;
  for (const PlaneTerm& plane : past) {
    if (plane.normal.x() > -0.99) continue;
    ++aside;
    EXPECT_NEAR(plane.height, 0.1 + 0.04 - 0.005, 1e-4) << "beyond the end, and it does not rest";
  }
  EXPECT_GE(aside, 2);
  for (const PlaneTerm& plane : past_the_end_of_a_board(30, -0.8))
    EXPECT_GT(std::abs(plane.normal.z()), 0.99) << "the end is too far away";
  for (const PlaneTerm& plane : past_the_end_of_a_board(0, -0.1))
    EXPECT_GT(std::abs(plane.normal.z()), 0.99) << "poses that do not follow one another";
}

/// What the balls do not cover goes into furniture as deep as it sticks out.
TEST(BodyBalls, CoverHandsToTheTipsOfFingersAndThumbs) {
  const BodyModel& body = builtin_body();
  for (const float shape : {-1.F, 0.F, 1.F}) {
    const torch::Tensor betas = torch::full({body.betas()}, shape);
    const torch::Tensor skin = (body.template_vertices + body.shape_dirs.matmul(betas)).contiguous(),
                        joints = shaped_skeleton(body, betas).rest_joints().to(torch::kFloat32).contiguous();
    const auto v = skin.accessor<float, 2>(), at = joints.accessor<float, 2>();
    const auto w = body.skin_weights.accessor<float, 2>();
    const std::vector<BodyBall> balls = body_balls(body, betas);
    for (int64_t i = 0; i < skin.size(0); ++i)
      for (const int hand : {20, 21}) {
        if (!(w[i][hand] > 0.5F)) continue;
        double beyond = 1;
        for (const BodyBall& ball : balls) {
          const Attachment& in = ball.point.front();
          if (in.joint != hand && in.joint != hand - 2) continue;
          const Vector3d from(v[i][0] - at[in.joint][0], v[i][1] - at[in.joint][1], v[i][2] - at[in.joint][2]);
          beyond = std::min(beyond, (from - in.offset).norm() - ball.radius);
        }
        ASSERT_LT(beyond, 0.03) << "vertex " << i;
      }
  }
}

/// A foot under a bar is not a foot that is too low; one that is as low everywhere is.
TEST(Surroundings, TheFloorUnderAFootIsNoFurnitureOverIt) {
  Scene scene;
  scene.meshes = {block("floor", {0, -0.1, 0}, {3, 0.1, 3}), block("table_0", {1, 0.2, 0}, {0.5, 0.02, 1}),
                  block("step_0", {-2, 0.1, 0}, {0.6, 0.1, 1})};
  Track feet;
  for (int k = -5; k <= 5; ++k) feet.push_back({0.5 * k, k < -3 ? 0.22 : 0.02, 0});
  const std::vector<double> floor = Surroundings(scene).floor_under(feet);
  for (size_t k = 0; k < feet.size(); ++k) EXPECT_NEAR(floor[k], feet[k].y() - 0.02, 1e-4) << feet[k].x();
  for (Vector3d& foot : feet) foot.y() -= 0.15;  // the whole walk is too low: it stays so
  const std::vector<double> low = Surroundings(scene).floor_under(feet);
  EXPECT_NEAR(low[5], 0, 1e-4);
}

TEST(Surroundings, OnlyWhatIsSlowMayRestAndOnlyOfSomebodyWhoStays) {
  const auto give = [](double rate, double step) {  // where it comes to the board's face
    const PlaneTerm first = past_the_end_of_a_board(rate, -0.8, step).front();
    return -first.normal.z() * 0.03 + 0.04 - first.height * 1;
  };
  EXPECT_LT(give(30, 0), give(1, 0) - 0.02);
  EXPECT_NEAR(give(1, 0.3), give(1, 0), 1e-9) << "0.3 m/s: who shifts on a seat";
  EXPECT_NEAR(give(1, 1), give(30, 0), 1e-9) << "0.84 m/s: the arm that swings back";
}

}  // namespace
}  // namespace inhabit::refine
