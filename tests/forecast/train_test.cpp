// Protects training over its stages: one that is interrupted, in whichever of them, goes on to the numbers of one that
// was not.
#include "inhabit/forecast/train.h"

#include <gmock/gmock.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "forecast/small_config.h"
#include "forecast/walker_data.h"
#include "inhabit/error.h"
#include "inhabit/forecast/model_file.h"
#include "inhabit/io/safetensors.h"
#include "temp_folder.h"

namespace inhabit::forecast {
namespace {

/// What a log says about validations, without the clock.
std::set<std::string> validations_of(const std::string& model) {
  std::set<std::string> out;
  std::ifstream log(model + ".log.jsonl");
  for (std::string line; std::getline(log, line);) {
    nlohmann::json entry = nlohmann::json::parse(line);
    entry.erase("seconds");
    if (entry.contains("validation")) out.insert(entry.dump());
  }
  return out;
}

/// A sink of the log that raises SIGINT with the `left`-th line that says how `stage` validates: in the loop's own
/// thread, so that nothing has to be waited for.
class InterruptAtValidation : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  InterruptAtValidation(const std::string& stage, int left) : stage_(stage), left_(left) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text(message.payload.data(), message.payload.size());
    if (text.rfind(stage_ + " ", 0) == 0 && text.find("validation") != std::string::npos && --left_ == 0)
      std::raise(SIGINT);
  }
  void flush_() override {}

 private:
  std::string stage_;
  int left_;
};

Config tiny_config() {
  Config c = small_forecast_config();
  c.joints = 22;
  c.root = 0;
  c.inference.radius = 4;
  c.training.contact_steps = 5;
  c.training.motion_steps = 13;
  c.training.adapt_steps = 2;
  c.training.contact_batch = c.training.motion_batch = 2;
  return c;
}

void expect_resumed_alike(const std::vector<std::string>& stages, const std::string& interrupted) {
  const TempFolder folder;
  TrainRun run;
  run.data = {write_walkers(folder / "walkers")};
  run.stages = stages;
  run.out = folder / "whole.safetensors";
  ASSERT_TRUE(train(run, tiny_config()));
  const std::string whole = run.out, cut = run.out = folder / "cut.safetensors";
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("interrupting", std::make_shared<InterruptAtValidation>(interrupted, 2)));
  EXPECT_FALSE(train(run, tiny_config()));
  spdlog::set_default_logger(before);
  EXPECT_TRUE(std::filesystem::exists(cut + ".checkpoint.safetensors"));
  EXPECT_LT(validations_of(cut).size(), validations_of(whole).size());
  run.resume = true;
  ASSERT_TRUE(train(run, tiny_config()));
  EXPECT_FALSE(std::filesystem::exists(cut + ".checkpoint.safetensors"));
  EXPECT_EQ(validations_of(cut), validations_of(whole));
  const SafeTensors a = read_safetensors(whole), b = read_safetensors(cut);
  ASSERT_EQ(a.tensors.size(), b.tensors.size());
  for (const auto& [name, tensor] : a.tensors) EXPECT_TRUE(torch::equal(tensor, b.tensors.at(name))) << name;
}

TEST(TrainForecast, AnInterruptedContactStageResumesToTheSameNumbers) { expect_resumed_alike({"contact"}, "contact"); }

TEST(TrainForecast, ARunInterruptedInALaterStageResumesToTheSameNumbers) { expect_resumed_alike({}, "motion"); }

TEST(TrainForecast, TheArticulatedNetworkLearnsWithPredictedContactsFromTheStartAndResumes) {
  const TempFolder folder;
  Config c = tiny_config();
  c.hips = {1, 2};
  c.decoder = "articulated";
  c.articulated.width = 16;
  c.articulated.blocks = 1;
  c.articulated.stride = 1;
  c.articulated.coefficients = 5;
  c.training.mirror = true;
  c.training.recorded = 0.5;
  TrainRun run;
  run.data = {write_walkers(folder / "walkers")};
  run.stages = {"motion"};
  run.out = folder / "alone.safetensors";
  EXPECT_THROW(train(run, c), Error) << "there is no contact network whose predictions it could take";
  run.stages = {"adapt"};
  EXPECT_THROW(train(run, c), Error) << "there is no such stage";

  run.stages = {"contact"};
  run.out = folder / "contact.safetensors";
  ASSERT_TRUE(train(run, c));
  run.stages = {"motion"};
  run.from = run.out;
  run.out = folder / "both.safetensors";
  ASSERT_TRUE(train(run, c));
  const Networks made = load_networks(run.out), contact = load_networks(run.from);
  ASSERT_TRUE(made.complete());
  EXPECT_TRUE(torch::equal(made.contact->x_enc->weight, contact.contact->x_enc->weight)) << "it is taken as it is";
  EXPECT_GT(made.articulated->out->weight.abs().max().item<double>(), 0);
  EXPECT_TRUE(made.no_contact.is_empty());
}

}  // namespace
}  // namespace inhabit::forecast
