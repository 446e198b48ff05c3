// Protects what a body is kept out of: asked about a whole motion, where most of what is far is left out and sides are
// carried from frame to frame, the answer is that of each frame by itself, also for furniture that is no closed body.
#include "inhabit/refine/scene_terms.h"

#include <gtest/gtest.h>

#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/scene/objects.h"

namespace inhabit::refine {
namespace {

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

}  // namespace
}  // namespace inhabit::refine
