// Protects training in several processes: two ranks end with the weights of one whose batch is twice as large, a signal
// to one of them stops both, and what cannot be a group is refused.
#include "inhabit/train/data_parallel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "inhabit/io/safetensors.h"
#include "inhabit/nn/batch_norm.h"
#include "inhabit/train/loop.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;
using torch::Tensor;

/// A small network with a batch norm on fixed data: y of x, 64 samples.
struct Fit {
  torch::nn::Sequential network{nullptr};
  Tensor x, y;
  TrainTask task;
  std::function<void(const TrainStep&)> on_step;

  explicit Fit(uint64_t seed) {
    torch::manual_seed(5);
    x = torch::randn({64, 6});
    y = torch::sin(x.sum(1, true));
    torch::manual_seed(seed);
    // A bias that a batch norm takes away again would be moved by rounding errors alone.
    network = torch::nn::Sequential(torch::nn::Linear(torch::nn::LinearOptions(6, 16).bias(false)), nn::BatchNorm(16),
                                    torch::nn::Tanh(), torch::nn::Linear(16, 1));
    task.name = "fit";
    task.module = network.ptr();
    task.samples = 64;
    task.weight_decay = 0.01;
    task.prepare = batches(
        [](const TrainStep& step) { return torch::tensor(step.indices); },
        [this](const Tensor& i, const TrainStep& step) {
          if (on_step) on_step(step);
          return Losses{{"square", torch::mse_loss(network->forward(x.index_select(0, i)), y.index_select(0, i))}};
        });
    task.validate = [this] { return torch::mse_loss(network->forward(x), y).item<double>(); };
    task.on_best = [] {};
  }
  /// And the statistics that the batch norm has seen.
  Tensor weights() const {
    std::vector<Tensor> all;
    for (const auto& p : network->parameters()) all.push_back(p.detach().flatten());
    for (const auto& b : network->named_buffers())
      if (b.value().is_floating_point()) all.push_back(b.value().flatten());
    return torch::cat(all);
  }
};

TrainOptions options_in(const TempFolder& folder, const std::string& name) {
  TrainOptions o;
  o.steps = 40;
  o.batch = 8;
  o.learning_rate = 0.02;
  o.validate_every = 10;
  o.checkpoint = folder / (name + ".checkpoint.safetensors");
  o.log = folder / (name + ".jsonl");
  return o;
}

/// What those who start ranks call a rank and how many there are.
struct RankVariables {
  const char *rank, *size;
};
constexpr RankVariables kTorchrun = {"RANK", "WORLD_SIZE"}, kOpenMpi = {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"};

/// Runs `rank_main(rank)` in a process each and returns their exit codes. They start over from the program's beginning
/// (exec), as LibTorch's threads do not survive a fork.
std::vector<int> run_ranks(const std::string& filter, const TempFolder& folder, int port,
                           const RankVariables& variables = kTorchrun) {
  std::vector<pid_t> children;
  for (int rank = 0; rank < 2; ++rank) {
    const pid_t child = fork();
    if (child == 0) {
      setenv("INHABIT_TEST_RANK_FOLDER", (folder / "").c_str(), 1);
      setenv(variables.rank, std::to_string(rank).c_str(), 1);
      setenv(variables.size, "2", 1);
      setenv("MASTER_PORT", std::to_string(port).c_str(), 1);
      setenv("OMP_NUM_THREADS", "1", 1);
      const std::string only = "--gtest_filter=" + filter;
      execl("/proc/self/exe", "train_test", only.c_str(), nullptr);
      _exit(127);
    }
    children.push_back(child);
  }
  std::vector<int> codes;
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    codes.push_back(WIFEXITED(status) ? WEXITSTATUS(status) : -1);
  }
  return codes;
}

const char* rank_folder() { return std::getenv("INHABIT_TEST_RANK_FOLDER"); }
int free_port(int number) { return 20000 + static_cast<int>(getpid()) % 20000 + number; }

/// What each process of the tests below does; in other processes it is no test.
struct DataParallelRank : testing::Test {
  void TestBody() override;
};
[[maybe_unused]] const bool is_rank =
    rank_folder() != nullptr &&
    testing::RegisterTest("DataParallelRank", "Trains", nullptr, nullptr, __FILE__, __LINE__,
                          []() -> testing::Test* { return new DataParallelRank; }) != nullptr;

void DataParallelRank::TestBody() {
  torch::Device device = torch::kCPU;
  const auto ranks = DataParallel::from_environment(device);
  ASSERT_TRUE(ranks);
  Fit fit(ranks->rank() == 0 ? 3 : 99);  // all begin with rank 0's weights
  TrainOptions o;
  o.steps = 40;
  o.batch = 8;
  o.learning_rate = 0.02;
  o.validate_every = 10;
  o.checkpoint = std::string(rank_folder()) + "two.checkpoint.safetensors";
  o.log = std::string(rank_folder()) + "two.jsonl";
  o.ranks = ranks;
  const bool stops = std::getenv("INHABIT_TEST_STOP") != nullptr;
  if (stops && ranks->rank() == 1)
    fit.on_step = [](const TrainStep& step) {
      if (step.number == 6) std::raise(SIGTERM);
    };
  EXPECT_EQ(train(fit.task, o).interrupted, stops);
  SafeTensors out;
  out.tensors["weights"] = fit.weights();
  write_safetensors(std::string(rank_folder()) + std::to_string(ranks->rank()) + ".safetensors", out);
}

TEST(DataParallel, TwoRanksAreOneWithTwiceTheBatchWhoeverStartsThem) {
  const TempFolder alone;
  Fit one(3);
  TrainOptions o = options_in(alone, "one");
  o.batch = 16;
  train(one.task, o);
  int port = 0;
  for (const RankVariables& variables : {kTorchrun, kOpenMpi}) {
    const TempFolder folder;
    EXPECT_THAT(run_ranks("DataParallelRank.Trains", folder, free_port(port++), variables),
                ::testing::ElementsAre(0, 0))
        << variables.size;
    for (const char* rank : {"0.safetensors", "1.safetensors"}) {
      const Tensor weights = read_safetensors(folder / rank).tensors.at("weights");
      EXPECT_LT((weights - one.weights()).abs().max().item<double>(), 1e-5) << variables.size << " " << rank;
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "two.checkpoint.safetensors"));
  }
}

TEST(DataParallel, ASignalToOneStopsAllAtTheSameStep) {
  const TempFolder folder;
  setenv("INHABIT_TEST_STOP", "1", 1);
  EXPECT_THAT(run_ranks("DataParallelRank.Trains", folder, free_port(2)), ::testing::ElementsAre(0, 0));
  unsetenv("INHABIT_TEST_STOP");
  EXPECT_EQ(read_safetensors_metadata(folder / "two.checkpoint.safetensors").at("step"), "7");
  EXPECT_TRUE(torch::equal(read_safetensors(folder / "0.safetensors").tensors.at("weights"),
                           read_safetensors(folder / "1.safetensors").tensors.at("weights")));
}

TEST(DataParallel, OneProcessIsNoGroupAndNonsenseIsRefused) {
  torch::Device device = torch::kCPU;
  EXPECT_EQ(DataParallel::from_environment(device), nullptr);
  for (const auto& [rank, size] : {kTorchrun, kOpenMpi}) {
    setenv(size, "1", 1);
    EXPECT_EQ(DataParallel::from_environment(device), nullptr) << size;
    setenv(size, "two", 1);
    EXPECT_THAT(refusal_of([&] { DataParallel::from_environment(device); }),
                HasSubstr(std::string(size) + ": is 'two'"));
    setenv(size, "2", 1);
    EXPECT_THAT(refusal_of([&] { DataParallel::from_environment(device); }), HasSubstr("RANK: must be from 0 to 1"));
    setenv(rank, "2", 1);
    EXPECT_THAT(refusal_of([&] { DataParallel::from_environment(device); }), HasSubstr("RANK: must be from 0 to 1"));
    setenv(rank, "0", 1);
    setenv("MASTER_PORT", "70000", 1);
    EXPECT_THAT(refusal_of([&] { DataParallel::from_environment(device); }), HasSubstr("MASTER_PORT: must be from 1"));
    for (const char* name : {rank, size, "MASTER_PORT"}) unsetenv(name);
  }
  // Under both, torchrun's count.
  setenv(kOpenMpi.size, "2", 1);
  setenv(kTorchrun.size, "1", 1);
  EXPECT_EQ(DataParallel::from_environment(device), nullptr);
  for (const char* name : {kOpenMpi.size, kTorchrun.size}) unsetenv(name);
}

}  // namespace
}  // namespace inhabit
