// Protects trainings of several stages: what each puts into the model file, what is kept of others, where a resumed run
// goes on, and which checkpoints and files it refuses.
#include "inhabit/train/stages.h"

#include <gmock/gmock.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/file_lock.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;

/// Two stages of one number each, "a" and "b", that learn to be 1 and 2.
struct ToySystem {
  std::vector<std::string> begun;  ///< stages, as they begin
  std::string interrupt_in;        ///< a stage that SIGTERM ends at its third step
  SafeTensors header;
  CompleteConfig complete;  ///< as run_stages takes it

  ToySystem() {
    header.metadata = {{"system", "toy"}, {"config", "{}"}};
    header.tensors["scale"] = torch::ones({2});
  }
  TrainStage stage(const std::string& name, double target) {
    TrainStage s;
    s.name = name;
    s.steps = 30;
    s.batch = 2;
    s.learning_rate = 0.3;
    s.validations = 3;
    s.task = [=, this] {
      begun.push_back(name);
      TrainTask task;
      torch::nn::Linear layer(1, 1);
      task.module = layer.ptr();
      task.networks[name + "_net."] = layer.ptr();
      task.samples = 4;
      auto loss = [=]() mutable { return (layer->forward(torch::ones({1, 1})) - target).square().sum(); };
      task.prepare = batches([](const TrainStep&) { return 0; },
                             [=, this](int, const TrainStep& step) mutable {
                               if (name == interrupt_in && step.number == 2) std::raise(SIGTERM);
                               return Losses{{"square", loss()}};
                             });
      task.validate = [=]() mutable { return loss().template item<double>(); };
      return task;
    };
    return s;
  }
  bool run(const TrainRun& run, bool both = true) {
    begun.clear();
    std::vector<TrainStage> stages = {stage("a", 1)};
    if (both) stages.push_back(stage("b", 2));
    return run_stages(stages, header, run, complete);
  }
};

double made(const std::string& path, const std::string& name) {
  const SafeTensors file = read_safetensors(path);
  return (file.tensors.at(name + "_net.weight") + file.tensors.at(name + "_net.bias")).item<double>();
}

TrainRun run_in(const TempFolder& folder) {
  TrainRun run;
  run.out = folder / "m.safetensors";
  return run;
}

TEST(Stages, EveryStageLeavesWhatItLearnedAndKeepsTheRest) {
  const TempFolder folder;
  TrainRun run = run_in(folder);
  ToySystem toy;
  ASSERT_TRUE(toy.run(run));
  EXPECT_EQ(toy.begun, (std::vector<std::string>{"a", "b"}));
  EXPECT_NEAR(made(run.out, "a"), 1, 0.2);
  EXPECT_NEAR(made(run.out, "b"), 2, 0.2);
  const double b = made(run.out, "b"), a = made(run.out, "a");
  run.seed = 5;
  ASSERT_TRUE(toy.run(run, false));
  EXPECT_EQ(made(run.out, "b"), b) << "a stage of its own keeps what the file has of others";
  EXPECT_NE(made(run.out, "a"), a);
}

TEST(Stages, AResumedRunGoesOnInTheStageThatStopped) {
  const TempFolder folder;
  TrainRun run = run_in(folder);
  ToySystem whole, cut;
  ASSERT_TRUE(whole.run(run));
  const double a = made(run.out, "a"), b = made(run.out, "b");
  run.out = folder / "cut.safetensors";
  cut.interrupt_in = "b";
  EXPECT_FALSE(cut.run(run));
  cut.interrupt_in = "";
  run.resume = true;
  EXPECT_TRUE(cut.run(run));
  EXPECT_EQ(cut.begun, std::vector<std::string>{"b"});
  EXPECT_EQ(made(run.out, "a"), a);
  EXPECT_EQ(made(run.out, "b"), b);
}

TEST(Stages, RefusesOtherCheckpointsAndOtherFiles) {
  const TempFolder folder;
  TrainRun run = run_in(folder);
  ToySystem toy;
  run.resume = true;
  EXPECT_THAT(refusal_of([&] { toy.run(run); }), HasSubstr("m.safetensors.checkpoint.safetensors"));
  for (const char* of : {"c steps 10", "aa steps 10", ""}) {
    SafeTensors checkpoint;
    checkpoint.metadata["run"] = of;
    checkpoint.tensors["x"] = torch::zeros({1});
    write_safetensors(run.out + ".checkpoint.safetensors", checkpoint);
    EXPECT_THAT(refusal_of([&] { toy.run(run); }), HasSubstr("is not a checkpoint of the stages asked for")) << of;
  }
  run.resume = false;
  ASSERT_TRUE(toy.run(run));
  const std::string before = read_whole_file(run.out);
  toy.header.metadata["config"] = "{\"size\": 2}";
  EXPECT_THAT(refusal_of([&] { toy.run(run, false); }), HasSubstr("holds networks of another configuration"));
  toy.header.metadata["config"] = "{}";
  toy.header.tensors["scale"] = torch::ones({2}) * 3;
  EXPECT_THAT(refusal_of([&] { toy.run(run, false); }), HasSubstr("scale differs"));
  EXPECT_EQ(read_whole_file(run.out), before);
}

TEST(Stages, AStageIsAddedToAFileFromBeforeItsSettingsExisted) {
  const TempFolder folder;
  const TrainRun run = run_in(folder);
  ToySystem toy;
  ASSERT_TRUE(toy.run(run));  // of configuration {}
  toy.complete = [](const std::string& text, const std::string& path) {
    nlohmann::json config = nlohmann::json::parse(text);
    if (config.contains("unheard")) throw Error(path, "has an unknown field");
    if (!config.contains("size")) config["size"] = 2;
    return config.dump();
  };
  toy.header.metadata["config"] = "{\"size\": 3}";
  EXPECT_THAT(refusal_of([&] { toy.run(run, false); }), HasSubstr("holds networks of another configuration"));
  toy.header.metadata["config"] = "{\"size\": 2}";
  const double b = made(run.out, "b");
  ASSERT_TRUE(toy.run(run, false));
  EXPECT_EQ(made(run.out, "b"), b);
  EXPECT_EQ(read_safetensors_metadata(run.out).at("config"), "{\"size\": 2}");
  SafeTensors newer = read_safetensors(run.out);
  newer.metadata["config"] = "{\"unheard\": 1}";
  write_safetensors(run.out, newer);
  EXPECT_THAT(refusal_of([&] { toy.run(run, false); }), HasSubstr("m.safetensors: has an unknown field"));
}

TEST(Stages, TwoTrainingsDoNotWriteOneModel) {
  const TempFolder folder;
  const TrainRun run = run_in(folder);
  ToySystem toy;
  {
    const FileLock other(run.out + ".log.jsonl", "another training");
    EXPECT_THAT(refusal_of([&] { toy.run(run); }),
                HasSubstr("m.safetensors.log.jsonl: another training is writing it"));
  }
  EXPECT_TRUE(toy.run(run));
}

TEST(Stages, AreChosenByName) {
  const std::vector<std::string> all = {"a", "b", "c"}, usual = {"a", "b"};
  EXPECT_EQ(chosen_stages({}, all, usual), usual);
  EXPECT_EQ(chosen_stages({"c", "a"}, all, usual), (std::vector<std::string>{"a", "c"}));
  EXPECT_THAT(refusal_of([&] { chosen_stages({"d"}, all, usual); }), HasSubstr("'d': is unknown; there are a, b, c"));
}

}  // namespace
}  // namespace inhabit
