// Protects the training loop: it learns, its batches depend on the seed and step alone, and an interrupted run that is
// resumed ends with the very weights of one that was not.
#include "inhabit/train/loop.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>
#include <utility>

#include "inhabit/error.h"
#include "inhabit/train/average.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

/// y = x W^T + b with known W and b, fitted by a linear layer.
struct Toy {
  struct Pairs {
    torch::Tensor x, y;
  };
  std::vector<int64_t> steps;                     ///< as batches were told them
  std::function<void(const TrainStep&)> on_step;  ///< before the losses of a step
  torch::nn::Linear layer{nullptr};
  torch::Tensor weight, x, y;
  TrainTask task;
  int64_t bests = 0;

  Toy() {
    torch::manual_seed(3);
    layer = torch::nn::Linear(4, 2);
    weight = torch::randn({2, 4});
    x = torch::randn({50, 4});
    y = torch::matmul(x, weight.t()) + 0.5;
    task.name = "toy";
    task.module = layer.ptr();
    task.samples = 50;
    task.prepare = batches(
        [this](const TrainStep& step) {
          steps.push_back(step.number);
          const torch::Tensor i = torch::tensor(step.indices);
          return Pairs{x.index_select(0, i), y.index_select(0, i)};
        },
        [this](const Pairs& b, const TrainStep& step) {
          if (on_step) on_step(step);
          return Losses{{"square", torch::mse_loss(layer->forward(b.x), b.y)}};
        });
    task.validate = [this] { return torch::mse_loss(layer->forward(x), y).item<double>(); };
    task.on_best = [this] { ++bests; };
  }
};

TrainOptions options_in(const TempFolder& folder) {
  TrainOptions o;
  o.steps = 400;
  o.batch = 8;
  o.learning_rate = 0.05;
  o.validate_every = 100;
  o.checkpoint_every = 50;
  o.checkpoint = folder / "checkpoint.safetensors";
  o.log = folder / "log.jsonl";
  return o;
}

TEST(TrainLoop, BatchesMadeAheadOnSeveralThreadsAreTheSame) {
  const auto trained = [](int64_t workers) {
    const TempFolder folder;
    Toy toy;
    toy.task.concurrent = true;
    std::atomic<int> at_once = 0, most = 0;
    toy.task.prepare = [&, prepare = toy.task.prepare](const TrainStep& step) {
      static std::mutex one;  // the toy notes its steps in a plain vector
      most = std::max(most.load(), ++at_once);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      const std::lock_guard<std::mutex> lock(one);
      --at_once;
      return prepare(step);
    };
    TrainOptions options = options_in(folder);
    options.steps = 60;
    options.workers = workers;
    train(toy.task, options);
    EXPECT_EQ(toy.steps.size(), 60U);
    return std::pair(toy.layer->weight.detach().clone(), most.load());
  };
  const auto [one, one_at_once] = trained(1);
  int four_at_once = 0;
  for (int run = 0; run < 8; ++run) {  // threads that shared the order of an epoch differed in one of ten
    const auto [four, at_once] = trained(4);
    EXPECT_TRUE(torch::equal(one, four));
    four_at_once = std::max(four_at_once, at_once);
  }
  EXPECT_EQ(one_at_once, 1);
  EXPECT_GT(four_at_once, 1);
  EXPECT_LE(four_at_once, 4);
}

TEST(TrainLoop, TheLastStepCountsAsTheBestWhereAskedTo) {
  for (const bool last : {false, true}) {
    const TempFolder folder;
    Toy toy;
    double validation = 0;
    toy.task.validate = [&] { return ++validation; };  // worse each time
    TrainOptions options = options_in(folder);
    options.last = last;
    const TrainResult r = train(toy.task, options);
    EXPECT_EQ(toy.bests, last ? 2 : 1);
    EXPECT_EQ(r.best_step, last ? 400 : 100);
    EXPECT_EQ(r.best, last ? 4 : 1);
  }
}

TEST(TrainLoop, FitsALineAndLogsIt) {
  const TempFolder folder;
  Toy toy;
  const TrainResult r = train(toy.task, options_in(folder));
  EXPECT_LT(r.best, 1e-3);
  EXPECT_GE(toy.bests, 1);
  EXPECT_LT((toy.layer->weight - toy.weight).abs().max().item<double>(), 0.05);
  std::ifstream log(folder / "log.jsonl");
  std::string line, last;
  while (std::getline(log, line)) last = line;
  EXPECT_EQ(nlohmann::json::parse(last)["step"], 400);
  EXPECT_FALSE(std::filesystem::exists(folder / "checkpoint.safetensors"));
}

TEST(WeightAverage, IsTheExponentialAverageAndSwapsWithTheWeights) {
  torch::nn::Linear layer(1, 1);
  torch::NoGradGuard no_gradients;
  layer->weight.fill_(0);
  WeightAverage average(layer.ptr(), 0.5);
  double expected = 0;
  for (int64_t step = 1; step <= 40; ++step) {
    layer->weight.fill_(static_cast<double>(step));
    average.update(step);
    const double decay = std::min(0.5, (1.0 + static_cast<double>(step)) / (10.0 + static_cast<double>(step)));
    expected = decay * expected + (1 - decay) * static_cast<double>(step);
  }
  average.swap();
  EXPECT_NEAR(layer->weight.item<double>(), expected, 1e-4);
  average.swap();
  EXPECT_EQ(layer->weight.item<double>(), 40);
}

TEST(TrainLoop, ResumesToTheSameNumbers) {
  const TempFolder folder;
  Toy whole, cut, resumed;
  std::vector<double> validated, validated_in_parts;
  for (Toy* toy : {&whole, &cut, &resumed}) {
    toy->task.average = 0.98;
    toy->task.validate = [toy, plain = toy->task.validate, into = toy == &whole ? &validated : &validated_in_parts] {
      into->push_back(plain());
      return into->back();
    };
  }
  TrainOptions o = options_in(folder);
  train(whole.task, o);

  int64_t steps = 0;
  cut.on_step = [&](const TrainStep& step) {
    EXPECT_EQ(step.number, steps);
    if (++steps == 170) std::raise(SIGTERM);
  };
  EXPECT_TRUE(train(cut.task, o).interrupted);
  EXPECT_EQ(steps, 170);

  o.resume = true;
  EXPECT_FALSE(train(resumed.task, o).interrupted);
  EXPECT_TRUE(torch::equal(whole.layer->weight, resumed.layer->weight));
  EXPECT_TRUE(torch::equal(whole.layer->bias, resumed.layer->bias));
  EXPECT_EQ(validated, validated_in_parts);  // of the averaged weights
}

TEST(TrainLoop, RefusesACheckpointOfAnotherRun) {
  const TempFolder folder;
  TrainOptions o = options_in(folder);
  Toy cut;
  cut.on_step = [](const TrainStep&) { std::raise(SIGTERM); };
  train(cut.task, o);
  o.resume = true;
  o.batch = 4;
  Toy other;
  EXPECT_THROW(train(other.task, o), Error);
  o.checkpoint = folder / "none.safetensors";
  EXPECT_THROW(train(other.task, o), Error);
}

TEST(TrainLoop, StopsWhenTheLossIsNotFinite) {
  const TempFolder folder;
  Toy toy;
  toy.x[7][0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(train(toy.task, options_in(folder)), Error);
}

TEST(TrainLoop, WarmUpAndFloorOfTheRateAreOptions) {
  const TempFolder folder;
  TrainOptions o = options_in(folder);
  o.steps = 100;
  o.schedule.warmup = 0.2;
  o.schedule.floor = 0.5;
  Toy toy;
  train(toy.task, o);
  std::vector<double> rates;
  std::ifstream log(o.log);
  for (std::string line; std::getline(log, line);) {
    const auto json = nlohmann::json::parse(line);
    if (json.contains("rate") && json["step"].get<int64_t>() % 20 == 0) rates.push_back(json["rate"]);
  }
  ASSERT_EQ(rates.size(), 5U);  // steps 20, 40, ..., 100
  EXPECT_NEAR(rates[0] / o.learning_rate, 0.5 + 0.5 * 0.5 * (1 + std::cos(M_PI * 0.19)), 1e-6) << "risen at 20 of 100";
  EXPECT_NEAR(rates[4] / o.learning_rate, 0.5 + 0.5 * 0.5 * (1 + std::cos(M_PI * 0.99)), 1e-6)
      << "half the rate at the end";
}

}  // namespace
}  // namespace inhabit
