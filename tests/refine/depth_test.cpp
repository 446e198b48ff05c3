// Protects the refinement to depth: the Jacobian through the skinning against finite differences, and a rendered
// sequence whose truth is known: jitter goes, the joints come back.
#include "inhabit/refine/refine_depth.h"

#include <gtest/gtest.h>

#include "depth_camera.h"
#include "inhabit/body/kinematics.h"
#include "inhabit/io/files.h"
#include "inhabit/math/quaternion.h"
#include "inhabit/refine/depth_terms.h"
#include "inhabit/refine/solve.h"
#include "inhabit/refine/trajectory.h"
#include "refusal_of.h"

namespace inhabit::refine {
namespace {

using Eigen::Vector3d;
using torch::Tensor;

Clip example(const char* name) {
  Clip clip = read_clip(std::string(INHABIT_SOURCE_DIR) + "/examples/data/" + name);
  clip.skeleton = shaped_skeleton(builtin_body(), clip.betas);  // the bones of the skin that is rendered
  clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans);
  return clip;
}

double distance_between(const Clip& a, const Clip& b) {
  return (a.joints - b.joints).norm(2, {2}).mean().item<double>();
}
double jerk_of(const Clip& clip) { return clip.joints.diff(3, 0).norm(2, {2}).mean().item<double>(); }

CloudSequence in_memory(const std::vector<Tensor>& clouds) {
  return {"clouds", static_cast<int64_t>(clouds.size()),
          [clouds](int64_t t) { return clouds.at(static_cast<size_t>(t)); }};
}

/// A body model of SMPL's layout with blend shapes of the pose: the built-in body's skin, and fingers on its wrists.
BodyModel model_with_blend_shapes() {
  BodyModel body = builtin_body();
  torch::manual_seed(2);
  const int64_t V = body.template_vertices.size(0);
  body.name = "smpl";
  for (int wrist : {20, 21}) {
    body.skeleton.names.push_back(wrist == 20 ? "left_hand" : "right_hand");
    body.skeleton.parents.push_back(wrist);
    body.skeleton.offsets =
        torch::cat({body.skeleton.offsets, torch::tensor({{wrist == 20 ? 0.08F : -0.08F, 0.F, 0.F}})});
    body.joint_template =
        torch::cat({body.joint_template, body.joint_template[wrist].unsqueeze(0) + body.skeleton.offsets[-1]});
    body.joint_dirs = torch::cat({body.joint_dirs, body.joint_dirs[wrist].unsqueeze(0)});
  }
  // Half of what the wrists move hangs on the hands.
  const Tensor hands = body.skin_weights.slice(1, 20, 22) / 2;
  body.skin_weights = torch::cat({body.skin_weights.slice(1, 0, 20), hands, hands}, 1);
  // Smooth over the skin, some millimetres in a bent pose.
  body.pose_dirs = body.template_vertices.matmul(torch::randn({3, 3 * 9 * 23})).view({V, 3, 9 * 23}) * 0.004;
  return body;
}

Trajectory random_poses(int64_t frames, uint64_t seed) {
  torch::manual_seed(static_cast<int64_t>(seed));
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.rotations = torch::randn({kStandardJoints, 3}) * 0.3 + torch::randn({frames, kStandardJoints, 3}) * 0.1;
  clip.trans = torch::randn({frames, 3}) * 0.1;
  clip.joints = torch::zeros_like(clip.rotations);
  return trajectory_of(clip);
}

TEST(Depth, SkinIsThatOfTheBody) {
  const Tensor shape = torch::tensor({1.F, -1.F, 0.5F, 0.3F, 2.F});
  for (const BodyModel& body : {builtin_body(), model_with_blend_shapes()}) {
    const Skin own = skin_of(body, shape);
    const FramePose pose = random_poses(1, 3)[0];
    BonesPose bones;
    pose_bones(bones_of(shaped_skeleton(builtin_body(), shape)), pose.local, pose.trans, bones);
    const PosedSkin posed = pose_skin(own, pose, bones);
    Tensor rotations = torch::eye(3).repeat({body.joints(), 1, 1});
    for (int j = 0; j < kStandardJoints; ++j) {
      const Eigen::Matrix3d r = pose.local[static_cast<size_t>(j)].toRotationMatrix();
      for (int i = 0; i < 9; ++i) rotations[j][i / 3][i % 3] = r(i / 3, i % 3);
    }
    const Tensor trans = torch::tensor({pose.trans.x(), pose.trans.y(), pose.trans.z()}).to(torch::kFloat32);
    const Tensor reference = skin(body, shape, rotations, trans);
    const auto at = reference.accessor<float, 2>();
    for (size_t v = 0; v < posed.vertices.size(); v += 7) {
      const auto k = static_cast<int64_t>(v);
      EXPECT_LT((posed.vertices[v] - Vector3d(at[k][0], at[k][1], at[k][2])).norm(), 1e-5) << body.name << " " << v;
    }
  }
}

TEST(Depth, NearestPlacesAreThoseOfTheWholeSurface) {
  const Skin own = skin_of(builtin_body(), {});
  const FramePose pose = random_poses(1, 5)[0];
  BonesPose bones;
  pose_bones(bones_of(builtin_body().skeleton), pose.local, pose.trans, bones);
  const PosedSkin posed = pose_skin(own, pose, bones);
  Tensor skin = torch::empty({own.size(), 3});
  for (int64_t v = 0; v < own.size(); ++v)
    Eigen::Map<Eigen::Vector3f>(skin.data_ptr<float>() + 3 * v) = posed.vertices[static_cast<size_t>(v)].cast<float>();
  Scene scene;
  scene.meshes.push_back({"body", skin, builtin_body().faces, {}});
  std::vector<Vector3d> points;
  for (size_t v = 0; v < posed.vertices.size(); v += 20)
    points.emplace_back(posed.vertices[v] + 0.03 * Vector3d::Random());
  Tensor rows = torch::empty({static_cast<int64_t>(points.size()), 3});
  for (size_t i = 0; i < points.size(); ++i)
    Eigen::Map<Eigen::Vector3f>(rows.data_ptr<float>() + 3 * i) = points[i].cast<float>();
  const Tensor exact = SceneQuery(scene).closest(rows).distances;
  const std::vector<SkinPlace> places = closest_on_skin(own, posed, points);
  for (size_t i = 0; i < points.size(); ++i) {
    const SkinPlace& p = places[i];
    EXPECT_NEAR((p.place - points[i]).norm(), exact[static_cast<int64_t>(i)].item<double>(), 2e-3) << i;
    Vector3d mixed = Vector3d::Zero();
    for (size_t k = 0; k < 3; ++k)
      mixed += p.corners[k] * posed.vertices[static_cast<size_t>(own.faces[static_cast<size_t>(p.face)][k])];
    EXPECT_LT((mixed - p.place).norm(), 1e-9) << i;
  }
}

/// Two frames with points around the skin, both sides of the distance.
Problem depth_problem(const BodyModel& body, const Loss& loss) {
  Problem problem;
  problem.bones = bones_of(builtin_body().skeleton);
  problem.points = joint_points(kStandardJoints);
  problem.start = random_poses(2, 3);
  DepthTerm term;
  term.skin = std::make_shared<const Skin>(skin_of(body, {}));
  term.weight = 500;
  term.loss = loss;
  for (const FramePose& pose : problem.start) {
    BonesPose bones;
    pose_bones(problem.bones, pose.local, pose.trans, bones);
    const PosedSkin posed = pose_skin(*term.skin, pose, bones);
    DepthCloud cloud;
    for (size_t v = 0; v < posed.vertices.size(); v += 60)
      cloud.points.emplace_back(posed.vertices[v] + 0.05 * Vector3d::Random());
    for (int v = 7; v < term.skin->size(); v += 200) cloud.seen.push_back(v);
    cloud.all = cloud.points;
    Tensor rows = torch::empty({static_cast<int64_t>(cloud.all.size()), 3});
    for (size_t i = 0; i < cloud.all.size(); ++i)
      Eigen::Map<Eigen::Vector3f>(rows.data_ptr<float>() + 3 * i) = cloud.all[i].cast<float>();
    cloud.all_points = std::make_shared<const CloudQuery>(rows);
    term.clouds.push_back(std::move(cloud));
  }
  problem.depth = std::make_shared<const DepthTerm>(std::move(term));
  return problem;
}

/// One unknown of a frame a step further.
FramePose stepped_pose(const Unknowns& unknowns, const FramePose& from, int column, double by) {
  FramePose out = from;
  if (column >= unknowns.root && column < unknowns.root + 3) out.trans[column - unknowns.root] += by;
  for (size_t j = 0; j < out.local.size(); ++j) {
    const int first = unknowns.rotations[j][1];
    if (column < first || column >= first + 3) continue;
    Vector3d d = Vector3d::Zero();
    d[column - first] = by;
    out.local[j] = out.local[j] * quaternion_of(d);
  }
  return out;
}

TEST(Depth, JacobianIsThatOfTheResiduals) {
  for (const BodyModel& body : {builtin_body(), model_with_blend_shapes()}) {
    const Problem problem = depth_problem(body, {});
    const Unknowns unknowns = unknowns_of(problem);
    ASSERT_EQ(unknowns.columns[0], 3 + 3 * kStandardJoints) << "all joints move skin";
    const auto residuals_at = [&](const FramePose& pose, std::vector<double>& values) {
      BonesPose bones;
      pose_bones(problem.bones, pose.local, pose.trans, bones);
      std::vector<double> residuals;
      double cost = 0;
      values.clear();
      add_depth_rows(problem, &unknowns, 0, pose, bones, values, residuals, cost);
      double sum = 0;
      for (const double r : residuals) sum += 0.5 * r * r;
      EXPECT_NEAR(sum, cost, 1e-9 * cost);
      return residuals;
    };
    std::vector<double> jacobian, other;
    const std::vector<double> residuals = residuals_at(problem.start[0], jacobian);
    const auto columns = static_cast<size_t>(unknowns.columns[0]);
    ASSERT_EQ(jacobian.size(), residuals.size() * columns);
    constexpr double kStep = 1e-4;  // blend shapes are floats
    int moved = 0, wrong = 0;
    for (size_t c = 0; c < columns; ++c) {
      const auto column = static_cast<int>(c);
      const std::vector<double> up = residuals_at(stepped_pose(unknowns, problem.start[0], column, kStep), other),
                                down = residuals_at(stepped_pose(unknowns, problem.start[0], column, -kStep), other);
      for (size_t i = 0; i < residuals.size(); ++i) {
        const double numeric = (up[i] - down[i]) / (2 * kStep), analytic = jacobian[i * columns + c];
        moved += std::abs(numeric) > 1e-3 ? 1 : 0;
        wrong += std::abs(numeric - analytic) > 1e-4 * (1 + std::abs(numeric)) ? 1 : 0;
      }
    }
    EXPECT_GT(moved, 1000);
    // Where the nearest place changes to another part of the skin there is no derivative.
    EXPECT_LE(wrong, moved / 100) << body.name;
  }
}

TEST(Depth, GradientIsThatOfTheCost) {
  // Blend shapes are floats: a step must be larger there, and crosses more edges of the mesh.
  for (const auto& [body, step, tolerance] :
       {std::tuple(builtin_body(), 1e-6, 1e-4), {model_with_blend_shapes(), 1e-4, 3e-3}}) {
    const Problem problem = depth_problem(body, {Loss::Kind::huber, 0.02});
    const Unknowns unknowns = unknowns_of(problem);
    NormalEquations equations;
    const double cost = linearise(problem, unknowns, problem.start, equations);
    EXPECT_NEAR(cost, cost_of(problem, problem.start), 1e-12 * cost);
    for (int c = 0; c < unknowns.columns[0]; ++c) {
      Trajectory up = problem.start, down = problem.start;
      up[1] = stepped_pose(unknowns, up[1], c, step);
      down[1] = stepped_pose(unknowns, down[1], c, -step);
      const double numeric = (cost_of(problem, up) - cost_of(problem, down)) / (2 * step);
      EXPECT_NEAR(equations.gradients[0][unknowns.columns[0] + c], numeric, tolerance * (1 + std::abs(numeric))) << c;
    }
  }
}

TEST(Depth, SeenVerticesHaveNoSkinBeforeThem) {
  const Skin own = skin_of(builtin_body(), {});
  const FramePose pose{std::vector<Eigen::Quaterniond>(kStandardJoints, Eigen::Quaterniond::Identity()),
                       Vector3d::Zero()};
  BonesPose bones;
  pose_bones(bones_of(builtin_body().skeleton), pose.local, pose.trans, bones);
  const PosedSkin posed = pose_skin(own, pose, bones);
  const std::vector<int> seen = seen_vertices(own, posed, bones.positions[0] + Vector3d(0, 0, 3), 3);
  EXPECT_GT(seen.size(), static_cast<size_t>(own.size()) / 9);
  EXPECT_LT(seen.size(), static_cast<size_t>(own.size()) / 5);
  double back = 0;
  for (const int v : seen) back = std::min(back, posed.vertices[static_cast<size_t>(v)].z() - bones.positions[9].z());
  EXPECT_GT(back, -0.08) << "from the front nobody sees the back";
}

double millimetres(double metres) { return 1e3 * metres; }

/// A line of the table in docs/refinement.md.
void print_row(const char* what, const Clip& truth, const Clip& input, const DepthResult& r) {
  std::printf("%-28s joints %5.1f -> %4.1f mm, jerk %5.2f -> %4.2f of the truth's, points to skin %5.1f -> %4.1f mm\n",
              what, millimetres(distance_between(input, truth)), millimetres(distance_between(r.clip, truth)),
              jerk_of(input) / jerk_of(truth), jerk_of(r.clip) / jerk_of(truth), millimetres(r.distance_before),
              millimetres(r.distance_after));
}

const Vector3d kCamera(2.2, 0.6, 2.2);  // metres from the middle of the motion

TEST(Depth, ARenderedSequenceComesBackFromJitter) {
  const Clip truth = example("walk.npz"), input = jittered(truth, 1);
  const Rendered scene = rendered(truth, kCamera, 0.005);
  DepthOptions options;
  const DepthResult one = refine_to_depth(input, in_memory(scene.clouds), options);
  print_row("walk, one side", truth, input, one);
  options.camera = scene.camera;
  const DepthResult both = refine_to_depth(input, in_memory(scene.clouds), options);
  print_row("walk, both sides", truth, input, both);
  for (const DepthResult* r : {&one, &both}) {
    EXPECT_LT(distance_between(r->clip, truth), 0.5 * distance_between(input, truth));
    EXPECT_LT(jerk_of(r->clip), 0.2 * jerk_of(input));
    EXPECT_LT(r->distance_after, 0.7 * r->distance_before);
    EXPECT_LT(
        (r->clip.joints - joint_positions(truth.skeleton, r->clip.rotations, r->clip.trans)).abs().max().item<double>(),
        1e-4)
        << "bones keep their lengths";
    EXPECT_EQ(r->on_source.frames(), truth.frames());
  }
}

TEST(Depth, WindowsJoinAndSeatsComeBackToo) {
  const Clip truth = slice(example("sit.npz"), 130, 230), input = jittered(truth, 1);
  const Rendered scene = rendered(truth, kCamera, 0.005);
  DepthOptions options;
  options.window = 60;  // 60 frames, then 70 of which 15 are settled
  const DepthResult r = refine_to_depth(input, in_memory(scene.clouds), options);
  print_row("sit, one side", truth, input, r);
  EXPECT_LT(distance_between(r.clip, truth), 0.5 * distance_between(input, truth));
  EXPECT_LT(jerk_of(r.clip), 0.2 * jerk_of(input));
  const Tensor error = (r.clip.joints - truth.joints).norm(2, {2}).mean(1),
               jerk = r.clip.joints.diff(3, 0).norm(2, {2}).mean(1);
  EXPECT_LT(error.slice(0, 35, 55).mean().item<double>(), 1.5 * error.mean().item<double>()) << "at the seam";
  EXPECT_LT(jerk.slice(0, 41, 49).max().item<double>(), 1.5 * jerk.max().item<double>());
}

TEST(Depth, PartsNobodySeesAndPointsOfOtherThingsDoNoHarm) {
  const Clip truth = slice(example("walk.npz"), 0, 40), input = jittered(truth, 1);
  Rendered scene = rendered(truth, kCamera, 0.005);
  // Behind a table no leg is seen; and a sixth of the points is a wall behind.
  for (Tensor& cloud : scene.clouds) {
    const Tensor above = cloud.index({cloud.select(1, 1) > truth.joints.select(1, 0).select(1, 1).min().item<float>()});
    ASSERT_GT(above.size(0), 30);
    cloud = torch::cat({above, above.slice(0, 0, above.size(0) / 5) - torch::tensor({2.F, 0.F, 2.F})});
  }
  const DepthResult r = refine_to_depth(input, in_memory(scene.clouds), {});
  print_row("walk, legs hidden, a wall", truth, input, r);
  const auto error = [&](const Clip& clip, std::vector<int64_t> joints) {
    return (clip.joints - truth.joints).index_select(1, torch::tensor(joints)).norm(2, {2}).mean().item<double>();
  };
  EXPECT_LT(error(r.clip, {9, 12, 15, 16, 17, 18, 19}), 0.6 * error(input, {9, 12, 15, 16, 17, 18, 19}));
  EXPECT_LT(error(r.clip, {4, 5, 7, 8, 10, 11}), error(input, {4, 5, 7, 8, 10, 11}));
}

TEST(Depth, TheStagesAreThePapers) {
  // Nobody knows more than where the root is: with a pose that is right already, the first stage finds it alone.
  const Clip truth = slice(example("walk.npz"), 0, 30);
  const Rendered scene = rendered(truth, kCamera, 0);
  Clip input = truth;
  input.trans = truth.trans + torch::tensor({0.04F, -0.03F, 0.05F});
  input.joints = joint_positions(input.skeleton, input.rotations, input.trans);
  const DepthResult r = refine_to_depth(input, in_memory(scene.clouds), {});
  EXPECT_GT(distance_between(input, truth), 0.06);
  EXPECT_LT(distance_between(r.clip, truth), 0.012);
}

TEST(Depth, RefusesWhatDoesNotFit) {
  const Clip truth = slice(example("walk.npz"), 0, 8);
  const Rendered scene = rendered(truth, kCamera, 0);
  const auto refusal = [&](std::vector<Tensor> clouds, const DepthOptions& options = {}) {
    return refusal_of([&] { refine_to_depth(truth, in_memory(clouds), options); });
  };
  std::vector<Tensor> clouds = scene.clouds;
  clouds.pop_back();
  EXPECT_NE(refusal(clouds).find("7 clouds, but motion has 8 frames"), std::string::npos) << refusal(clouds);
  clouds = scene.clouds;
  clouds[3] = clouds[3] * 1000;
  EXPECT_NE(refusal(clouds).find("frame 3: its points are"), std::string::npos) << refusal(clouds);
  clouds[3] = (scene.clouds[3] - truth.joints[3][9]) * 0.001 + truth.joints[3][9];
  EXPECT_NE(refusal(clouds).find("are they in metres"), std::string::npos) << refusal(clouds);
  DepthOptions options;
  options.camera = Vector3d(0, NAN, 0);
  EXPECT_NE(refusal(scene.clouds, options).find("camera"), std::string::npos);
  options = {};
  options.smooth = -1;
  EXPECT_NE(refusal(scene.clouds, options).find("smooth"), std::string::npos);
}

}  // namespace
}  // namespace inhabit::refine
