// Protects `inhabit train inbetween` and `inbetween`: from a data set to a model, from key frames to motion in every
// format, several poses at given times, and one clear line with nothing written for bad input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/examples.h"
#include "cli/refusal.h"
#include "forecast/walker.h"
#include "inbetween/small_network.h"
#include "inhabit/data/native.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/files.h"
#include "inhabit/scene/shapes.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr, ::testing::Not;
using torch::Tensor;

/// A model file of small sizes and weights of no training, for clips of the usual length.
std::string model_file(const TempFolder& folder, int t_star = 0) {
  inbetween::Networks n;
  n.config = small_inbetween_config();
  n.config.frames = 121;
  n.config.padded = 128;
  n.config.anchors = 64;
  n.config.t_star = t_star;
  n.config.partial_keys = true;
  n.network = untrained(n.config);
  n.scale.mean = torch::zeros({inbetween::kFeatureCount});
  n.scale.deviation = torch::full({inbetween::kFeatureCount}, 0.3);
  const std::string path = folder / ("model" + std::to_string(t_star) + ".safetensors");
  inbetween::save_networks(path, n);
  return path;
}

TEST(Inbetween, FillsAMotionAndWritesEveryFormat) {
  const TempFolder folder;
  const std::string model = model_file(folder), out = folder / "filled";
  const CommandResult r =
      run_command("inbetween " + kWalk + " --scene " + kRoom + " --keyframes every:30 --steps 3 --model " + model +
                  " -o " + out + ".npz -o " + out + ".bvh -o " + out + ".glb -o " + out + ".json -o " + out + ".html");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const Clip truth = read_clip(kWalk), filled = read_clip(out + ".npz"), bvh = read_clip(out + ".bvh");
  ASSERT_EQ(filled.frames(), 90);
  for (const int64_t key : {0, 30, 60, 89}) {
    EXPECT_LT((filled.joints[key] - truth.joints[key]).norm(2, {1}).max().item<double>(), 0.01) << key;
    EXPECT_LT((bvh.root_path()[key] - truth.root_path()[key]).norm().item<double>(), 0.01) << key;
  }
  EXPECT_THAT(read_whole_file(out + ".html"), HasSubstr("\"keys\":[0,30,60,89]"));
}

TEST(Inbetween, KeyFramesAreTheFilesOwnAtAnyRate) {
  const TempFolder folder;
  const std::string model = model_file(folder);
  const std::vector<int64_t> keys = {0, 31, 61, 89};
  for (const double rate : {24.0, 25.0, 60.0, 120.0}) {
    Clip clip = read_clip(kWalk), elsewhere = clip;
    clip.rate = elsewhere.rate = rate;
    elsewhere.joints = clip.joints + 5;  // between keys nothing is looked at
    elsewhere.trans = clip.trans + 5;
    for (const int64_t key : keys) {
      elsewhere.joints[key] = clip.joints[key];
      elsewhere.trans[key] = clip.trans[key];
    }
    const std::string in = folder / "in.npz", out = folder / "out.npz";
    write_clip(in, elsewhere);
    const CommandResult r =
        run_command("inbetween " + in + " --keyframes 31,61 --steps 2 --model " + model + " -o " + out);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const Clip filled = read_clip(out);
    EXPECT_EQ(filled.rate, rate);
    EXPECT_EQ(filled.frames(), clip.frames());
    for (const int64_t key : keys)
      EXPECT_TRUE(torch::equal(filled.joints[key], clip.joints[key])) << rate << ", " << key;
    const Clip standard =
        (run_command("inbetween " + in + " --keyframes 31,61 --steps 2 --standard --model " + model + " -o " + out),
         read_clip(out));
    EXPECT_EQ(standard.rate, 30);
    for (const int64_t key : keys) {
      const int64_t at = std::llround(static_cast<double>(key) * 30 / rate);
      EXPECT_LT((standard.joints[at] - clip.joints[key]).norm(2, {1}).max().item<double>(), 0.01)
          << rate << ", " << key;
    }
  }
}

TEST(Inbetween, AHandGoesThroughATarget) {
  const TempFolder folder;
  const Clip walk = read_clip(kWalk);
  // A hand's breadth outside of where the wrist is anyway.
  const torch::Tensor wrist = walk.joints[45][20],
                      aside = (wrist - walk.joints[45][0]) * torch::tensor({1.F, 0.F, 1.F});
  const torch::Tensor target = wrist + 0.1 * aside / aside.norm();
  char text[96];
  std::snprintf(text, sizeof text, "@1.5=%.4f,%.4f,%.4f", target[0].item<double>(), target[1].item<double>(),
                target[2].item<double>());
  const std::string out = folder / "out.npz";
  const auto distance = [&](const std::string& arguments, int joint) {
    const CommandResult r = run_command("inbetween " + arguments + " --keyframes every:30 -o " + out);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return (read_clip(out).joints[45][joint] - target).norm().item<double>();
  };
  EXPECT_GT(distance(kWalk, 20), 0.03);
  EXPECT_LT(distance(kWalk + " --target left_wrist" + text, 20), 0.01);
  // By the name that a joint has in its file.
  Clip renamed = walk;
  renamed.skeleton.names[20] = "LeftHand";
  renamed.skeleton.names[18] = "LeftForeArm";
  write_clip(folder / "renamed.npz", renamed);
  EXPECT_LT(distance(folder / "renamed.npz" + " --target LeftHand" + text, 20), 0.01);
  const CommandResult far = run_command("inbetween " + kWalk + " --target left_wrist@1.5=30,90,20 -o " + out);
  EXPECT_EQ(far.exit_code, 0);
  EXPECT_THAT(far.err, HasSubstr("warning: --target left_wrist@1.5=30,90,20 is missed by ")) << "centimetres";
  EXPECT_THAT(run_command("inbetween " + kWalk + " --target left_wrist" + text + " -o " + out).err,
              Not(HasSubstr("is missed by")));
  const TempFolder empty;
  const std::string to = " -o " + empty / "x.npz", nothing = empty / "";
  expect_refused("inbetween " + folder / "renamed.npz" + " --target nose@1=0,1,0" + to,
                 {"--target nose@1=0,1,0", "\"nose\" is no joint; there are left_hand, right_hand, pelvis",
                  "of the file", "LeftForeArm"},
                 nothing);
  expect_refused("inbetween " + kWalk + " --target left_hand=0,1,0" + to, {"JOINT@SECONDS=X,Y,Z"}, nothing);
  expect_refused("inbetween " + kWalk + " --target left_hand@9=0,1,0" + to, {"9 s is not within"}, nothing);
}

TEST(Inbetween, KeyFramesOfAFileStandAtOtherTimes) {
  const TempFolder folder;
  const Clip walk = read_clip(kWalk);
  const std::string out = folder / "slow.npz";
  const CommandResult r = run_command("inbetween " + kWalk + " --keyframes 0,40,89 --times 0,2,4 -o " + out);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const Clip slow = read_clip(out);
  ASSERT_EQ(slow.frames(), 121);
  for (const auto& [at, key] : {std::pair(0, 0), {60, 40}, {120, 89}})
    EXPECT_TRUE(torch::equal(slow.joints[at], walk.joints[key])) << key;
  const TempFolder empty;
  const std::string to = " -o " + empty / "x.npz", nothing = empty / "";
  expect_refused("inbetween " + kWalk + " --times 0,2" + to, {"--times", "need --keyframes"}, nothing);
  expect_refused("inbetween " + kWalk + " --keyframes 0,40 --times 0,2,4" + to, {"3 are named for 2 poses"}, nothing);
  expect_refused("inbetween " + kWalk + " --keyframes 0,90 --times 0,2" + to, {"frame 90 is outside", "89"}, nothing);
}

TEST(Inbetween, TakesWhatAnAnimatorGivesBesideKeys) {
  const TempFolder folder;
  const std::string out = folder / "out";
  CommandResult r = run_command("inbetween " + kWalk + " --keyframes 0 45 89 -o " + out + ".npz");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_THAT(r.err, HasSubstr("--keyframes: is one list of frames, such as 0,40,95, of one file; several (here "));
  r = run_command("inbetween " + kWalk + " --keyframes 45 --key-weights 1,0.5,1 --contact " +
                  "left_wrist,2.0,2.2,0.3,1.2,2 --root-path 1,0.4,0.9 --samples 2 --standard -o " + out + ".npz -o " +
                  out + ".bvh -o " + out + ".html");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const std::vector<Clip> samples = read_clips(out + ".npz");
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_FALSE(torch::equal(samples[0].joints, samples[1].joints));
  EXPECT_THAT(r.out, HasSubstr(out + ".npz\n" + out + "_000.bvh to " + out + "_001.bvh\n" + out + ".html\n"));
  EXPECT_TRUE(std::filesystem::exists(out + "_000.bvh"));
  EXPECT_TRUE(std::filesystem::exists(out + "_001.bvh"));
  EXPECT_THAT(read_whole_file(out + ".html"), HasSubstr("sample 2"));
  r = run_command("inbetween " + kWalk + " --keyframes 45 --samples 2 --temperature 0 --standard -o " + out +
                  "_alike.npz");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const std::vector<Clip> alike = read_clips(out + "_alike.npz");
  const auto apart = [](const std::vector<Clip>& clips) {
    return (clips[0].joints - clips[1].joints).norm(2, {2}).mean().item<double>();
  };
  r = run_command("inbetween " + kWalk + " --keyframes 45 --samples 2 --standard -o " + out + "_varied.npz");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_GT(apart(alike), 0);
  EXPECT_LT(apart(alike), 0.8 * apart(read_clips(out + "_varied.npz"))) << "several differ in their course as well";
  r = run_command("inbetween " + kWalk + " --loop --standard -o " + out + "_loop.npz");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const Clip loop = read_clip(out + "_loop.npz");
  EXPECT_LT((loop.rotations[0].slice(0, 1) - loop.rotations[89].slice(0, 1)).abs().max().item<double>(), 1e-4);
  const TempFolder empty;
  const std::string walk = "inbetween " + kWalk, to = " -o " + empty / "x.npz", nothing = empty / "";
  expect_refused(walk + " --contact nose,1,2,3,4,5" + to, {"no joint"}, nothing);
  expect_refused(walk + " --contact left_hand,1,2,3" + to, {"5 are wanted"}, nothing);
  expect_refused(walk + " --contact left_hand,2,1,3,4,5" + to, {"not within"}, nothing);
  expect_refused(walk + " --root-path 1,nan,0" + to, {"no number"}, nothing);
  expect_refused(walk + " --temperature 3" + to, {"--temperature"}, nothing);
  expect_refused(walk + " --key-weights 1" + to, {"1 are given for 2 keys"}, nothing);
}

TEST(Inbetween, WarnsOfKeyPosesInsideTheScene) {
  const TempFolder folder;
  Clip clip = read_clip(kSit);
  clip.trans = clip.trans - torch::tensor({0.F, 0.3F, 0.F});
  clip.joints = clip.joints - torch::tensor({0.F, 0.3F, 0.F});
  write_clip(folder / "low.npz", clip);
  const CommandResult r =
      run_command("inbetween " + folder / "low.npz" + " --scene " + kSitRoom +
                  " --keyframes every:30 --steps 2 --model " + model_file(folder) + " -o " + folder / "out.npz");
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_THAT(r.err, HasSubstr("key poses are inside the scene: at "));
  EXPECT_THAT(r.err, HasSubstr(" mm in "));
  EXPECT_TRUE(std::filesystem::exists(folder / "out.npz"));
}

TEST(Inbetween, FromADataSetToAModelToItsTable) {
  const TempFolder folder;
  Dataset data = create_dataset(folder / "data", {});
  for (const char* split : {"train", "val", "test"}) {
    const std::string scene = std::string("scenes/") + split + ".glb";
    write_scene(data, scene, floor_scene());
    DatasetClip entry{std::string("clips/") + split + ".npz", scene, split, 0, ""};
    write_clip(data, entry, walker(125, 1, 0.4, 1));
    data.clips.push_back(entry);
  }
  write_index(data);
  const std::string model = folder / "m.safetensors", table = folder / "table.json";
  CommandResult r = run_command("train inbetween --preset features --data " + folder / "data" + " --out " + model +
                                " --seed 3 --set training.steps=2 training.batch=2 body_shape=false");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  r = run_command("eval inbetween --data " + folder / "data" + " --model " + model +
                  " --keyframes every:60 ends --steps 2 --seeds 2 --no-refine --against 'cubic spline' --row "
                  "'straight, guidance 0: inference.guidance=0 detours=straight' --json " +
                  table);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, HasSubstr("w/o body shape, straight, guidance 0, raw"));
  EXPECT_THAT(r.out, HasSubstr("differences from cubic spline"));
  const auto rows = nlohmann::json::parse(read_whole_file(table)).at("rows");
  EXPECT_EQ(rows.size(), 21U)
      << "real motion, and ten methods for each choice of keys: four interpolations, and input, "
         "raw and finished motion of the model in two settings";

  // Keys that give a wrist alone: interpolation, which knows whole poses, has no row.
  r = run_command("eval inbetween --data " + folder / "data" + " --joints left_wrist --keyframes every:30 --json " +
                  table);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const auto partial = nlohmann::json::parse(read_whole_file(table)).at("rows");
  ASSERT_EQ(partial.size(), 4U) << "real motion; input, raw, refined";
  ASSERT_EQ(partial[3].at("method"), "ours");
  EXPECT_LT(partial[3].at("mpje_key_mm").at("mean").get<double>(), 20) << "the wrist is brought to where it was given";
  EXPECT_GT(partial[3].at("mpje_all_mm").at("mean").get<double>(), 20) << "the rest is free";

  // Recordings that are no truth: a file of motion.
  r = run_command("eval inbetween --motion " + folder / "data/clips/test.npz" + " --no-refine --json " + table);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, HasSubstr("Acc. (m/s2)"));
  EXPECT_THAT(r.out, testing::Not(HasSubstr("MPJE All")));
  const auto recorded = nlohmann::json::parse(read_whole_file(table));
  EXPECT_EQ(recorded.at("truth"), false);
  EXPECT_TRUE(recorded.at("rows")[1].at("mpje_all_mm").at("mean").is_null());

  const std::string less = folder / "less.safetensors";
  const std::string more = "train inbetween --preset features --data " + folder / "data" + " --from " + model +
                           " --set training.steps=1 training.batch=2 ";
  r = run_command(more + "body_shape=false local_scene=false --out " + less);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_TRUE(inbetween::load_networks(less).network->offset_layers[0].is_empty());
  std::filesystem::create_directory(folder / "out");
  expect_refused(more + " --out " + folder / "out/more.safetensors", {model, "another configuration"}, folder / "out");
}

TEST(Inbetween, ResidualMotionIsTrainedInStages) {
  const TempFolder folder;
  Dataset data = create_dataset(folder / "data", {});
  for (const char* split : {"train", "val"}) {
    const std::string scene = std::string("scenes/") + split + ".glb";
    write_scene(data, scene, floor_scene());
    DatasetClip entry{std::string("clips/") + split + ".npz", scene, split, 0, ""};
    write_clip(data, entry, walker(125, 1, 0.4, 1));
    data.clips.push_back(entry);
  }
  write_index(data);
  const std::string model = folder / "m.safetensors",
                    train = "train inbetween --data " + folder / "data" + " --out " + model +
                            " --set width=16 multipliers=[1,1] training.batch=4 training.deployed_steps=2 "
                            "training.path_steps=2 training.path_batch=2 training.steps=2 training.contact_steps=2";
  CommandResult r = run_command(train);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const std::string log = read_whole_file(model + ".log.jsonl");
  EXPECT_THAT(log, HasSubstr("\"stage\":\"denoiser\""));
  EXPECT_THAT(log, HasSubstr("\"stage\":\"deployed\""));
  EXPECT_THAT(log, HasSubstr("jerk"));
  EXPECT_THAT(log, HasSubstr("\"stage\":\"path\""));
  EXPECT_THAT(log, HasSubstr("\"stage\":\"contacts\""));
  EXPECT_THAT(log, HasSubstr("right"));
  EXPECT_TRUE(inbetween::load_networks(model).path) << "in the same file";
  EXPECT_TRUE(inbetween::load_networks(model).feet);
  r = run_command("train inbetween --data " + folder / "data" + " --from " + model + " --stage deployed --out " +
                  folder / "more.safetensors" +
                  " --set width=16 multipliers=[1,1] training.batch=4 training.deployed_steps=1");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(read_whole_file(folder / "more.safetensors.log.jsonl"), testing::Not(HasSubstr("denoiser")));
  EXPECT_TRUE(inbetween::load_networks(folder / "more.safetensors").path) << "kept beside what was trained";
  EXPECT_FALSE(inbetween::load_networks(folder / "more.safetensors").feet) << "of another denoiser";
  r = run_command("train inbetween --data " + folder / "data" + " --from " + model + " --stage contacts --out " +
                  folder / "feet.safetensors --set training.batch=4 training.contact_steps=2");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  {
    const auto was = inbetween::load_networks(model), is = inbetween::load_networks(folder / "feet.safetensors");
    EXPECT_TRUE(torch::equal(was.network->unet->out_conv->weight, is.network->unet->out_conv->weight));
    EXPECT_TRUE(torch::equal(was.path->move->bias, is.path->move->bias));
    EXPECT_FALSE(torch::equal(was.feet->tell->bias, is.feet->tell->bias));
  }
  r = run_command("train inbetween --stage path --from " + model + " --out " + folder / "path.safetensors" +
                  " --set training.path_steps=1 training.path_batch=2");
  ASSERT_EQ(r.exit_code, 0) << r.err << ": of the sizes of the file, without data";
  const auto before = inbetween::load_networks(model), after = inbetween::load_networks(folder / "path.safetensors");
  EXPECT_TRUE(torch::equal(before.network->stem->weight, after.network->stem->weight));
  EXPECT_FALSE(torch::equal(before.path->move->bias, after.path->move->bias));
  const std::string out = folder / "out.npz";
  r = run_command("inbetween " + folder / "data/clips/val.npz" + " --model " + folder / "more.safetensors" +
                  " --keyframes every:60 -o " + out);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(read_clip(out).frames(), 125);
  std::filesystem::create_directory(folder / "none");
  expect_refused(
      "train inbetween --data " + folder / "data" + " --stage deployed --out " + folder / "none/m.safetensors",
      {"deployed", "--from"}, folder / "none");
  expect_refused("train inbetween --from " + model + " --stage path deployed --out " + folder / "none/m.safetensors",
                 {"--data", "path"}, folder / "none");
}

TEST(Inbetween, DetoursAroundWhatStandsBetweenKeys) {
  const TempFolder folder;
  const std::string obj = folder / "room.glb", keys = folder / "keys.npz", out = folder / "out.npz";
  const Clip walk = walker(91, 1.1, 0, 0.5);
  write_clip(keys, walk);
  Scene room = floor_scene();
  MeshBuilder cabinet;
  cabinet.box({0, 0.6, 1.65}, {0.3, 0.6, 0.3});
  room.meshes.push_back(cabinet.mesh("cabinet", {0.5F, 0.5F, 0.5F}));
  write_scene(obj, room);
  const auto aside = [&](const std::string& options) {
    const CommandResult r =
        run_command("inbetween " + keys + " --scene " + obj + " --no-refine --standard" + options + " -o " + out);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return read_clip(out).root_path().select(1, 0).abs().max().item<double>();
  };
  EXPECT_GT(aside(""), 0.45);
  EXPECT_GT(aside(" --detours searched"), 0.45);
  EXPECT_LT(aside(" --detours straight"), 0.4);
  std::filesystem::create_directory(folder / "none");
  expect_refused("inbetween " + keys + " --scene " + obj + " --detours left -o " + folder / "none/o.npz",
                 {"--detours", "left"}, folder / "none");
  expect_refused("train inbetween --stage path --resume --out " + folder / "none/m.safetensors", {"path", "--from"},
                 folder / "none");
}

TEST(Inbetween, WindowsOfTheShippedModelsJoin) {
  const TempFolder folder;
  const Tensor truth = read_clip(kSit).joints;
  ASSERT_GT(truth.size(0), 180) << "of more than one window";
  const std::string out = folder / "filled.npz";
  const auto largest_change = [](const Tensor& joints, int order) {
    return joints.diff(order, 0).norm(2, {2}).max().item<double>();
  };
  for (const std::string choice :
       {"--keyframes every:60", "--keyframes every:15 --noisy", "--keyframes every:3 --noisy"}) {
    const CommandResult r = run_command("inbetween " + kSit + " --scene " + kSitRoom + " " + choice + " -o " + out);
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const Tensor filled = read_clip(out).joints;
    EXPECT_LT(largest_change(filled, 1), 1.5 * largest_change(truth, 1)) << choice << ": no jump of place";
    EXPECT_LT(largest_change(filled, 2), 3 * largest_change(truth, 2)) << choice << ": nor of velocity";
  }
}

TEST(Inbetween, TakesPosesAtTimes) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "out");
  const std::string out = folder / "out/filled.npz";
  const Clip walk = read_clip(kWalk);
  for (const int64_t frame : {0, 40, 80})
    write_clip(folder / ("pose" + std::to_string(frame) + ".npz"), slice(walk, frame, frame + 1), nullptr);
  const std::string poses = folder / "pose0.npz" + " " + folder / "pose40.npz" + " " + folder / "pose80.npz";
  const std::string end = " --steps 2 --model " + model_file(folder) + " -o " + out;
  const CommandResult r = run_command("inbetween " + poses + " --times 0,1.5,2" + end);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const Clip filled = read_clip(out);
  ASSERT_EQ(filled.frames(), 61);
  EXPECT_LT((filled.joints[45] - walk.joints[40]).norm(2, {1}).max().item<double>(), 0.01);
  EXPECT_LT((filled.joints[60] - walk.joints[80]).norm(2, {1}).max().item<double>(), 0.01);
  std::filesystem::remove(out);
  expect_refused("inbetween " + poses + " --times 0,1" + end, {"2 are named for 3 poses"}, folder / "out");
  expect_refused("inbetween " + poses + " --times 0,1,1" + end, {"not in order"}, folder / "out");
}

// Joint positions alone, and poses of two skeletons: what is written stands on the standard one, and is said to.
TEST(Inbetween, SaysSoWhereItsOutputIsOnAnotherSkeletonThanItsInput) {
  const TempFolder folder;
  const std::string end = " --steps 2 --model " + model_file(folder) + " -o " + folder / "filled.npz";
  const Clip walk = read_clip(kWalk);
  Clip positions = walk, renamed = slice(walk, 40, 41);
  positions.rotations = positions.trans = torch::Tensor();
  positions.rate = 50;
  renamed.skeleton.names[3] = "belly";
  write_clip(folder / "positions.npz", positions);
  write_clip(folder / "first.npz", slice(walk, 0, 1));
  write_clip(folder / "renamed.npz", renamed);
  const CommandResult alone = run_command("inbetween " + folder / "positions.npz" + end);
  EXPECT_THAT(alone.out, HasSubstr("the file holds no rotations: written on the standard skeleton")) << alone.err;
  EXPECT_EQ(read_clip(folder / "filled.npz").rate, 50) << "at the file's rate all the same";
  const CommandResult two =
      run_command("inbetween " + folder / "first.npz" + " " + folder / "renamed.npz --times 0,1" + end);
  EXPECT_THAT(two.out, HasSubstr("the files hold no rotations on one skeleton")) << two.err;
  EXPECT_THAT(run_command("inbetween " + kWalk + end).out, ::testing::Not(HasSubstr("rotations")));
}

TEST(Inbetween, RefusesWhatItCannotDo) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "out");
  const std::string out = folder / "out/filled.npz", start = "inbetween " + kWalk + " -o " + out + " --model ",
                    model = model_file(folder);
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    expect_refused(arguments, {why}, folder / "out");
  };
  refused(start + model + " --keyframes 0,95", "95");
  refused(start + model + " --keyframes every:0", "every:0");
  const std::string sit = "inbetween " + kSit + " -o " + out + " --model " + model;
  refused(sit, "inhabit: --keyframes: 0 and ");
  refused(sit + " --keyframes 0,60 --times 0,20", "inhabit: --times: 0 and 600 are 600 frames apart");
  refused(start + model + " --joints tail", "tail");
  refused(start + model + " --noisy", "noisy key frames");
  refused(start + model + " --target left_hand@3.5=0,1,0", "--target left_hand@3.5=0,1,0: 3.5 s is not within 0 to");
  refused(
      "inbetween " + kWalk + " -o " + out + " --model " + model +
          " --keyframes 0,30 --times 2,3 --contact left_hand,2,2.5,0,1,0",
      "--contact left_hand,2,2.5,0,1,0: 2 to 2.5 s are not within 0 to 1 s, which count from the first key, at 2 s of "
      "the input: on its clock they are 2 to 3 s");
  refused(start + kWalk, kWalk);
  refused("inbetween " + kWalk + " -o " + folder / "out/filled.txt", "filled.txt");
  EXPECT_EQ(run_command(start + model_file(folder, 20) + " --noisy --keyframes every:3 --steps 2").exit_code, 0);
}

}  // namespace
}  // namespace inhabit
