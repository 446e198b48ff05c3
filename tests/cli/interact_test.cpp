// Protects `inhabit synth chairs`, `train interact`, `interact`, `contacts` and `eval interact` as one chain, and that
// bad input is told in one line with nothing written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "animator.h"
#include "cli/examples.h"
#include "cli/refusal.h"
#include "cli/shards.h"
#include "inhabit/interact/model_file.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/files.h"
#include "interact/small_networks.h"
#include "io/plain_kinematics.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;

/// A model file of small sizes and weights of no training.
std::string untrained_interaction(const TempFolder& folder) {
  interact::Networks networks = interact::untrained_networks(interact::small_interact_config());
  networks.output_scale.mean.zero_();
  networks.output_scale.deviation.fill_(0.05);
  const std::string path = folder / "model.safetensors";
  interact::save_networks(path, networks);
  return path;
}

const std::string kSitRoom = std::string(INHABIT_SOURCE_DIR) + "/examples/data/sit_room.glb";

TEST(Interact, FromDataToAModelToATable) {
  const TempFolder folder;
  const std::string data = folder / "chairs", model = folder / "model.safetensors";
  CommandResult r = run_command("synth chairs --minutes 12 --subjects 2 --chairs 24 --seed 7 --out " + data);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  r = run_command(
      "train interact --data " + data + " --out " + model +
      " --set 'encoders=[16,8,8,16,8]' experts=2 hidden=16 gating_hidden=8 control_encoder=8 control_hidden=16 "
      "contact_hidden=16 training.pose_steps=4 training.rollout_steps=2 training.rollout_frames=3 "
      "training.control_steps=2 training.contact_steps=4 training.batch=4");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const interact::Networks networks = interact::load_networks(model);
  EXPECT_FALSE(networks.pose.is_empty() || networks.control.is_empty() || networks.contact.is_empty());
  r = run_command("eval interact --data " + data + " --split all --runs 2 --seconds 16 --model " + model + " --json " +
                  folder / "t.json");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, HasSubstr("ours"));
  const nlohmann::json table = nlohmann::json::parse(read_whole_file(folder / "t.json"));
  EXPECT_EQ(table["rows"][0]["method"], "data");
  EXPECT_LT(table["rows"][0]["contact_error_cm"]["mean"].get<double>(), 5);
  r = run_command("eval interact --scene " + kSitRoom + " --runs 1 --seconds 1 --model " + model + " --json " +
                  folder / "t.json");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const nlohmann::json starts = nlohmann::json::parse(read_whole_file(folder / "t.json"));
  EXPECT_GE(starts.size(), 4) << "each chair, raw and fitted";
  EXPECT_TRUE(starts[0].contains("seated_percent"));
  expect_shards_alike("eval interact --data " + data + " --split all --runs 3 --seconds 2 --model " + model);
  expect_shards_alike("eval interact --scene " + kSitRoom + " --runs 2 --seconds 1 --model " + model);
  r = run_command("eval interact --model " + model);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_THAT(r.err, HasSubstr("--data"));
}

TEST(Interact, WritesEveryFormatAndSeveralSamples) {
  const TempFolder folder;
  const std::string model = untrained_interaction(folder), out = folder / "sit";
  const std::string base = "interact --scene " + kSitRoom + " --start 0,0,30 --seconds 1 --force --model " + model;
  CommandResult r = run_command(base + " -o " + out + ".npz -o " + out + ".bvh -o " + out + ".glb -o " + out +
                                ".json -o " + out + ".html");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(read_clip(out + ".npz").frames(), 30);
  EXPECT_EQ(read_clip(out + ".bvh").frames(), 30);
  r = run_command(base + " --samples 3 -o " + out + ".npz -o " + out + ".bvh");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(read_clips(out + ".npz").size(), 3);
  EXPECT_EQ(read_clip(out + "_002.bvh").frames(), 30);
  r = run_command("interact " + kWalk + " --scene " + kSitRoom + " --seconds 1 --force --standard --model " + model +
                  " -o " + out + ".npz");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const Clip walk = read_clip(kWalk), sit = read_clip(out + ".npz");
  EXPECT_LT((sit.joints[0] - walk.joints[-1]).norm(2, {1}).max().item<double>(), 0.01)
      << "it begins with the last pose";
}

TEST(Interact, StartsBeforeTheChairAndSaysWhatWasNotDone) {
  const TempFolder folder;
  const std::string model = untrained_interaction(folder), out = folder / "sit.npz", script = folder / "s.json";
  write_atomically(script, R"([{"left": "front"}, {"right": "front"}])");
  const CommandResult r = run_command("interact --scene " + kSitRoom + " --chair armchair_0 --seconds 1 --contacts " +
                                      script + " --model " + model + " -o " + out);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.err, HasSubstr("nobody sits on armchair_0 within 1 s"));
  EXPECT_THAT(r.err, HasSubstr("of 2 contacts 1 were begun within 1 s"));
}

TEST(Interact, WhoIsPlacedBeforeAChairSitsOnThatOne) {
  const TempFolder folder;
  const std::string model = untrained_interaction(folder), out = folder / "sit.npz";
  const CommandResult contacts = run_command("contacts " + kSitRoom + " --samples 1 --model " + model + " -o " +
                                             folder / "c.json"),
                      sit =
                          run_command("interact --seconds 1 --scene " + kSitRoom + " --model " + model + " -o " + out);
  ASSERT_EQ(contacts.exit_code, 0) << contacts.err;
  ASSERT_EQ(sit.exit_code, 0) << sit.err;
  const std::string chair = contacts.out.substr(contacts.out.find(" on ") + 4);
  EXPECT_THAT(sit.err, HasSubstr("nobody sits on " + chair.substr(0, chair.find('\n')) + " within"));
}

TEST(Interact, AnOutputIsOneFileAndWhatFollowsIsAnInput) {
  const TempFolder folder;
  const std::string model = untrained_interaction(folder), mine = folder / "mine.npz", out = folder / "sit.npz";
  write_clip(mine, read_clip(kWalk));
  const std::string before = read_whole_file(mine);
  const CommandResult r =
      run_command("interact --scene " + kSitRoom + " --seconds 1 --force --model " + model + " -o " + out + " " + mine);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(read_whole_file(mine), before);
  EXPECT_EQ(read_clip(out).frames(), 29) << "it begins with the motion's last pose";
}

TEST(Interact, WhereTheyWalkInTheEndIsCheckedAndAMotionKeepsItsSkeleton) {
  const TempFolder folder;
  const std::string model = untrained_interaction(folder), out = folder / "off.npz", script = folder / "s.json";
  const std::string base =
      "interact --scene " + kSitRoom + " --seconds 1 --force --model " + model + " -o " + out + " ";
  write_atomically(script, R"([{"left": null}, {"walk_to": [0, 0.5, 90]}])");
  for (const std::string& walk : {std::string("--then-walk 0,0.5,90"), "--contacts " + script}) {
    const CommandResult r = run_command(base + "--start 0,0,30 " + walk);
    EXPECT_EQ(r.exit_code, 0) << r.err;
  }
  const auto refused = [&](const std::string& arguments) {
    const CommandResult r = run_command(base + arguments);
    EXPECT_EQ(r.exit_code, 2) << arguments;
    return r.err;
  };
  EXPECT_THAT(refused("--start 0,0,30 --then-walk 0,1"), HasSubstr("3 are wanted"));
  write_atomically(script, R"([{"walk_to": [0, 0.5, 90]}, {"left": null}])");
  EXPECT_THAT(refused("--start 0,0,30 --contacts " + script), HasSubstr("no last entry"));
  write_atomically(script, R"([{"walk_to": "home"}])");
  EXPECT_THAT(refused("--start 0,0,30 --contacts " + script), HasSubstr("walk_to"));
  const CommandResult r = run_command("interact " + kWalk + base.substr(std::string("interact").size()));
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(read_clip(out).skeleton.names, read_clip(kWalk).skeleton.names);
  EXPECT_EQ(read_clip(out).frames(), 29) << "what follows on the last pose";
}

TEST(Interact, AnAnimatorsSkeletonSitsAtItsOwnRateAndUnit) {
  const TempFolder folder;
  const std::string in = folder / "walk.bvh", out = folder / "sit.bvh";
  AnimatorFile below, millimetres;
  below.world_root = true;
  millimetres.unit = 10, millimetres.z_up = true, millimetres.order = "XZY";
  for (const AnimatorFile& file : {below, millimetres}) {
    const std::string text = file.text();
    write_atomically(in, text);
    const CommandResult r = run_command("interact " + in + " --scene " + kSitRoom + " --seconds 1 --force -o " + out +
                                        " -o " + folder / "sit.npz");
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const std::string own = read_whole_file(out);
    EXPECT_EQ(hierarchy_of(own), hierarchy_of(text));
    EXPECT_THAT(own, HasSubstr("Frames: 58\nFrame Time: 0.0166666667")) << "29 at 30 a second follow on the last pose";
    const Places given = places_in_bvh(text), found = places_in_bvh(own);
    ASSERT_EQ(found.size(), given.size());
    for (const auto& [name, path] : given)
      EXPECT_LT((found.at(name).front() - path.back()).norm(), 15 * file.unit) << name << ", a thirtieth later";
    const Clip read = read_clip(in), arrays = read_clip(folder / "sit.npz");
    EXPECT_EQ(arrays.skeleton.names, read.skeleton.names);
    EXPECT_EQ(arrays.skeleton.parents, read.skeleton.parents);
    EXPECT_LT((arrays.skeleton.offsets - read.skeleton.offsets).abs().max().item<double>(), 1e-5) << "bones, metres";
    EXPECT_EQ(arrays.rate, 60);
  }
}

TEST(Interact, HandsHoldOnAsLongAsTheyAreTold) {
  const TempFolder folder;
  const std::string out = folder / "held.npz";
  const std::string base = "interact --raw --seconds 11 --chair armchair_0 --left armrest --right armrest --scene " +
                           kSitRoom + " -o " + out + " --hold ";
  for (const char* hold : {"1", "end"}) {
    const CommandResult r = run_command(base + hold);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const Clip clip = read_clip(out);
    const bool to_the_end = std::string(hold) == "end";
    for (int side = 0; side < 2; ++side) {
      const torch::Tensor held = clip.hand_targets.select(1, side);
      EXPECT_GT(held.select(1, 3).sum().item<double>(), 45) << "the hand went there";
      EXPECT_EQ(held[-1][3].item<double>(), to_the_end ? 1 : 0);
      // The wrist is a palm's length from the contact.
      if (to_the_end) {
        EXPECT_LT((clip.joints[-1][20 + side] - held[-1].slice(0, 0, 3)).norm().item<double>(), 0.13);
      }
    }
  }
  EXPECT_THAT(run_command(base + "end --then-walk 0,0.5,90").err, HasSubstr("hold: "));
  EXPECT_THAT(run_command(base + "0").err, HasSubstr("hold: is not over 0"));
  EXPECT_THAT(run_command(base + "forever").err, HasSubstr("--hold"));
}

TEST(Interact, ContactsAreWrittenAsPointsOrPainted) {
  const TempFolder folder;
  const std::string model = untrained_interaction(folder), out = folder / "contacts";
  for (const char* extension : {".json", ".html"}) {
    const CommandResult r =
        run_command("contacts " + kSitRoom + " --samples 4 --model " + model + " -o " + out + extension);
    ASSERT_EQ(r.exit_code, 0) << r.err;
  }
  EXPECT_EQ(nlohmann::json::parse(read_whole_file(out + ".json")).size(), 4);
}

TEST(Interact, BadInputIsRefusedInOneLine) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "out");
  const std::string out = folder / "out/sit.npz", model = untrained_interaction(folder),
                    to = " --model " + model + " -o " + out;
  const std::string base = "interact --scene " + kSitRoom;
  expect_refused("interact --start 0,0,0" + to, {"--scene"}, folder / "out");
  expect_refused(base + " --start 0,0" + to, {"--start", "3 are wanted"}, folder / "out");
  expect_refused(base + " --samples 2 --left armrest" + to, {"--samples", "--left"}, folder / "out");
  expect_refused(base + " --chair sofa_0 --sit-at 0,0.4,0,0" + to, {"--sit-at", "--chair"}, folder / "out");
  expect_refused(base + " --start 0,x,0" + to, {"--start", "'x' is no number"}, folder / "out");
  expect_refused(base + " --start 0,0,0 --chair throne_3" + to, {"throne_3"}, folder / "out");
  expect_refused(base + " --start 0,0,0 --left 0,9,0" + to, {"left contact", "in the air"}, folder / "out");
  expect_refused(base + " --start 0,0,0 --left lid" + to, {"--left", "'lid' is no part of a chair", "armrest"},
                 folder / "out");
  expect_refused(base + " --start 0,0,0 --then-walk 40,0,0" + to, {"the place to walk to", "over 3 m outside"},
                 folder / "out");
  expect_refused(base + " --start 0,0,0 --level" + to, {"--level", "start_motion"}, folder / "out");
  expect_refused(base + " --start 0,0,0 --contacts " + folder / "none.json" + to, {"none.json"}, folder / "out");
  std::ofstream(folder / "bad.json") << "[{\"left\": 3}]";
  expect_refused(base + " --start 0,0,0 --contacts " + folder / "bad.json" + to, {"bad.json", "left"}, folder / "out");
  std::ofstream(folder / "bad.json", std::ios::trunc) << R"([{"lefty": "armrest"}])";
  expect_refused(base + " --start 0,0,0 --contacts " + folder / "bad.json" + to, {"bad.json", "\"lefty\""},
                 folder / "out");
  expect_refused("interact --scene " + kRoom + " --start 0,0,0 --model " + kWalk + " -o " + out, {"walk.npz"},
                 folder / "out");
  expect_refused("train interact --data " + (folder / "none") + " --out " + out, {"none/dataset.json"}, folder / "out");
}

}  // namespace
}  // namespace inhabit
