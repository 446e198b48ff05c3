// Protects checkpoints: everything comes back, and nothing else than a whole checkpoint of the same module is taken.
#include "inhabit/train/checkpoint.h"

#include <gmock/gmock.h>

#include "inhabit/io/atomic_file.h"
#include "inhabit/io/safetensors.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

using ::testing::HasSubstr;

struct Run {
  torch::nn::Linear layer;
  torch::optim::AdamW optimizer;
  std::map<std::string, torch::Tensor> average;

  explicit Run(int64_t in = 4, int64_t seed = 1)
      : layer((torch::manual_seed(seed), torch::nn::Linear(in, 3))),
        optimizer(layer->parameters(), torch::optim::AdamWOptions(0.1)) {
    average["weight"] = torch::zeros({3, in});
  }
  void step() {
    optimizer.zero_grad();
    layer->forward(torch::ones({2, layer->weight.size(1)})).square().sum().backward();
    optimizer.step();
  }
};

TEST(Checkpoint, GoesOnAsTheRunThatWroteIt) {
  const TempFolder folder;
  Run run;
  for (int i = 0; i < 3; ++i) run.step();
  run.average["weight"].fill_(0.25);
  save_checkpoint(folder / "c", *run.layer, run.optimizer, run.average, {{"run", "toy"}, {"step", "3"}});
  Run other(4, 2);
  const auto state = load_checkpoint(folder / "c", *other.layer, other.optimizer, other.average);
  EXPECT_EQ(state.at("run"), "toy");
  EXPECT_EQ(checkpoint_number(state, "step", "c"), 3);
  EXPECT_TRUE(torch::equal(other.average["weight"], run.average["weight"]));
  run.step();
  other.step();
  EXPECT_TRUE(torch::equal(run.layer->weight, other.layer->weight)) << "moments and their count came back too";
}

TEST(Checkpoint, RefusesWhatIsNotOneOfThisModule) {
  const TempFolder folder;
  Run run;
  run.step();
  const std::string path = folder / "c";
  save_checkpoint(path, *run.layer, run.optimizer, run.average, {{"run", "toy"}});
  const auto refused = [&](Run& into) {
    return refusal_of([&] { load_checkpoint(path, *into.layer, into.optimizer, into.average); });
  };
  Run wide(5);
  EXPECT_THAT(refused(wide), HasSubstr("is not a checkpoint of this network (module.weight"));
  Run averaged;
  averaged.average["bias"] = torch::zeros({3});
  EXPECT_THAT(refused(averaged), HasSubstr("average.bias"));

  const std::string whole = read_whole_file(path);
  for (const size_t length : {size_t{0}, size_t{7}, whole.size() / 2, whole.size() - 1}) {
    write_atomically(path, whole.substr(0, length));
    Run again;
    EXPECT_THAT(refused(again), HasSubstr(path)) << length << " of " << whole.size() << " bytes";
  }
  SafeTensors lacking = (write_atomically(path, whole), read_safetensors(path));
  lacking.tensors.erase("adam.variance.weight");
  write_safetensors(path, lacking);
  Run last;
  EXPECT_THAT(refused(last), HasSubstr("adam.variance.weight"));
}

TEST(Checkpoint, NumbersOfTheStateMustBeThere) {
  const std::map<std::string, std::string> state = {{"step", "12"}, {"best", "inf"}, {"seconds", "much"}, {"x", "nan"}};
  EXPECT_EQ(checkpoint_number(state, "step", "c"), 12);
  EXPECT_TRUE(std::isinf(checkpoint_number(state, "best", "c")));
  for (const char* key : {"seconds", "x", "none"})
    EXPECT_EQ(refusal_of([&] { checkpoint_number(state, key, "c"); }),
              std::string("c: is not a checkpoint (") + key + " is missing or no number)");
}

}  // namespace
}  // namespace inhabit
