// Protects the collision measures of in-betweening: a body in a box collides, beside it does not, and how many frames,
// how much skin and how deep are what was planted.
#include "inhabit/metrics/collision.h"

#include <gmock/gmock.h>

#include "inhabit/body/kinematics.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/math/rotation.h"
#include "inhabit/metrics/penetration.h"
#include "inhabit/motion/retarget.h"
#include "inhabit/scene/objects.h"
#include "inhabit/scene/shapes.h"
#include "metrics/standing.h"
#include "refusal_of.h"

namespace inhabit {
namespace {

Clip moved(Clip clip, int64_t frame, const std::vector<float>& by) {
  clip.trans = clip.trans.clone();
  clip.trans[frame] += torch::tensor(by);
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

Clip moved_all(Clip clip, const std::vector<float>& by) {
  clip.trans = clip.trans + torch::tensor(by);
  clip.joints = clip.joints + torch::tensor(by);
  return clip;
}

Scene scene_with(std::vector<Mesh> meshes) {
  Scene scene;
  scene.meshes = std::move(meshes);
  return scene;
}

// How far the skin of a standing body reaches to the front (+Z) below the knees: its toes.
double toes() {
  const torch::Tensor v = builtin_body().template_vertices;
  const torch::Tensor low = v.index({v.select(1, 1) < v.select(1, 1).min() + 0.3});
  return low.select(1, 2).max().item<double>();
}

TEST(Collision, OfABodyInABoxIsWholeAndBesideItNone) {
  const Clip clip = standing(4);
  const CollisionMeter around(builtin_body(), scene_with({block("wardrobe_0", {0, 1, 0}, {1.5, 1.5, 1})}));
  const Collision in = around.measure(clip);
  EXPECT_EQ(in.frame_ratio(), 1);
  EXPECT_GT(in.vertex_ratio(), 0.99);
  EXPECT_GT(in.penetration(), 0.85);  // feet 0.5 m above its floor are nearer to a side than the trunk is
  const CollisionMeter beside(builtin_body(), scene_with({block("wardrobe_0", {0, 1, 2}, {1.5, 1.5, 1})}));
  const Collision out = beside.measure(clip);
  EXPECT_EQ(out.frame_ratio(), 0);
  EXPECT_EQ(out.vertex_ratio(), 0);
  EXPECT_EQ(out.penetration(), 0);
}

/// The frames alone are found by another way than how deep they are.
TEST(Collision, FramesAreThoseWithADepth) {
  const Clip sitter = retarget(read_clip(INHABIT_SOURCE_DIR "/examples/data/sit.npz"), "sit");
  const Scene room = read_scene_file(INHABIT_SOURCE_DIR "/examples/data/sit_room.glb").scene;
  const CollisionMeter meter(builtin_body(), room);
  int64_t some = 0;
  for (const float aside : {0.F, 0.05F, 0.3F, -0.2F})
    for (const CollisionTolerance& tolerance : {CollisionTolerance{}, kNoTolerance, CollisionTolerance{0.02, 0.02}}) {
      const Clip clip = moved_all(sitter, {aside, 0, aside / 2});
      const torch::Tensor deep = meter.measure(clip, {tolerance}).front().depth > 0;
      EXPECT_TRUE(meter.colliding_frames(clip, tolerance).equal(deep)) << aside << " " << tolerance.other;
      some += deep.sum().item<int64_t>() > 0 && !deep.all().item<bool>() ? 1 : 0;
    }
  EXPECT_GT(some, 4) << "of all or of no frames nothing is told";
}

TEST(Collision, CountsTheFramesWhoseFeetAreDeeperThanTheTolerance) {
  const double face = toes() + 0.001;
  const CollisionMeter meter(builtin_body(), scene_with({block("table_0", {0, -0.35, face + 0.5}, {2, 0.65, 0.5})}));
  Clip clip = standing(10);
  EXPECT_EQ(meter.measure(clip).frame_ratio(), 0);
  EXPECT_EQ(meter.measure(moved(clip, 3, {0, 0, 0.008F})).frame_ratio(), 0);  // 7 mm: within the tolerance
  clip = moved(moved(clip, 3, {0, 0, 0.031F}), 7, {0, 0, 0.061F});
  const Collision c = meter.measure(clip);
  EXPECT_DOUBLE_EQ(c.frame_ratio(), 0.2);
  EXPECT_NEAR(c.penetration(), 0.06, 1e-3);
  EXPECT_NEAR(c.depth[3].item<double>(), 0.03, 1e-3);
  EXPECT_EQ(c.depth[4].item<double>(), 0);
  EXPECT_GT(c.vertices[7].item<double>(), c.vertices[3].item<double>());  // more of the foot is in
  EXPECT_GT(c.vertices[3].item<double>(), 0);
  torch::Tensor mask = torch::zeros({10}, torch::kBool);
  mask[3] = true;
  EXPECT_EQ(c.frame_ratio(mask), 1);
  EXPECT_NEAR(c.penetration(mask), 0.03, 1e-3);
  EXPECT_NEAR(c.vertex_ratio(mask), c.vertices[3].item<double>(), 1e-7);
  EXPECT_EQ(c.frame_ratio(torch::zeros({10}, torch::kBool)), 0);
}

TEST(Collision, LetsSkinThatIsSatOnGiveWay) {
  const Clip clip = standing(2);
  const torch::Tensor vertices = clip.trans[0] + builtin_body().template_vertices;
  const torch::Tensor soft = supporting_skin(builtin_body());
  EXPECT_GT(soft.sum().item<int64_t>(), 300);
  EXPECT_GT((~soft).sum().item<int64_t>(), 300);
  // A shelf across the thighs from the front: 3 cm in them is nothing, 5 cm is.
  const torch::Tensor thigh = vertices.index({(vertices.select(1, 1) > 0.68) & (vertices.select(1, 1) < 0.76)});
  const double front = thigh.select(1, 2).max().item<double>();
  const auto shelf = [&](double depth) {
    return scene_with({block("shelf_0", {0, 0.72, front - depth + 0.5}, {1, 0.2, 0.5})});
  };
  const auto at_thighs = [&](double depth) {
    const Collision c = CollisionMeter(builtin_body(), shelf(depth)).measure(clip);
    return c.penetration();
  };
  EXPECT_EQ(at_thighs(0.03), 0);
  EXPECT_NEAR(at_thighs(0.055), 0.055, 0.004);
}

TEST(Collision, LeavesOutFloorAndRugsAndNothingElse) {
  const Clip clip = moved(standing(2), 1, {0, -0.1F, 0});
  const auto ratio = [&](const std::string& name) {
    return CollisionMeter(builtin_body(), scene_with({block(name, {0, -0.5, 0}, {3, 0.5, 3})}))
        .measure(clip)
        .frame_ratio();
  };
  EXPECT_EQ(ratio("floor"), 0);
  EXPECT_EQ(ratio("rug.2"), 0);
  EXPECT_EQ(ratio("step_0"), 0.5);
  EXPECT_EQ(CollisionMeter(builtin_body(), Scene{}).measure(clip).frame_ratio(), 0);
  Scene cloud;  // points have no inside
  cloud.points = torch::rand({50, 3});
  EXPECT_EQ(CollisionMeter(builtin_body(), cloud).measure(clip).frame_ratio(), 0);
}

TEST(Collision, PutsTheBodyWhereTheClipsRootIs) {
  // A skeleton whose root joint is defined 30 cm higher: the same joints, so the same collision.
  const Scene scene = scene_with({block("table_0", {0, -0.35, toes() + 0.5 - 0.05}, {2, 0.65, 0.5})});
  const CollisionMeter meter(builtin_body(), scene);
  Clip clip = standing(2);
  const double depth = meter.measure(clip).penetration();
  EXPECT_NEAR(depth, 0.05, 1e-3);
  clip.skeleton.offsets = clip.skeleton.offsets.clone();
  clip.skeleton.offsets[0][1] += 0.3F;
  clip.trans.select(1, 1).sub_(0.3F);
  EXPECT_NEAR(meter.measure(clip).penetration(), depth, 1e-5);
  clip.rotations = torch::Tensor();
  EXPECT_THAT(refusal_of([&] { meter.measure(clip); }), testing::HasSubstr("joint rotations"));
}

TEST(Collision, BySeveralTolerancesIsWhatEachGives) {
  const double face = toes() + 0.001;
  const CollisionMeter meter(builtin_body(), scene_with({block("table_0", {0, -0.35, face + 0.5}, {2, 0.65, 0.5})}));
  const Clip clip = moved(moved(standing(4), 1, {0, 0, 0.008F}), 2, {0, 0, 0.031F});
  const std::vector<Collision> found = meter.measure(clip, {{}, kNoTolerance, {0.05, 0.05}});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_TRUE(found[0].depth.equal(meter.measure(clip).depth));
  EXPECT_TRUE(found[0].vertices.equal(meter.measure(clip).vertices));
  EXPECT_DOUBLE_EQ(found[0].frame_ratio(), 0.25);  // 7 mm is within 1 cm
  EXPECT_DOUBLE_EQ(found[1].frame_ratio(), 0.5);
  EXPECT_NEAR(found[1].depth[1].item<double>(), 0.007, 1e-3);
  EXPECT_GT(found[1].vertices[2].item<double>(), found[0].vertices[2].item<double>());
  EXPECT_EQ(found[2].frame_ratio(), 0);
}

TEST(NearFrames, AreThoseCloserThanTheDistance) {
  const Clip clip = moved(standing(5), 2, {0, 0, 0.2F});
  const Scene scene = scene_with(
      {block("floor", {0, -0.5, 0}, {3, 0.5, 3}), block("wall_0", {0, 0.15, toes() + 0.25 + 0.5}, {2, 0.15, 0.5})});
  const CollisionMeter meter(builtin_body(), scene);  // 25 cm off the toes, in frame 2 five
  EXPECT_EQ(meter.near_frames(clip, 0.08).sum().item<int64_t>(), 1);
  EXPECT_TRUE(meter.near_frames(clip, 0.08)[2].item<bool>());
  EXPECT_EQ(meter.near_frames(clip, 0.04).sum().item<int64_t>(), 0);
  EXPECT_EQ(meter.near_frames(clip, 0.3).sum().item<int64_t>(), 5);
  EXPECT_TRUE(meter.near_frames(moved(clip, 4, {0, 0, 0.6F}), 0.04)[4].item<bool>());  // inside is near
}

/// The skin of every frame by the exact queries alone.
Collision plainly_measured(const Scene& scene, const Clip& clip) {
  Scene counts = scene;
  counts.meshes.clear();
  for (const Mesh& mesh : scene.meshes)
    if (!is_floor(mesh.name)) counts.meshes.push_back(mesh);
  const SceneQuery query(counts);
  const BodyModel& body = builtin_body();
  const torch::Tensor trans = clip.root_path() - shaped_skeleton(body, clip.betas).offsets[0],
                      allowed = torch::where(supporting_skin(body), torch::tensor(static_cast<float>(kSupportedDepth)),
                                             torch::tensor(static_cast<float>(kCollisionDepth)));
  Collision out{torch::zeros({clip.frames()}), torch::zeros({clip.frames()}), {}};
  for (int64_t t = 0; t < clip.frames(); ++t) {
    const torch::Tensor skin_points = skin(body, clip.betas, axis_angle_to_matrix(clip.rotations[t]), trans[t]),
                        depth = query.closest(skin_points).distances,
                        hit = query.inside(skin_points) & (depth > allowed);
    out.depth[t] = (depth * hit).max();
    out.vertices[t] = hit.to(torch::kFloat32).mean();
  }
  return out;
}

/// The distance field in the meter must not change what it says: bit for bit the depths of the exact queries, on people
/// who sit, lean and walk into furniture of a real room.
TEST(Collision, IsWhatTheExactQueriesSay) {
  const std::string data = INHABIT_SOURCE_DIR "/examples/data/";
  for (const std::string name : {"sit", "walk"}) {
    const Scene scene = read_scene_file(data + name + "_room.glb").scene;
    Clip clip = retarget(read_clip(data + name + ".npz"), name);
    clip = slice(clip, 0, std::min<int64_t>(clip.frames(), 40));
    double colliding = 0;
    const CollisionMeter meter(builtin_body(), scene);
    for (const float aside : {0.F, 0.6F, 1.5F}) {
      const Clip there = moved_all(clip, {aside, -0.3F * aside, aside});
      const Collision got = meter.measure(there), expected = plainly_measured(scene, there);
      EXPECT_TRUE(torch::equal(got.depth, expected.depth)) << name << " " << aside;
      EXPECT_LT((got.vertices - expected.vertices).abs().max().item<double>(), 1e-5);
      colliding += expected.frame_ratio();
    }
    EXPECT_GT(colliding, 0) << "nothing to tell apart";
  }
}

}  // namespace
}  // namespace inhabit
