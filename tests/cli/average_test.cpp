// Protects `inhabit average`: the mean of two models is one that loads and has the configuration, number types and
// weighted mean of theirs, and models that have no mean are refused.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "anticipate/small_networks.h"
#include "cli/refusal.h"
#include "inhabit/anticipate/model_file.h"
#include "inhabit/io/safetensors.h"
#include "largest.h"

namespace inhabit {
namespace {

TEST(Average, OfTwoModelsIsTheirWeightedMean) {
  const TempFolder folder;
  const std::string a = folder / "a.safetensors", b = folder / "b.safetensors", out = folder / "mean.safetensors";
  anticipate::save_networks(a, untrained());
  SafeTensors first = read_safetensors(a), second = first;
  torch::manual_seed(2);
  for (auto& [name, tensor] : second.tensors)
    if (tensor.is_floating_point()) tensor = tensor + torch::rand_like(tensor);
  const std::string some = first.tensors.begin()->first;
  first.tensors[some] = first.tensors[some].to(torch::kFloat16);
  write_safetensors(a, first);
  write_safetensors(b, second);
  const CommandResult r = run_command("average " + a + " " + b + " --weights 3 1 -o " + out);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const SafeTensors mean = read_safetensors(out);
  EXPECT_EQ(mean.metadata, first.metadata);
  ASSERT_EQ(mean.tensors.size(), first.tensors.size());
  for (const auto& [name, tensor] : mean.tensors) {
    EXPECT_EQ(tensor.scalar_type(), first.tensors[name].scalar_type()) << name;
    const torch::Tensor expected = 0.75 * first.tensors[name].to(torch::kFloat64) + 0.25 * second.tensors[name];
    EXPECT_LT(largest_difference(tensor, expected), name == some ? 2e-3 : 1e-6) << name;
  }
  anticipate::load_networks(out);

  // One model alone, in half of the space.
  const CommandResult half = run_command("average " + b + " --half -o " + out);
  ASSERT_EQ(half.exit_code, 0) << half.err;
  for (const auto& [name, tensor] : read_safetensors(out).tensors) {
    const torch::Tensor& whole = second.tensors[name];
    EXPECT_TRUE(tensor.equal(whole.is_floating_point() ? whole.to(torch::kFloat16) : whole)) << name;
  }
}

TEST(Average, RecordedStaysAreThoseOfTheFirst) {
  const TempFolder folder;
  const std::string a = folder / "a.safetensors", b = folder / "b.safetensors", out = folder / "mean.safetensors";
  SafeTensors first, second;
  first.metadata = second.metadata = {{"system", "interact"}, {"config", "{}"}};
  first.tensors = {{"pose_net.w", torch::full({2}, 1.F)}, {"habits.standing_points", torch::ones({3, 4})}};
  second.tensors = {{"pose_net.w", torch::full({2}, 3.F)}, {"habits.chairs", torch::zeros({5})}};
  write_safetensors(a, first);
  write_safetensors(b, second);
  const CommandResult r = run_command("average " + a + " " + b + " -o " + out);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  SafeTensors mean = read_safetensors(out);
  ASSERT_EQ(mean.tensors.size(), 2U);
  EXPECT_TRUE(mean.tensors["pose_net.w"].equal(torch::full({2}, 2.F)));
  EXPECT_TRUE(mean.tensors["habits.standing_points"].equal(torch::ones({3, 4})));
}

TEST(Average, RefusesModelsThatHaveNone) {
  const TempFolder folder;
  std::filesystem::create_directory(folder.path / "out");
  const std::string a = folder / "a.safetensors", out = folder / "out", to = " -o " + out + "/m.safetensors";
  anticipate::save_networks(a, untrained());
  const SafeTensors model = read_safetensors(a);
  const std::string some = model.tensors.begin()->first;
  const auto changed = [&](const std::string& name, const std::function<void(SafeTensors&)>& change) {
    SafeTensors other = model;
    change(other);
    write_safetensors(folder / name, other);
    return folder / name;
  };
  const auto refused = [&](const std::string& other, const std::vector<std::string>& parts,
                           const std::string& more = "") {
    expect_refused("average " + a + " " + other + more + to, parts, out);
  };
  refused(folder / "none.safetensors", {"none.safetensors", "no such file"});
  refused("", {"models: one is no mean: name two or more files"});
  refused(a, {"1 weights for 2 models"}, " --weights 1");
  refused(a, {"weights must be"}, " --weights 1 nan");
  refused(a, {"weights must be"}, " --weights 0 0");
  const auto with = [](const char* group, const char* field, double value) {
    return [=](SafeTensors& m) {
      auto config = nlohmann::json::parse(m.metadata["config"]);
      (*group == 0 ? config : config[group])[field] = value;
      m.metadata["config"] = config.dump();
    };
  };
  refused(changed("config.safetensors", with("", "rate", 7)), {"config.safetensors", "another configuration"});
  refused(changed("deep.safetensors", [](SafeTensors& m) { m.metadata["config"] = std::string(100'000, '['); }),
          {"deep.safetensors", "another configuration"});
  const std::string tuned = changed("tuned.safetensors", with("training", "batch", 7));
  EXPECT_EQ(run_command("average " + a + " " + tuned + " -o " + (folder / "m.safetensors")).exit_code, 0)
      << "trained in another way, the same networks";
  const std::string older = changed("older.safetensors", [](SafeTensors& m) {
    auto config = nlohmann::json::parse(m.metadata["config"]);
    ASSERT_EQ(config.erase("memory"), 1) << "a setting that came later";
    m.metadata["config"] = config.dump();
  });
  EXPECT_EQ(run_command("average " + a + " " + older + " -o " + (folder / "m.safetensors")).exit_code, 0)
      << "written before a setting existed";
  refused(changed("fewer.safetensors", [&](SafeTensors& m) { m.tensors.erase(some); }),
          {"fewer.safetensors", "other tensors"});
  refused(changed("shape.safetensors",
                  [&](SafeTensors& m) {
                    m.tensors[some] = torch::zeros({2, 2, 2, 2});
                  }),
          {"shape.safetensors", some, "of another shape"});
  refused(changed("nan.safetensors", [&](SafeTensors& m) { m.tensors[some] = m.tensors[some] * NAN; }),
          {"nan.safetensors", some, "not finite"});
}

}  // namespace
}  // namespace inhabit
