// Protects what a page's person does with what it is told, without any connection: contacts on the surface or refused
// with the reason, motions carried out and left again, poses as they are sent and recorded.
#include "inhabit/serve/character.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "client.h"
#include "inhabit/error.h"
#include "inhabit/interact/contact_area.h"
#include "inhabit/io/files.h"
#include "inhabit/math/heading.h"
#include "inhabit/serve/poses.h"
#include "inhabit/serve/recording_file.h"
#include "largest.h"
#include "refusal_of.h"
#include "small_world.h"
#include "temp_folder.h"

namespace inhabit::serve {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::HasSubstr;

const Seat& armchair() { return small_world()->seat("armchair_0"); }

TEST(World, PeopleBeginWhereThereIsRoom) {
  const auto world = small_world();
  ASSERT_EQ(world->seats.size(), 1);
  const Vector2d place(world->person.joints[0][0][0].item<double>(), world->person.joints[0][0][2].item<double>());
  EXPECT_TRUE(world->free_at(place));
  EXPECT_FALSE(world->free_at({0.5, -0.4})) << "the armchair is there";
  EXPECT_FALSE(world->free_at({500, 0})) << "outside";
  EXPECT_NEAR(world->person.joints[0].select(1, 1).min().item<double>(), 0.05, 0.06) << "on the floor";
}

TEST(World, AFloorOfAnyHeightIsTheFloor) {
  Scene raised = small_world()->scene;
  for (Mesh& mesh : raised.meshes) mesh.vertices = mesh.vertices + torch::tensor({0.F, 1.7F, 0.F});
  const auto world =
      make_world(raised, interact::ChairInteractor(interact::untrained_networks(interact::small_interact_config())));
  EXPECT_NEAR(world->seats[0].chair.seat().y(), armchair().chair.seat().y(), 1e-4);
}

TEST(World, TheDefaultRoomHasFourSeats) {
  const auto world = make_world(
      default_room(), interact::ChairInteractor(interact::untrained_networks(interact::small_interact_config())));
  EXPECT_EQ(world->seats.size(), 4);
}

TEST(Character, ContactsAreOnTheSurfaceOrRefused) {
  Character person(small_world());
  const Vector3d arm = interact::contact_on(armchair().chair, "armrest", 0);
  const auto touch = [&](int hand, const Vector3d& at, const std::string& chair = "armchair_0") {
    return refusal_of([&] { person.touch({hand, at, chair}); });
  };
  EXPECT_THAT(refusal_of([&] { person.touch({0, arm, ""}); }), HasSubstr("needs a chair"));
  EXPECT_THAT(touch(0, arm + Vector3d(0, 0.3, 0)), testing::AllOf(HasSubstr("left contact"), HasSubstr("in the air")));
  EXPECT_THAT(touch(1, arm, "throne"), testing::AllOf(HasSubstr("throne"), HasSubstr("armchair_0")));
  // A foot of the chair, from its lowest vertices.
  const torch::Tensor& v = armchair().chair.mesh.vertices;
  const torch::Tensor low = v[v.select(1, 1).argmin().item<int64_t>()];
  EXPECT_THAT(touch(0, {low[0].item<double>(), low[1].item<double>(), low[2].item<double>()}),
              HasSubstr("out of the arm's reach"));
  EXPECT_TRUE(person.contacts().chair.empty()) << "what was refused changed nothing";
  person.touch({0, arm + Vector3d(0, 0.04, 0), "armchair_0"});
  EXPECT_EQ(person.contacts().chair, "armchair_0") << "the person goes to the chair of the contact";
  ASSERT_TRUE(person.contacts().at[0]);
  EXPECT_LT((*person.contacts().at[0] - arm).norm(), 0.02) << "moved to the surface";
  for (int i = 0; i < 10; ++i) person.step();
  EXPECT_GE(person.status().distance[0], 0) << "the hand's distance to it is told";
  EXPECT_LT(person.status().distance[1], 0);
  person.touch({0, std::nullopt, ""});
  EXPECT_FALSE(person.contacts().at[0]);
}

TEST(Character, IsToldWhatCannotBeDone) {
  Character person(small_world());
  EXPECT_THAT(refusal_of([&] { person.walk({0.5, -0.4}); }), HasSubstr("nobody can stand there"));
  EXPECT_THAT(refusal_of([&] { person.walk({900, 0}); }), HasSubstr("outside"));
  EXPECT_THAT(refusal_of([&] { person.sit("table"); }), HasSubstr("armchair_0"));
  EXPECT_THAT(refusal_of([&] { person.stand(); }), HasSubstr("nobody sits"));
  EXPECT_THAT(refusal_of([&] { person.draw(); }), HasSubstr("chair"));
  EXPECT_THAT(refusal_of([&] { pose_at(*small_world(), "handstand", {0, 2}, 0); }), HasSubstr("crouching"));
  EXPECT_THAT(refusal_of([&] { pose_at(*small_world(), "standing", {0.5, -0.4}, 0); }), HasSubstr("not free"));
}

TEST(Character, EveryOrderMayComeAtAnyTime) {
  Character person(small_world());
  const Clip motion =
      clip_of(std::vector<Frame>(20, pose_at(*small_world(), "crouching", {-1, 2}, 1)), small_world()->person);
  std::mt19937_64 random(3);
  for (int i = 0; i < 400; ++i) {
    try {
      switch (random() % 8) {
        case 0:
          person.walk({static_cast<double>(random() % 5) - 2, static_cast<double>(random() % 5) - 2});
          break;
        case 1:
          person.sit("armchair_0");
          break;
        case 2:
          person.draw();
          break;
        case 3:
          person.stand();
          break;
        case 4:
          person.play(motion);
          break;
        case 5:
          person.touch({0, interact::contact_on(armchair().chair, "armrest", 0), ""});
          break;
        case 6:
          person.restart();
          break;
        default:
          break;
      }
    } catch (const Error&) {  // said, and nothing else
    }
    for (int k = 0; k < 3; ++k) person.step();
    ASSERT_TRUE(person.frame().trans.allFinite());
    for (const Eigen::Quaternionf& q : person.frame().rotation) ASSERT_NEAR(q.norm(), 1, 1e-3);
  }
  EXPECT_EQ(person.status().index, 1200);
}

TEST(Character, CarriesOutAMotionAndHoldsItsEnd) {
  Character person(small_world());
  person.step();
  const Frame end = pose_at(*small_world(), "crouching", {-1, 2}, 1);
  person.play(clip_of(std::vector<Frame>(30, end), small_world()->person));
  for (int i = 0; i < 30; ++i) {
    EXPECT_TRUE(person.status().filling) << i;
    person.step();
  }
  for (int i = 0; i < 5; ++i) person.step();
  EXPECT_FALSE(person.status().filling);
  EXPECT_LT((person.frame().trans - end.trans).norm(), 1e-4) << "held";
  person.stand();
  person.step();
  EXPECT_GT((person.frame().trans - end.trans).norm(), 1e-5) << "given back to the networks";
}

TEST(Character, RemembersTheLastSecond) {
  Character person(small_world());
  EXPECT_EQ(person.recent(1).frames(), 30) << "held where there was less";
  for (int i = 0; i < 100; ++i) person.step();
  const Clip recent = person.recent(2);
  EXPECT_EQ(recent.frames(), 60);
  EXPECT_LT(
      (recent.trans[-1] - torch::tensor({person.frame().trans.x(), person.frame().trans.y(), person.frame().trans.z()}))
          .norm()
          .item<double>(),
      1e-5);
}

TEST(Poses, StandOnTheFloorAndDiffer) {
  const auto world = small_world();
  std::vector<Frame> frames;
  for (const std::string& name : pose_names()) {
    frames.push_back(pose_at(*world, name, {-1.5, 1}, 0.4));
    const Clip clip = clip_of({frames.back()}, world->person);
    EXPECT_NEAR(clip.joints[0].select(1, 1).min().item<double>(), 0.03, 0.04) << name;
    const torch::Tensor across = clip.joints[0][1] - clip.joints[0][2];  // of the hips
    EXPECT_NEAR(std::atan2(-across[2].item<double>(), across[0].item<double>()), 0.4, 0.05) << name;
  }
  EXPECT_LT(frames[1].trans.y(), frames[0].trans.y() - 0.2) << "crouching is lower";
}

TEST(Frames, AreSentAsTheyAre) {
  const Frame frame = pose_at(*small_world(), "step", {-1.5, 1}, 0.4);
  Status status;
  status.seated = true;
  status.index = 1234;
  status.number = 77;
  status.distance = {0.25F, -1};
  const std::string bytes = pose_bytes(frame, status);
  ASSERT_EQ(bytes.size(), 208);
  EXPECT_EQ(bytes[0], 1);
  EXPECT_EQ(bytes[1], 1);
  EXPECT_EQ(number_at<uint32_t>(bytes, 4), 1234);
  EXPECT_EQ(number_at<uint32_t>(bytes, 8), 77);
  EXPECT_EQ(number_at<float>(bytes, 12), 0.25F);
  EXPECT_EQ(number_at<float>(bytes, 20), frame.trans.x());
  for (size_t j = 0; j < 22; ++j)
    for (size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(number_at<int16_t>(bytes, 32 + 8 * j + 2 * k) / 32767.0,
                  static_cast<double>(frame.rotation[j].coeffs()[static_cast<Eigen::Index>(k)]), 2e-5);
  const std::string ghosts = ghost_bytes(2, {{0.5F, 3, frame}, {1, 4, frame}});
  ASSERT_EQ(ghosts.size(), 4 + 2 * 196);
  EXPECT_EQ(number_at<uint16_t>(ghosts, 2), 2);
  EXPECT_EQ(number_at<float>(ghosts, 4 + 196), 1);
  EXPECT_EQ(ghosts[4 + 196 + 4], 4);
}

TEST(Recording, FilesHoldTheMotion) {
  TempFolder folder;
  Character person(small_world());
  person.touch({0, interact::contact_on(armchair().chair, "armrest", 0), "armchair_0"});
  std::vector<Frame> frames;
  for (int i = 0; i < 45; ++i) {
    person.step();
    frames.push_back(person.frame());
  }
  const Clip motion = clip_of(frames, small_world()->person);
  for (const char* extension : {"npz", "bvh", "glb"}) {
    const std::string bytes = recording_file(*small_world(), frames, extension),
                      path = folder / (std::string("m.") + extension);
    std::ofstream(path, std::ios::binary) << bytes;
    if (extension[0] == 'g') {
      EXPECT_EQ(bytes.substr(0, 4), "glTF");
      continue;
    }
    const Clip read = read_clip(path);
    ASSERT_EQ(read.frames(), 45) << extension;
    EXPECT_LT(largest(read.joints.slice(1, 0, 1) - motion.joints.slice(1, 0, 1)), 0.005) << extension;
  }
}

}  // namespace
}  // namespace inhabit::serve
