// Protects the running of human-chair interaction as far as no training is needed for it: bones keep their lengths, the
// same input gives the same motion, contacts are put on the chair or refused with the reason, and the person of any
// floor height is the same person. Of the shipped weights: who sits stays seated, who stands is alive, who walks goes
// on.
#include "inhabit/interact/chair_interactor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "at_once.h"
#include "chair_scene.h"
#include "inhabit/interact/contact_area.h"
#include "inhabit/interact/live_person.h"
#include "inhabit/interact/standing_place.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/math/heading.h"
#include "inhabit/scene/query.h"
#include "largest.h"
#include "refusal_of.h"
#include "small_networks.h"

namespace inhabit::interact {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using torch::Tensor;

Scene armchair_scene() {
  std::mt19937_64 random(5);
  Furniture chair = make_armchair(random);
  chair.place(0.5, -0.4, 0.7);
  return scene_of({chair});
}

/// Networks whose outputs are small, so that a person who is moved by them stays where they are.
const ChairInteractor& interactor() {
  static const ChairInteractor it = [] {
    Networks networks = untrained_networks(small_interact_config());
    networks.output_scale.mean.zero_();
    networks.output_scale.deviation.fill_(0.05);
    return ChairInteractor(networks);
  }();
  return it;
}

Options on_chair(HandContacts contacts) {
  Options options;
  options.chair = "armchair_0";
  options.contacts = {contacts};
  options.seconds = 1;
  return options;
}

TEST(ChairInteractor, BonesKeepTheirLengthsAndTheSameIsTheSame) {
  const Scene scene = armchair_scene();
  const Clip start = standing_clip({1.9, 1.1}, 2);
  const Chair chair = find_chair(scene, "armchair_0");
  const Options options = on_chair({contact_on(chair, "armrest", 0), std::nullopt});
  const Result result = interactor().run(start, scene, options);
  ASSERT_EQ(result.motion.frames(), 30);
  EXPECT_TRUE(result.motion.joints.isfinite().all().item<bool>());
  EXPECT_LT(largest(result.motion.joints[0] - start.joints[0]), 1e-5) << "it begins with the pose that was given";
  const auto& parents = result.motion.skeleton.parents;
  for (size_t j = 1; j < parents.size(); ++j) {
    const Tensor bone =
        (result.motion.joints.select(1, static_cast<int64_t>(j)) - result.motion.joints.select(1, parents[j]))
            .norm(2, {1});
    EXPECT_LT(largest(bone - bone[0]), 1e-4) << j;
  }
  EXPECT_EQ(result.motion.action.size(0), 30);
  Options counted = options;
  int64_t told = 0;
  counted.progress = [&](int64_t done, int64_t all) {
    EXPECT_EQ(done, ++told);
    EXPECT_EQ(all, 30);
  };
  interactor().run(start, scene, counted);
  EXPECT_EQ(told, 30) << "frames";
  EXPECT_TRUE(torch::equal(interactor().run(start, scene, options).motion.joints, result.motion.joints));
}

TEST(ChairInteractor, SomebodySeatedStaysSeatedForMinutes) {
  const auto shipped = ChairInteractor::load(INHABIT_SOURCE_DIR "/models/interact-compact.safetensors");
  const Chair chair = find_chair(armchair_scene(), "armchair_0");
  for (const double hold : {1.0, std::numeric_limits<double>::infinity()}) {
    Options options = on_chair({});
    if (hold > 1) options.contacts = {{contact_on(chair, "armrest", 0), contact_on(chair, "armrest", 1)}};
    options.hold = hold;
    options.seconds = 150;
    options.raw = options.standard = true;
    const Result result = shipped.run({}, armchair_scene(), options);
    ASSERT_TRUE(result.seated && *result.seated < 12 * 30);
    const Tensor height = result.motion.joints.select(1, 0).select(1, 1).slice(0, *result.seated + 30);
    EXPECT_LT((height.max() - height.min()).item<double>(), 0.08) << "nobody rises unasked, hold " << hold;
  }
}

// The networks' first pose is their own; a foot that swings is not to jump to it.
TEST(ChairInteractor, WhoWalksGoesOnWithoutAJump) {
  const auto shipped = ChairInteractor::load(INHABIT_SOURCE_DIR "/models/interact-compact.safetensors");
  const Clip walk = read_clip(INHABIT_SOURCE_DIR "/examples/data/walk.npz");
  Options options;
  options.seconds = 0.5;
  options.standard = true;
  const auto most = [](const Tensor& joints) {  // metres that an ankle moves from one frame to the next
    const Tensor ankles = joints.slice(1, 7, 9);
    return (ankles.slice(0, 1) - ankles.slice(0, 0, -1)).norm(2, 2).max().item<double>();
  };
  const double before = most(walk.joints);
  const Scene room = read_scene_file(INHABIT_SOURCE_DIR "/examples/data/walk_room.glb").scene;
  for (const int64_t frames : {90, 84, 78, 72, 66})
    EXPECT_LT(most(shipped.run(slice(walk, 0, frames), room, options).motion.joints), 1.25 * before) << frames;
  options.raw = true;
  EXPECT_GT(most(shipped.run(walk, room, options).motion.joints), 1.25 * before) << "it is the fade that does it";
}

// Who stands is no statue, and who has walked to their place does not shuffle off again.
TEST(ChairInteractor, WhoStandsIsAlive) {
  const auto shipped = ChairInteractor::load(INHABIT_SOURCE_DIR "/models/interact-compact.safetensors");
  constexpr int kSeconds = 6;
  const auto head_moves = [](const Tensor& joints) {  // metres a second in the mean
    const Tensor head = joints.select(1, 15).slice(0, -30 * kSeconds);
    return (head.slice(0, 1) - head.slice(0, 0, -1)).norm(2, 1).mean().item<double>() * 30;
  };
  LivePerson waits(shipped.engine(), standing_clip({0, 0}, 0), 1);
  std::vector<SettledPose> poses;
  for (int t = 0; t < 30 * kSeconds; ++t) {
    waits.step();
    poses.push_back(waits.pose());
  }
  EXPECT_GT(head_moves(clip_of(poses, standing_clip({0, 0}, 0), 30).joints), 0.004) << "before an order";
  Options options = on_chair({});
  options.seconds = 32;
  options.raw = options.standard = true;
  for (const auto& place : {Eigen::Vector3d(2.2, 0.9, 1), Eigen::Vector3d(0.2, 2, -2)}) {
    options.then_walk = place;
    const Result result = shipped.run({}, armchair_scene(), options);
    EXPECT_LT(result.walk_error.value(), 0.5) << place.transpose();
    EXPECT_GT(head_moves(result.motion.joints), 0.004) << place.transpose();
    const Tensor root = result.motion.joints.select(1, 0).slice(0, -30 * kSeconds);
    EXPECT_LT((root[-1] - root[0]).norm().item<double>(), 0.4) << "they stay";
  }
}

TEST(ChairInteractor, SamplesAreRunsOfTheNextSeedsOnOneChair) {
  const Scene scene = armchair_scene();
  const Clip start = standing_clip({1.9, 1.1}, 2);
  Options options = on_chair({});
  options.contacts.clear();
  options.draw_contacts = true;
  options.force = true;  // contacts of no training may be out of reach
  options.seed = 4;
  options.seconds = 0.5;
  int64_t told = 0;
  options.progress = [&](int64_t done, int64_t all) {
    EXPECT_EQ(done, ++told);
    EXPECT_EQ(all, 30) << "frames of both";
  };
  const std::vector<Result> samples = interactor().run_samples(start, scene, options, 2);
  EXPECT_EQ(told, 30);
  options.progress = {};
  ASSERT_EQ(samples.size(), 2U);
  for (const Result& sample : samples) {
    const Result alone = interactor().run(start, scene, options);
    EXPECT_TRUE(torch::equal(sample.motion.joints, alone.motion.joints)) << options.seed;
    EXPECT_EQ(sample.contacts, alone.contacts) << options.seed;
    ++options.seed;
  }
  for (const int64_t count : {-1, 0, 1001})
    EXPECT_EQ(refusal_of([&] { interactor().run_samples(start, scene, options, count); }),
              "samples: is not from 1 to 1000");
}

// Another seat may be nearer to the place before the chair than the chair itself.
TEST(ChairInteractor, WhoIsNowhereIsPlacedBeforeTheSeatNearestToTheOrigin) {
  std::mt19937_64 random(5);
  Furniture armchair = make_armchair(random), stool = make_stool(random, 0.45);
  const Chair alone = find_chair(scene_of({armchair}), "armchair_0");
  const Eigen::Vector2d ahead = on_ground(alone.seat()) + 3.2 * ahead_of(alone.heading());
  stool.place(ahead.x(), ahead.y(), 0);
  const Scene scene = scene_of({armchair, stool});
  Options options;
  options.seconds = 0.2;
  const Clip placed = standing_before(find_chair(scene, "armchair_0"), scene);
  ASSERT_EQ(interactor().chair_of(placed, scene, options).name, "stool_0");
  EXPECT_EQ(interactor().chair_of({}, scene, options).name, "armchair_0");
  const Result result = interactor().run({}, scene, options);
  EXPECT_EQ(result.chair.name, "armchair_0");
  EXPECT_LT(largest(result.motion.joints[0] - placed.joints[0]), 1e-4);
  options.contacts = {{std::nullopt, contact_on(alone, "front", 1)}};
  EXPECT_EQ(interactor().chair_of({}, scene, options).name, "armchair_0");
}

TEST(ChairInteractor, ServesSeveralThreadsAtOnce) {
  const Scene scene = armchair_scene();
  const Clip start = standing_clip({1.9, 1.1}, 2);
  const Options options = on_chair({});
  const auto run = [&] { return interactor().run(start, scene, options).motion.joints; };
  const Tensor expected = run();
  for (const Tensor& found : at_once(4, run)) EXPECT_LT(largest_difference(found, expected), 1e-5);
}

TEST(ChairInteractor, AFloorOfAnyHeightIsTheFloor) {
  const Scene scene = armchair_scene();
  Scene raised = scene;
  const Tensor up = torch::tensor({0.F, 1.5F, 0.F});
  for (Mesh& mesh : raised.meshes) mesh.vertices = mesh.vertices + up;
  const Clip start = standing_clip({1.9, 1.1}, 2);
  Clip high = start;
  high.trans = high.trans + up;
  high.joints = high.joints + up;
  Options options = on_chair({});
  options.seconds = 0.2;  // rounding grows with time
  options.raw = true;
  const Tensor low = interactor().run(start, scene, options).motion.joints,
               lifted = interactor().run(high, raised, options).motion.joints;
  EXPECT_LT(largest(lifted - up - low), 2e-3);
}

TEST(ChairInteractor, ContactsAreOnTheChairOrRefused) {
  const Scene scene = armchair_scene();
  const Clip start = standing_clip({1.9, 1.1}, 2);
  const Chair chair = find_chair(scene, "armchair_0");
  const Vector3d arm = contact_on(chair, "armrest", 1);
  const Result result = interactor().run(start, scene, on_chair({std::nullopt, arm + Vector3d(0, 0.05, 0)}));
  EXPECT_LT((*result.contacts[0][1] - arm).norm(), 0.02) << "moved to the surface";
  EXPECT_FALSE(result.contacts[0][0]);
  const auto refused = [&](const Options& options) {
    return refusal_of([&] { interactor().run(start, scene, options); });
  };
  EXPECT_THAT(refused(on_chair({arm + Vector3d(0, 0.4, 0), std::nullopt})),
              testing::AllOf(HasSubstr("left contact"), HasSubstr("in the air")));
  Options none = on_chair({});
  none.chair = "throne";
  EXPECT_THAT(refused(none), testing::AllOf(HasSubstr("throne"), HasSubstr("armchair_0")));
  Options endless = on_chair({});
  endless.seconds = 0;
  EXPECT_THAT(refused(endless), HasSubstr("seconds"));
  EXPECT_THAT(refusal_of([&] {
                interactor().run(standing_clip({0.5, -0.4}, 0), scene, on_chair({}));
              }),
              HasSubstr("inside"));
}

TEST(ChairInteractor, ContactNetsContactsAreOnTheSurface) {
  const Chair chair = find_chair(armchair_scene(), "armchair_0");
  const auto drawn = interactor().draw_contacts(chair, 20, 3);
  ASSERT_EQ(drawn.size(), 20);
  const SceneQuery surface(Scene{chair.name, {chair.mesh}, {}});
  for (const HandContacts& contacts : drawn)
    for (const auto& c : contacts) {
      if (!c) continue;
      const Tensor point = torch::tensor({{c->x(), c->y(), c->z()}}, torch::kFloat32);
      EXPECT_LT(surface.closest(point).distances.item<double>(), 1e-3);
    }
  EXPECT_EQ(drawn[4], interactor().draw_contacts(chair, 5, 3)[4]) << "a draw depends on its number alone";
  for (const int64_t count : {-1, 100'001})
    EXPECT_EQ(refusal_of([&] { interactor().draw_contacts(chair, count, 3); }), "count: is not from 0 to 100000");
}

TEST(ContactArea, PartsOfAnArmchairAreWhereTheyAre) {
  const Chair chair = find_chair(armchair_scene(), "armchair_0");
  const auto in_seat = [&](const Vector3d& p) -> Vector3d { return chair.frame.inverse() * p; };
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1 : -1;
    const Vector3d arm = in_seat(contact_on(chair, "armrest", side)), front = in_seat(contact_on(chair, "front", side));
    EXPECT_GT(sign * arm.x(), 0.15);
    EXPECT_GT(arm.y(), chair.seat_height + 0.08);
    EXPECT_GT(front.z(), 0.1);
    EXPECT_NEAR(front.y(), chair.seat_height, 0.06);
    EXPECT_THAT(refusal_of([&] { contact_on(chair, "back", side); }), HasSubstr("no back within reach"))
        << "between arm rests only its top is left, behind the shoulders";
  }
  EXPECT_THAT(refusal_of([&] { contact_on(chair, "lid", 0); }), HasSubstr("armrest"));
  std::mt19937_64 random(5);
  Furniture stool = make_stool(random);
  const Chair plain = find_chair(scene_of({stool}), "stool_0");
  EXPECT_THAT(refusal_of([&] { contact_on(plain, "armrest", 0); }), HasSubstr("no armrest on the left"));
}

TEST(ContactArea, HandsGoWhereThoseOfTheDataDo) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 20; ++i) {
    const Chair chair = find_chair(scene_of({make_chair(random)}), "chair_0");
    EXPECT_THAT(refusal_of([&] { contact_on(chair, "armrest", i % 2); }), HasSubstr("no armrest"))
        << "low back rests are none either";
  }
  const Chair straight = find_chair(scene_of({make_chair(random)}), "chair_0");
  Furniture wide = make_sofa(random, 3);
  const Chair sofa = find_chair(scene_of({wide}), "sofa_0");
  for (int side = 0; side < 2; ++side) {
    const double sign = side == 0 ? 1 : -1;
    const Vector3d back = straight.frame.inverse() * contact_on(straight, "back", side);
    EXPECT_NEAR(back.y(), straight.seat_height + 0.18, 0.05) << "the side of the back rest, not its top";
    EXPECT_GT(sign * back.x(), 0.1);
    EXPECT_LT(back.z(), -0.08);
    const Vector3d beside = sofa.frame.inverse() * contact_on(sofa, "side", side);
    EXPECT_NEAR(sign * beside.x(), 0.3, 0.02) << "beside the hip, not at the end of the sofa";
    EXPECT_THAT(refusal_of([&] { contact_on(sofa, "back", side); }), HasSubstr("no back within reach"));
  }
}

TEST(ContactArea, APlaceIsNowhereAPartOrAPoint) {
  const Chair chair = find_chair(armchair_scene(), "armchair_0");
  EXPECT_FALSE(contact_at(chair, {}, 0));
  EXPECT_FALSE(contact_at(chair, "none", 0));
  EXPECT_EQ(contact_at(chair, "front", 1), contact_on(chair, "front", 1));
  EXPECT_EQ(contact_at(chair, Vector3d(1, 2, 3), 1), Vector3d(1, 2, 3));
  EXPECT_THAT(refusal_of([&] { contact_at(chair, "lid", 0); }), HasSubstr("'lid' is no part of a chair"));
}

}  // namespace
}  // namespace inhabit::interact
