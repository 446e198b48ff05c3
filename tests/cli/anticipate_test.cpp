// Protects `inhabit train anticipate`, `anticipate` and `eval anticipate`: from a data set to a model, from a recording
// to futures in every format that other verbs read and score, and one clear line with nothing written for bad input.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "anticipate/small_networks.h"
#include "cli/examples.h"
#include "cli/refusal.h"
#include "cli/shards.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/files.h"
#include "inhabit/io/safetensors.h"

namespace inhabit {
namespace {

using nlohmann::json;

const std::string kForecastModel = INHABIT_SOURCE_DIR "/models/forecast-compact.safetensors";

json json_of(const std::string& path) { return json::parse(read_whole_file(path)); }

TEST(Anticipate, FromADataSetToAModelToFuturesToTheirScores) {
  const TempFolder folder;
  const std::string data = write_people(folder / "people", 50), model = folder / "m.safetensors",
                    futures = folder / "f.npz", table = folder / "table.json", score = folder / "score.json";
  CommandResult r = run_command("train anticipate --data " + data + " --out " + model +
                                " --seed 5 --set training.steps=2 baselines.steps=2 training.batch=4 observed=12 "
                                "future=16 gamma=4 clusters=6 labels=3 hidden=14 noise=5"
                                " intention_hidden=10 intention_features=4 training.discriminator_hidden=16"
                                " training.discriminator_frames=4 baselines.seq2seq_hidden=12 baselines.ltd_past=8"
                                " baselines.ltd_future=6 baselines.ltd_hidden=10 baselines.ltd_blocks=1"
                                " baselines.hisrep_query=4 baselines.hisrep_future=5 baselines.hisrep_hidden=10"
                                " baselines.hisrep_blocks=1");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_FALSE(std::filesystem::exists(model + ".checkpoint.safetensors"));

  const Clip walk = read_clip(kWalk);
  r = run_command("anticipate " + kWalk + " --start 60 --samples 3 --seconds 2 --seed 4 --model " + model + " -o " +
                  futures + " -o " + folder / "f.html" + " -o " + folder / "f.bvh");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.err, "");
  const std::vector<Clip> clips = read_clips(futures);
  ASSERT_EQ(clips.size(), 3U);
  for (size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(clips[s].frames(), 60);
    EXPECT_EQ(clips[s].rate, 30) << "the file's";
    EXPECT_LT((clips[s].joints[0] - walk.joints[59]).norm(2, {1}).mean().item<double>(), 0.2);
    const Clip bvh = read_clip(folder / ("f_00" + std::to_string(s) + ".bvh"));
    EXPECT_EQ(bvh.frames(), 60);
    const auto hips = bvh.root_path() - clips[s].root_path();
    EXPECT_LT(hips.norm(2, {1}).max().item<double>(), 2e-3) << s;
  }
  const Npz arrays = read_npz(futures);
  EXPECT_EQ(arrays.tensors.at("joints").sizes(), (torch::IntArrayRef{3, 60, 22, 3}));
  EXPECT_EQ(arrays.tensors.at("intention").sizes(), (torch::IntArrayRef{3, 60}));
  EXPECT_NE(read_whole_file(folder / "f.html").find("Futures of walk.npz"), std::string::npos);

  ASSERT_EQ(run_command("anticipate " + kWalk + " --start 60 --samples 3 --seconds 2 --seed 4 --model " + model +
                        " -o " + folder / "again.npz")
                .exit_code,
            0);
  EXPECT_TRUE(read_whole_file(folder / "again.npz") == read_whole_file(futures)) << "the same seed, the same file";

  r = run_command("score apd --motion " + futures + " --json " + score);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(json_of(score)["futures"], 3);
  EXPECT_GT(json_of(score)["apd_m"].get<double>(), 0);
  r = run_command("score ndms --motion " + futures + " --reference " + kWalk + " --json " + score);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(json_of(score)["words"], 3 * (50 - 8 + 1));
  std::filesystem::create_directory(folder / "out");
  expect_refused("score error --motion " + futures + " --truth " + futures + " --json " + folder / "out/e.json",
                 {"f.npz", "holds 3 motions where one is wanted"}, folder / "out");

  r = run_command("eval anticipate --data " + data + " --model " + model +
                  " --samples 2 --windows 1 --seconds 0.8 --json " + table);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const json got = json_of(table);
  EXPECT_EQ(got["horizons_seconds"], json({0.4, 0.8}));
  ASSERT_EQ(got["actions"].size(), 3U);
  EXPECT_EQ(got["actions"][2]["action"], "mean");
  std::vector<std::string> methods;
  for (const json& row : got["rows"])
    if (row["action"] == "mean") methods.push_back(row["method"]);
  EXPECT_EQ(methods, (std::vector<std::string>{"last pose held", "constant velocity", "retrieval", "memory alone",
                                               "seq2seq", "LTD", "HisRep", "ours", "real motion"}));
  for (const std::string& method : methods) EXPECT_THAT(r.out, ::testing::HasSubstr(method));

  expect_shards_alike("eval anticipate --data " + data + " --model " + model + " --samples 2 --windows 2 --seconds 4");

  // Without a model a fold remembers its own recordings.
  r = run_command("eval anticipate --data " + data +
                  " --split left-out --set inference.memory_stay=0 --samples 2 --windows 1 --seconds 0.8 --json " +
                  table);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, ::testing::HasSubstr("memory alone"));
  EXPECT_THAT(r.out, ::testing::Not(::testing::HasSubstr("ours")));
}

/// A small model, and a folder of its own for outputs, in which refusals must leave nothing.
struct BadRecordings : TempFolder {
  std::string out = *this / "out", model = *this / "m.safetensors";
  BadRecordings() {
    std::filesystem::create_directory(out);
    anticipate::save_networks(model, untrained());
  }
  void expect_refusal(const std::string& motion, const std::string& options,
                      const std::vector<std::string>& parts) const {
    expect_refused("anticipate " + motion + " " + options + " -o " + out + "/f.npz", parts, out);
  }
};

TEST(Anticipate, RefusesMotionsThatCannotBeForecast) {
  const BadRecordings bad;
  const std::string given = "--model " + bad.model;
  bad.expect_refusal(bad / "none.bvh", given, {"none.bvh", "no such file"});
  bad.expect_refusal(kWalk, given + " --start 8", {"walk.npz", "has 8 frames at 30 a second", "at least 10"});
  bad.expect_refusal(kWalk, given + " --start 91", {"walk.npz", "beyond the end"});
  write_clip_npz(bad / "short.npz", person("walk", 5));
  bad.expect_refusal(bad / "short.npz", given, {"short.npz", "has 5 frames"});
  write_clips_npz(bad / "many.npz", {person("walk", 30), person("walk", 30, 1)});
  bad.expect_refusal(bad / "many.npz", given, {"many.npz", "holds 2 motions where one is wanted"});
  write_atomically(bad / "text.bvh", "HIERARCHY\nROOT a\n{\n");
  bad.expect_refusal(bad / "text.bvh", given, {"text.bvh"});
  Clip wheels = person("walk", 30);
  for (std::string& name : wheels.skeleton.names) name = "wheel" + name.substr(0, 1);
  for (size_t j = 0; j < wheels.skeleton.names.size(); ++j) wheels.skeleton.names[j] += std::to_string(j);
  write_clip_npz(bad / "car.npz", wheels);
  bad.expect_refusal(bad / "car.npz", given, {"car.npz"});
}

TEST(Anticipate, RefusesModelsOptionsAndOutputsThatMakeNoSense) {
  const BadRecordings bad;
  bad.expect_refusal(kWalk, "--model " + bad / "none.safetensors", {"none.safetensors", "no such file"});
  bad.expect_refusal(kWalk, "--model " + kForecastModel, {"forecast-compact", "is not a model of intention"});
  SafeTensors some = read_safetensors(bad.model);
  for (auto it = some.tensors.begin(); it != some.tensors.end();)
    it = it->first.rfind("pose_net.", 0) == 0 ? some.tensors.erase(it) : std::next(it);
  write_safetensors(bad / "some.safetensors", some);
  bad.expect_refusal(kWalk, "--model " + bad / "some.safetensors", {"some.safetensors", "lacks the networks"});

  const std::string given = "--model " + bad.model;
  for (const char* option : {"--samples 0", "--seconds 1e9", "--seconds nan", "--start -1"})
    bad.expect_refusal(kWalk, given + " " + option, {std::string(option).substr(0, 6)});

  const std::string walk = "anticipate " + kWalk + " " + given + " -o ";
  expect_refused(walk + bad.out + "/f.fbx", {"f.fbx", "is no output of an anticipation"}, bad.out);
  expect_refused(walk + bad.out + "/f.npz -o " + bad / "none/f.npz", {"none/f.npz", "there is no folder"}, bad.out);
  expect_refused(walk + "/proc/f.npz", {"/proc/f.npz", "cannot be written"}, bad.out);
}

TEST(TrainAnticipateCommand, RefusesSettingsDataAndOutputs) {
  const BadRecordings bad;
  const std::string data = write_people(bad / "people", 30), train = "train anticipate --data ",
                    to = " --out " + bad.out + "/m.safetensors";
  expect_refused(train + data + to + " --set gama=5", {"gama=5", "no setting is called 'gama'"}, bad.out);
  expect_refused(train + data + to + " --set gamma", {"gamma", "KEY=VALUE"}, bad.out);
  expect_refused(train + data + to + " --set gamma=0", {"gamma", "out of range"}, bad.out);
  expect_refused(train + data + to + " --set hidden=2.5", {"hidden", "wrong type"}, bad.out);
  expect_refused(train + bad / "none" + to, {"none", "no such file"}, bad.out);
  expect_refused(train + "cmu:" + bad / "none" + to, {"cmu:", "holds no motion"}, bad.out);
  expect_refused(train + data + to + " --stage last", {"stage", "last"}, bad.out);
  expect_refused(train + data + to + " --resume", {"checkpoint.safetensors", "no such file"}, bad.out);
  expect_refused(train + data + " --out " + bad / "none/m.safetensors", {"none/m.safetensors", "no folder"}, bad.out);
  expect_refused(train + data + to + " --set training.batch=0", {"training.batch"}, bad.out);
}

TEST(EvalAnticipateCommand, RefusesWhatCannotBeMeasured) {
  const BadRecordings bad;
  const std::string data = write_people(bad / "people", 15), to = " --json " + bad.out + "/t.json",
                    model = " --model " + bad.model, eval = "eval anticipate --data ";
  expect_refused(eval + data + model + to, {"people", "has no recording long enough in split test"}, bad.out);
  expect_refused(eval + bad / "none" + model + to, {"none", "no such file"}, bad.out);
  expect_refused(eval + "h36m:" + bad / "none" + model + to, {"h36m:", "holds no motion"}, bad.out);
  expect_refused(eval + data + " --model " + kForecastModel + to, {"is not a model of intention"}, bad.out);
  expect_refused(eval + data + model + " --json " + bad / "none/t.json", {"none/t.json", "no folder"}, bad.out);
  expect_refused(eval + data + model + to + " --split left-out", {"m.safetensors", "training.folds"}, bad.out);
  expect_refused(eval + data + model + model + to, {"--model", "left-out"}, bad.out);
  expect_refused(eval + data + model + to + " --words world", {"--words"}, bad.out);
  expect_refused(eval + data + model + to + " --seconds 0.1", {"--seconds"}, bad.out);
  expect_refused(eval + data + model + to + " --seconds nan", {"--seconds"}, bad.out);
  expect_refused(eval + data + model + to + " --samples 0", {"--samples"}, bad.out);
}

}  // namespace
}  // namespace inhabit
