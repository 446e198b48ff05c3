// Protects the features: that they are those of the person's own axes, and that the next frame comes back from them.
#include "inhabit/interact/features.h"

#include <gtest/gtest.h>

#include "inhabit/interact/advance.h"
#include "inhabit/interact/recording.h"
#include "inhabit/math/heading.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/mirror.h"
#include "interact/sitter.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

/// A recording with its senses, moved as a whole.
struct Recorded {
  Config config = preset("paper");
  InputLayout in = input_layout(config);
  OutputLayout out = output_layout(config);
  Scene scene;
  Recording recording;
  ChairGrid chair;
  EgoGrid ego{config};
  std::unique_ptr<Surroundings> around;

  explicit Recorded(const GroundTransform& by = {}, bool mirror = false) {
    Sitter sitter;
    Clip clip = transformed(sitter.clip, by);
    scene = seat_scene();
    const torch::Tensor rotation = Recorded::rotation_of(by.yaw);
    for (Mesh& mesh : scene.meshes)
      mesh.vertices = torch::matmul(mesh.vertices, rotation.t()) +
                      torch::tensor({by.shift.x(), by.shift.y(), by.shift.z()}).to(torch::kFloat);
    if (mirror) {
      clip = mirrored(clip);
      scene = mirrored(scene);
    }
    const std::optional<Chair> found = chair_of(clip, scene);
    recording = record(clip, label(clip, found), "sitter");
    chair = sense_chair(*found, config);
    around = std::make_unique<Surroundings>(scene);
  }
  static torch::Tensor rotation_of(double yaw) {
    const auto c = static_cast<float>(std::cos(yaw)), s = static_cast<float>(std::sin(yaw));
    return torch::tensor({c, 0.F, s, 0.F, 1.F, 0.F, -s, 0.F, c}).view({3, 3});
  }
  std::vector<float> input(int64_t t) const { return input(state_at(recording, t)); }
  std::vector<float> input(const State& state) const {
    std::vector<float> x(static_cast<size_t>(in.size), NAN);
    build_input(in, state, {chair, ego, *around}, x.data());
    return x;
  }
  std::vector<float> target(int64_t t) const {
    std::vector<float> y(static_cast<size_t>(out.size), NAN);
    build_target(out, state_at(recording, t), state_at(recording, t + 1), y.data());
    return y;
  }
};

float largest_gap(const std::vector<float>& a, const std::vector<float>& b, const Span& part) {
  float most = 0;
  for (int64_t i = part.first; i < part.end(); ++i)
    most = std::max(most, std::abs(a[static_cast<size_t>(i)] - b[static_cast<size_t>(i)]));
  return most;
}

TEST(InteractFeatures, AreTheSameWhereverTheSceneIsAndHoweverItIsTurned) {
  const Recorded here, there({2.2, {3, 0, -1}});
  for (const int64_t t : {0, 50, 80, 130, 200}) {
    const std::vector<float> a = here.input(t), b = there.input(t);
    for (const Span& part : {here.in.joints, here.in.trajectory, here.in.goals, here.in.hands, here.in.hand_phases})
      EXPECT_LT(largest_gap(a, b, part), 2e-3F) << t << " " << part.first;
    EXPECT_LT(largest_gap(a, b, here.in.chair), 5e-3F) << t;
    EXPECT_LT(largest_gap(a, b, here.in.ego), 0.25F) << t;    // a field of cells of 5 cm
    EXPECT_LT(largest_gap(a, b, here.in.gating), 0.2F) << t;  // degrees
    EXPECT_LT(largest_gap(here.target(t), there.target(t), {0, here.out.size}), 5e-3F) << t;
    for (const float x : a) ASSERT_TRUE(std::isfinite(x));
  }
}

TEST(InteractFeatures, TheChairIsAheadOfWhoWalksBackwardsToItAndTheirVelocityIsTheirOwn) {
  const Recorded r;
  const int64_t t = 45;  // all but turned round: the back goes first
  const std::vector<float> x = r.input(t);
  const float* pelvis = x.data() + r.in.joints.first;
  EXPECT_NEAR(pelvis[0], 0, 1e-4);
  EXPECT_NEAR(pelvis[2], 0, 1e-4);
  EXPECT_NEAR(pelvis[11], -0.96 * std::cos(0.1 * M_PI), 0.05);  // metres a second: 1.6 m in 50 frames
  const float* goal = x.data() + r.in.goals.first + 6 * 9;
  EXPECT_LT(goal[2], -0.4F);
  EXPECT_NEAR(goal[1], 0.45, 1e-4);
  EXPECT_EQ(goal[8], 1);
  const float* present = x.data() + r.in.trajectory.first + 6 * 7;
  EXPECT_NEAR(present[0], 0, 1e-6);
  EXPECT_NEAR(present[3], 1, 1e-5);
}

TEST(InteractFeatures, HandsAreRelativeToTheirContactAndZeroWithoutOne) {
  const Recorded r;
  const int64_t t = 80;
  const State state = state_at(r.recording, t);
  ASSERT_TRUE(state.wanted[0]);
  ASSERT_FALSE(state.wanted[1]);
  const std::vector<float> x = r.input(t);
  const float *right = x.data() + r.in.hands.first, *left = right + 39;
  for (int i = 0; i < 39; ++i) EXPECT_EQ(right[i], 0);
  for (int k = 0; k < 13; ++k) {
    const Vector3f apart = state.key(k).hand[0] - state.contact[0];
    const Vector3f seen(left[3 * k], left[3 * k + 1], left[3 * k + 2]);
    EXPECT_LT((state.now().root.turned_out(seen) - apart).norm(), 1e-5F) << k;
    EXPECT_EQ(x[static_cast<size_t>(r.in.hand_phases.first + 2 * k)], 0);
    EXPECT_FLOAT_EQ(x[static_cast<size_t>(r.in.hand_phases.first + 2 * k + 1)], state.key(k).hand_phase[0]);
  }
}

TEST(InteractFeatures, GatingIsWeightsTimesPhaseVectors) {
  const Recorded r;
  State state = state_at(r.recording, 30);
  Sample& s = state.key(4);
  s.phase = 2.25F;  // a quarter of a cycle: (1, 0)
  s.action = {0, 0.75F, 0.25F};
  s.goal_action = {0, 0, 1};
  s.root = {{1, 2}, {0, 1}};
  s.goal = {1, 0.4F, 5};
  s.goal_facing = {1, 0};
  const std::vector<float> x = r.input(state);
  const float* g = x.data() + r.in.gating.first + 4 * 24;
  const std::vector<float> expected = {-1, 0, 0.5F, 0, -0.5F, 0, -1, 0, -3, 0, -90, 0,
                                       -1, 0, -3,   0, -90,   0, 1,  0, 3,  0, 90,  0};
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(g[i], expected[i], 1e-4) << i;
}

TEST(InteractFeatures, TheTargetMadeTheNextFrameIsTheNextFrame) {
  const Recorded r({-0.9, {1, 0, 2}});
  for (const int64_t t : {20, 70, 100, 170, 190}) {
    State state = state_at(r.recording, t);
    const State next = state_at(r.recording, t + 1);
    const std::vector<float> y = r.target(t);
    apply_output(r.out, y.data(), {0, 0, 0}, r.config.rate, state);
    for (size_t j = 0; j < kJoints; ++j) {
      EXPECT_LT((state.position[j] - next.position[j]).norm(), 1e-4F) << t << " " << j;
      EXPECT_LT((state.rotation[j] - next.rotation[j]).norm(), 1e-4F) << t << " " << j;
      EXPECT_LT((state.velocity[j] - next.velocity[j]).norm(), 1e-3F) << t << " " << j;
      EXPECT_LT((state.position_from_ahead[j] - next.position[j]).norm(), 1e-3F) << t << " " << j;
    }
    for (int k = 0; k < kKeys; ++k) {
      EXPECT_LT((state.key(k).root.position - next.key(k).root.position).norm(), 1e-3F) << t << " " << k;
      EXPECT_GT(state.key(k).root.facing.dot(next.key(k).root.facing), 0.9999F) << t << " " << k;
      const float phase = state.key(k).phase - next.key(k).phase;
      EXPECT_NEAR(phase, std::round(phase), 1e-3) << t << " " << k;
      for (size_t a = 0; a < kActions; ++a) EXPECT_NEAR(state.key(k).action[a], next.key(k).action[a], 1e-3);
    }
    EXPECT_EQ(state.touching, next.touching);
  }
}

TEST(InteractFeatures, GoalsMoveOnAndTakeThePredictionByTheirWeight) {
  const Recorded r;
  const State before = state_at(r.recording, 40);
  std::vector<float> y = r.target(40);
  for (int k = 0; k < kKeys; ++k) y[static_cast<size_t>(r.out.goals.first + 9 * k)] += 1;  // a metre to the left
  State kept = before, drawn = before;
  apply_output(r.out, y.data(), {0, 0, 0}, 30, kept);
  apply_output(r.out, y.data(), {0, 0, 0.25}, 30, drawn);
  const Vector3f left = before.now().root.turned_out(Vector3f(1, 0, 0));
  EXPECT_LT((kept.key(9).goal - before.key(9).goal).norm(), 1e-5F);
  EXPECT_LT((drawn.key(9).goal - before.key(9).goal - 0.25F * left).norm(), 1e-3F);
  EXPECT_LT((drawn.key(3).goal - before.key(3).goal).norm(), 1e-5F);  // the past is past
}

TEST(InteractFeatures, NearItsGoalTheRootTakesTheGoalCentricPrediction) {
  const Recorded r;
  State state = state_at(r.recording, 110);
  std::vector<float> y = r.target(110);
  for (int k = 0; k < kFuturePoints; ++k) y[static_cast<size_t>(r.out.trajectory.first + 7 * k)] += 0.05F;
  const State next = state_at(r.recording, 111);
  apply_output(r.out, y.data(), {0, 0, 0}, 30, state);
  for (int k = kPastKeys + 1; k < kKeys; ++k) {
    // 5 cm off: ((k - 6) / 7)^(100 x 0.05^2) of the distance back.
    const double weight = std::pow((k - 6) / 7.0, 0.25);
    EXPECT_NEAR((state.key(k).root.position - next.key(k).root.position).norm(), 0.05 * (1 - weight), 2e-3) << k;
  }
  EXPECT_NEAR((state.now().root.position - next.now().root.position).norm(), 0.05, 1e-4);
}

TEST(InteractFeatures, TheControlSignalIsTheStraightLineAndItsTargetTheHandsTrajectory) {
  const Recorded r({0.7, {0, 0, 0}});
  const State now = state_at(r.recording, 80), next = state_at(r.recording, 81);
  std::vector<float> pose(kControlPose), control(kControlSize), target(kControlSize);
  build_control_input(now, pose.data(), control.data());
  build_control_target(now, next, target.data());
  const Vector3f whole = now.now().root.turned_in(Vector3f(now.now().hand[0] - now.contact[0]));
  for (int k = 0; k < 7; ++k) {
    const float* p = control.data() + 21 + 3 * k;  // the left hand comes second
    EXPECT_LT((Vector3f(p[0], p[1], p[2]) - whole * (6 - k) / 6.F).norm(), 1e-5F) << k;
    EXPECT_EQ(control[static_cast<size_t>(3 * k)], 0);
    EXPECT_FLOAT_EQ(control[static_cast<size_t>(49 + k)], now.key(6 + k).hand_phase[0]);
    EXPECT_FLOAT_EQ(target[static_cast<size_t>(49 + k)], next.key(6 + k).hand_phase[0]);
  }
  State after = next;
  for (int i = kNow + 1; i < kSamples; ++i) after.samples[static_cast<size_t>(i)].hand[0] = Vector3f::Zero();
  apply_control(target.data(), now.now().root, after);
  for (int k = 7; k < kKeys; ++k) {
    EXPECT_LT((after.key(k).hand[0] - next.key(k).hand[0]).norm(), 1e-5F) << k;
    EXPECT_NEAR(after.key(k).hand_phase[0], next.key(k).hand_phase[0], 1e-6) << k;
  }
}

TEST(InteractFeatures, AGivenContactIsPlannedAlongALine) {
  const Recorded r;
  State state = state_at(r.recording, 30);
  const Vector3f from = state.now().hand[1], point(-0.3F, 0.5F, 0.1F);
  give_contact(state, 1, point);
  EXPECT_TRUE(state.wanted[1]);
  EXPECT_LT((state.key(9).hand[1] - 0.5F * (from + point)).norm(), 1e-5F);
  EXPECT_FLOAT_EQ(state.key(9).hand_phase[1], 0.5F);
  EXPECT_LT((state.key(12).hand[1] - point).norm(), 1e-5F);
  const Vector3f by(0.1F, 0, 0.05F);
  move_contact(state, 1, point + by);
  EXPECT_LT((state.key(6).hand[1] - from).norm(), 1e-6F) << "the hand is where it is";
  EXPECT_LT((state.key(9).hand[1] - 0.5F * (from + point + by)).norm(), 1e-5F);
  EXPECT_LT((state.key(12).hand[1] - point - by).norm(), 1e-5F);
  drop_contact(state, 1);
  const std::vector<float> x = r.input(state);
  for (int64_t i = r.in.hands.first; i < r.in.hands.first + 39; ++i) EXPECT_EQ(x[static_cast<size_t>(i)], 0);
}

TEST(InteractFeatures, AMirroredRecordingHasMirroredFeatures) {
  const Recorded plain, image({}, true);
  const std::vector<float> a = plain.input(80), b = image.input(80);
  const auto joint = [&](const std::vector<float>& x, int j) {
    return Vector3f(x[static_cast<size_t>(12 * j)], x[static_cast<size_t>(12 * j + 1)],
                    x[static_cast<size_t>(12 * j + 2)]);
  };
  for (const auto& [l, right] : {std::pair(20, 21), {1, 2}, {10, 11}, {15, 15}}) {
    EXPECT_LT((joint(a, l) - Vector3f(-1, 1, 1).cwiseProduct(joint(b, right))).norm(), 1e-4F) << l;
    EXPECT_LT((joint(a, right) - Vector3f(-1, 1, 1).cwiseProduct(joint(b, l))).norm(), 1e-4F) << l;
  }
  // The image of a scene and a scene's image are the same surroundings.
  const Surroundings shared = plain.around->mirrored();
  std::vector<float> own(1408), image_of(1408);
  const Place root = state_at(image.recording, 80).now().root;
  image.ego.sense(*image.around, root, own.data());
  image.ego.sense(shared, root, image_of.data());
  for (size_t i = 0; i < own.size(); ++i) EXPECT_NEAR(own[i], image_of[i], 0.1) << i;
  EXPECT_GT(*std::max_element(own.begin(), own.end()), 0.5F);
  for (int i = 0; i < 39; ++i)  // the left hand's trajectory has become the right one's
    EXPECT_NEAR(a[static_cast<size_t>(plain.in.hands.first + 39 + i)],
                (i % 3 == 0 ? -1 : 1) * b[static_cast<size_t>(plain.in.hands.first + i)], 1e-4);
}

TEST(InteractFeatures, WhoStandsStillHasStoodThereAndWill) {
  const Recorded r({0.4, {1, 0, 1}});
  const State some = state_at(r.recording, 30), still = standing_state(some.position, some.rotation);
  EXPECT_LT((still.now().root.position - some.now().root.position).norm(), 1e-6F);
  EXPECT_GT(still.now().root.facing.dot(some.now().root.facing), 0.99999F);
  const std::vector<float> x = r.input(still);
  for (int k = 0; k < kKeys; ++k) {
    EXPECT_NEAR(x[static_cast<size_t>(r.in.trajectory.first + 7 * k)], 0, 1e-6);
    EXPECT_NEAR(x[static_cast<size_t>(r.in.trajectory.first + 7 * k + 4)], 1, 1e-6);
  }
}

}  // namespace
}  // namespace inhabit::interact
