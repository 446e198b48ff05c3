// Protects training: every loss that is no discriminator's falls, gradients reach all that is trained, discriminators
// among it, a run that was interrupted goes on to the very file of one that was not, and data that cannot be trained on
// is refused.
#include "inhabit/anticipate/train.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>

#include "anticipate/small_networks.h"
#include "inhabit/anticipate/evaluation_folds.h"
#include "inhabit/io/safetensors.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::anticipate {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// Keeps the log from the terminal and asks the run to stop after the line that begins with `at`.
class StopAt : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::string at;

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text(message.payload.data(), message.payload.size());
    if (!at.empty() && text.rfind(at, 0) == 0) std::raise(SIGTERM);
  }
  void flush_() override {}
};

struct Small : TempFolder {
  std::shared_ptr<StopAt> sink = std::make_shared<StopAt>();
  std::shared_ptr<spdlog::logger> before = spdlog::default_logger();
  TrainRun run;
  Config config = small_anticipate_config();

  explicit Small(int64_t frames = 40) {
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", sink));
    run.data = {write_people(*this / "people", frames)};
    run.out = *this / "m.safetensors";
    run.seed = 3;
    config.training.batch = 8;
  }
  ~Small() { spdlog::set_default_logger(before); }

  std::vector<json> log(const std::string& out) const {
    std::ifstream file(out + ".log.jsonl");
    std::vector<json> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(json::parse(line));
    return lines;
  }
};

TEST(TrainAnticipate, LowersEveryLossThatIsNoDiscriminators) {
  Small t;
  t.config.training.steps = t.config.baselines.steps = 40;
  t.config.memory = false;  // these people are so much alike that what is remembered leaves nothing to learn
  t.config.training.plausibility_weight = 0;
  t.config.training.learning_rate = 1e-3;
  ASSERT_TRUE(train(t.run, t.config));
  std::map<std::string, std::vector<double>> first, last;
  for (const json& line : t.log(t.run.out)) {
    if (!line.contains("losses")) continue;
    for (const auto& [name, value] : line["losses"].items()) {
      ASSERT_TRUE(value.is_number()) << line;
      const std::string key = line["stage"].get<std::string>() + " " + name;
      if (first.count(key) == 0) first[key] = {value};
      last[key] = {value};
    }
  }
  for (const char* key : {"intention rec", "intention root", "intention intention", "seq2seq rec", "seq2seq root",
                          "ltd rec", "ltd root", "hisrep rec", "hisrep root"}) {
    ASSERT_EQ(first.count(key), 1U) << key;
    EXPECT_LT(last[key][0], first[key][0]) << key;
  }
  for (const char* key : {"intention label_discriminator", "intention label_generator", "intention pose_discriminator",
                          "intention pose_generator"})
    EXPECT_EQ(first.count(key), 1U) << key;
  const Networks trained = load_networks(t.run.out);
  EXPECT_FALSE(trained.intention.is_empty() || trained.pose.is_empty() || trained.seq2seq.is_empty() ||
               trained.ltd.is_empty() || trained.hisrep.is_empty());
  EXPECT_FALSE(std::filesystem::exists(t.run.out + ".checkpoint.safetensors"));
}

TEST(TrainAnticipate, RemembersTheValidationRecordingsButWhereTheyAreMeasured) {
  Small t;
  t.config.training.steps = 2;
  t.run.stages = {"intention"};
  ASSERT_TRUE(train(t.run, t.config));
  const Networks trained = load_networks(t.run.out);
  ASSERT_TRUE(trained.memory);
  const auto of_validation = [](const MotionMemory& memory) {
    const auto& all = memory.recordings();
    return std::count_if(all.begin(), all.end(), [](const Remembered& r) { return r.validation; });
  };
  EXPECT_EQ(trained.memory->recordings().size(), 6U);
  EXPECT_EQ(of_validation(*trained.memory), 2);
  for (const auto& [split, remembered] : {std::pair("test", 6U), {"val", 4U}}) {
    const std::vector<Fold> folds = evaluation_folds(t.run.data[0], split, {{t.run.out, trained}});
    ASSERT_EQ(folds.size(), 1U);
    EXPECT_EQ(folds[0].networks.memory->recordings().size(), remembered) << split;
    EXPECT_EQ(folds[0].test.size(), 2U) << split;
  }
}

TEST(TrainAnticipate, GoesOnAfterInterruptsToTheSameFileAndTrainsEveryParameter) {
  Small t;
  t.config.training.steps = t.config.baselines.steps = 5;
  ASSERT_TRUE(train(t.run, t.config));
  const SafeTensors whole = read_safetensors(t.run.out);
  const auto numbers = [&](const std::string& out) {
    std::map<std::string, std::string> validations;
    for (const json& line : t.log(out))
      if (line.contains("validation"))
        validations[line["stage"].get<std::string>() + line["step"].dump()] = line["validation"].dump();
    return validations;
  };

  TrainRun cut = t.run;
  cut.out = t / "cut.safetensors";
  t.sink->at = "intention 3/5  validation";
  EXPECT_FALSE(train(cut, t.config));
  // Adam has seen a gradient of every parameter, those of both discriminators too.
  const SafeTensors checkpoint = read_safetensors(cut.out + ".checkpoint.safetensors");
  size_t parameters = 0;
  for (const char* part : {"intention.", "pose.", "label_discriminator.", "pose_discriminator."}) {
    size_t found = 0;
    for (const auto& [name, tensor] : checkpoint.tensors)
      if (name.rfind(std::string("adam.variance.") + part, 0) == 0) {
        EXPECT_GT(tensor.max().item<float>(), 0) << name;
        ++found;
      }
    EXPECT_GE(found, 4U) << part;
    parameters += found;
  }
  size_t trained = 0;
  for (const auto& [name, tensor] : checkpoint.tensors) trained += name.rfind("module.", 0) == 0 ? 1 : 0;
  EXPECT_EQ(parameters, trained);

  cut.resume = true;
  t.sink->at = "ltd 2/5  validation";
  EXPECT_FALSE(train(cut, t.config));
  t.sink->at = "";
  ASSERT_TRUE(train(cut, t.config));
  EXPECT_EQ(numbers(cut.out), numbers(t.run.out));
  const SafeTensors resumed = read_safetensors(cut.out);
  ASSERT_EQ(resumed.tensors.size(), whole.tensors.size());
  for (const auto& [name, tensor] : whole.tensors) EXPECT_TRUE(torch::equal(tensor, resumed.tensors.at(name))) << name;
}

TEST(TrainAnticipate, AStageOfItsOwnKeepsTheOthersAndRefusesThoseOfAnotherKind) {
  Small t;
  t.config.training.steps = t.config.baselines.steps = 1;
  t.config.training.pose_discriminator = false;
  t.run.stages = {"seq2seq"};
  ASSERT_TRUE(train(t.run, t.config));
  EXPECT_TRUE(load_networks(t.run.out).ltd.is_empty());
  t.run.stages = {"ltd"};
  ASSERT_TRUE(train(t.run, t.config));
  EXPECT_FALSE(load_networks(t.run.out).seq2seq.is_empty());
  t.config.baselines.seq2seq_hidden = 7;  // the kept network would not fit the file's configuration
  EXPECT_THAT(refusal_of([&] { train(t.run, t.config); }),
              HasSubstr("m.safetensors: holds networks of another configuration"));
  EXPECT_NO_THROW(load_networks(t.run.out));
}

TEST(TrainAnticipate, StochasticBaselinesLowerTheirLossesAndDlowNeedsAVae) {
  Small t;
  t.config.baselines.steps = 40;
  t.run.stages = {"dlow"};
  EXPECT_THAT(refusal_of([&] { train(t.run, t.config); }), HasSubstr("holds no VAE"));
  t.run.stages = {"mix_match", "dlow"};
  EXPECT_THAT(refusal_of([&] { train(t.run, t.config); }), HasSubstr("'dlow': is trained alone, or with vae"));
  t.run.stages = {"grammar", "mix_match", "dlow", "vae"};
  ASSERT_TRUE(train(t.run, t.config));
  std::map<std::string, double> first, last;
  for (const json& line : t.log(t.run.out))
    if (line.contains("losses"))
      for (const auto& [name, value] : line["losses"].items()) {
        const std::string key = line["stage"].get<std::string>() + " " + name;
        first.emplace(key, value.get<double>());
        last[key] = value.get<double>();
      }
  for (const char* key : {"vae rec", "vae step", "dlow total", "mix_match rec", "mix_match step", "grammar rec"}) {
    ASSERT_EQ(first.count(key), 1U) << key;
    EXPECT_LT(last[key], first[key]) << key;
  }
  for (const char* key : {"vae divergence", "dlow sameness", "dlow rec", "mix_match divergence",
                          "grammar pose_generator", "grammar pose_discriminator"})
    EXPECT_EQ(first.count(key), 1U) << key;
  const Networks trained = load_networks(t.run.out);
  EXPECT_FALSE(trained.vae.is_empty() || trained.dlow.is_empty() || trained.mix_match.is_empty() ||
               trained.grammar.is_empty());
  // A new VAE has other latents than the old one's DLow draws.
  t.run.stages = {"vae"};
  ASSERT_TRUE(train(t.run, t.config));
  EXPECT_TRUE(load_networks(t.run.out).dlow.is_empty());
}

TEST(TrainAnticipate, WithoutIntentionNothingOfItIsKept) {
  Small t;
  t.config.training.steps = t.config.baselines.steps = 1;
  t.config.intention = false;
  t.run.stages = {"intention"};
  ASSERT_TRUE(train(t.run, t.config));
  const Networks trained = load_networks(t.run.out);
  EXPECT_TRUE(trained.intention.is_empty());
  EXPECT_FALSE(trained.pose.is_empty());
}

TEST(TrainAnticipate, RefusesDataThatCannotBeTrainedOn) {
  const Small t;
  const auto refusal = [&](const std::vector<std::string>& splits, int64_t frames) {
    const std::string folder = t / ("data" + std::to_string(splits.size()) + "_" + std::to_string(frames));
    Dataset data = create_dataset(folder, {});
    data.rate = 25;
    for (const std::string& split : splits) {
      DatasetClip entry{"clips/" + std::to_string(data.clips.size()) + ".npz", "", split, 0, ""};
      write_clip(data, entry, person("walk", frames));
      data.clips.push_back(entry);
    }
    write_index(data);
    TrainRun run = t.run;
    run.data = {folder};
    const std::string why = refusal_of([&] { train(run, t.config); });
    EXPECT_FALSE(std::filesystem::exists(run.out)) << why;
    return why;
  };
  EXPECT_THAT(refusal({"val", "test"}, 40), HasSubstr("data2_40: has no training recording"));
  EXPECT_THAT(refusal({"train"}, 40), HasSubstr("data1_40: has no validation recording"));
  EXPECT_THAT(refusal({"train", "train", "val"}, 17), HasSubstr("data3_17: has no validation recording that is long"));
  EXPECT_THAT(refusal({"train", "val"}, 1), HasSubstr("data2_1: has no training recording"));
  TrainRun run = t.run;
  run.data = {t / "nowhere"};
  EXPECT_THAT(refusal_of([&] { train(run, t.config); }), HasSubstr("nowhere"));
  run = t.run;
  Config config = t.config;
  config.clusters = 1000;  // more than there are poses
  EXPECT_THAT(refusal_of([&] { train(run, config); }), HasSubstr("for 1000 clusters"));
  config = t.config;
  config.gamma = 0;
  EXPECT_THAT(refusal_of([&] { train(run, config); }), HasSubstr("'gamma' is out of range"));
  run.resume = true;
  EXPECT_THAT(refusal_of([&] { train(run, t.config); }), HasSubstr("checkpoint.safetensors"));
}

}  // namespace
}  // namespace inhabit::anticipate
