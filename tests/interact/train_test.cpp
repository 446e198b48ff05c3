// Protects training: that networks learn what one motion shows, stage by stage, and that rows and losses are right.
#include "inhabit/interact/train.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "inhabit/interact/losses.h"
#include "inhabit/interact/model_file.h"
#include "interact/sitter_data.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::interact {
namespace {

Config small_config() {
  Config c = preset("compact");
  c.encoders = {32, 16, 16, 32, 16};
  c.experts = 2;
  c.hidden = 48;
  c.gating_hidden = 16;
  c.control_encoder = 32;
  c.control_hidden = 32;
  c.contact_hidden = 32;
  c.training.mirrored = false;
  c.training.dropout = 0;
  c.training.pose_steps = 300;
  c.training.rollout_steps = 30;
  c.training.rollout_frames = 4;
  c.training.control_steps = 60;
  c.training.contact_steps = 60;
  c.training.pose_rate = 3e-3;
  c.training.control_rate = 3e-3;
  c.baselines.samp_hidden = 32;
  c.baselines.samp_experts = 2;
  return c;
}

/// The first and the last validation of a stage.
std::pair<double, double> validations(const std::string& model, const std::string& stage) {
  std::ifstream log(model + ".log.jsonl");
  double first = -1, last = -1;
  for (std::string line; std::getline(log, line);) {
    const nlohmann::json entry = nlohmann::json::parse(line);
    if (entry["stage"] != stage || !entry.contains("validation")) continue;
    if (first < 0) first = entry["validation"];
    last = entry["validation"];
  }
  return {first, last};
}

TEST(TrainInteract, EveryStageLearnsAndTheFileHoldsAllOfThem) {
  const TempFolder folder;
  TrainRun run;
  run.data = {write_sitters(folder / "sitters")};
  run.out = folder / "model.safetensors";
  ASSERT_TRUE(train(run, small_config()));
  for (const char* stage : {"pose", "control", "contact"}) {
    const auto [first, last] = validations(run.out, stage);
    EXPECT_LT(last, 0.7 * first) << stage;
  }
  const Networks model = load_networks(run.out);
  EXPECT_FALSE(model.pose.is_empty() || model.control.is_empty() || model.contact.is_empty());

  // Teacher-forced on the motion it has learned, PoseNet gives the next frame.
  const Data data(run.data, "train", model.config, false);
  const PoseRows rows = data.pose_rows(spread_indices(data.poses(), 50));
  const torch::NoGradGuard no_grad;
  PoseNetwork pose = model.pose;
  const torch::Tensor y = model.output_scale.from_network(pose->forward(model.input_scale.to_network(rows.input)));
  const torch::Tensor joints = (y - rows.target).slice(1, 0, 264).view({-1, 22, 12}).slice(2, 0, 3);
  EXPECT_LT(joints.norm(2, 2).mean().item<double>(), 0.06);  // metres; joints move by metres
}

TEST(TrainInteract, BaselinesTrainOnTheSameRowsIntoTheSameFile) {
  const TempFolder folder;
  TrainRun run;
  run.data = {write_sitters(folder / "sitters")};
  run.out = folder / "model.safetensors";
  run.stages = {"nsm",  "nsm_rollout",  "nsm_control",  "nsm_control_rollout",
                "samp", "samp_rollout", "samp_control", "samp_control_rollout"};
  Config config = small_config();
  config.training.pose_steps = 40;
  config.training.rollout_steps = 15;
  ASSERT_TRUE(train(run, config));
  for (const std::string& stage : run.stages) {
    const auto [first, last] = validations(run.out, stage);
    EXPECT_LT(last, first) << stage;
  }
  const Networks model = load_networks(run.out);
  EXPECT_FALSE(model.nsm.is_empty() || model.nsm_control.is_empty() || model.samp.is_empty() ||
               model.samp_control.is_empty());

  // A run that goes on from this file trains one network and keeps the others.
  run.from = run.out;
  run.out = folder / "next.safetensors";
  run.stages = {"nsm_rollout"};
  config.training.rollout_steps = 3;
  ASSERT_TRUE(train(run, config));
  const Networks next = load_networks(run.out);
  const auto bias = [](const PoseNetwork& network) { return network->experts->biases[0]; };
  EXPECT_FALSE(torch::equal(bias(next.nsm), bias(model.nsm)));
  ASSERT_FALSE(next.nsm_control.is_empty() || next.samp.is_empty());
  EXPECT_TRUE(torch::equal(bias(next.nsm_control), bias(model.nsm_control)));
}

TEST(TrainInteract, RolloutsNeedANetworkToGoOnFrom) {
  const TempFolder folder;
  TrainRun run;
  run.data = {write_sitters(folder / "sitters")};
  run.out = folder / "model.safetensors";
  run.stages = {"samp_rollout"};
  EXPECT_THAT(refusal_of([&] { train(run, small_config()); }),
              testing::HasSubstr("stage samp_rollout: goes on from a network: train stage samp first, or say --from"));
}

TEST(InteractLosses, RolloutsThatGotLostCountLinearlyAndHandsCountMore) {
  const OutputLayout layout = output_layout(preset("paper"));
  const torch::Tensor right = torch::zeros({2, layout.size});
  EXPECT_NEAR(frame_loss(layout, right + 0.5, right, 4, 2).item<double>(), 0.25, 1e-6) << "the weights' mean is 1";
  EXPECT_NEAR(frame_loss(layout, right - 10, right, 1, 2).item<double>(), 2 * (20 - 2), 1e-4);
  torch::Tensor wrist = right.clone();
  wrist.slice(1, layout.joints.first + 12 * 20, layout.joints.first + 12 * 21) += 1;  // the left
  const double size = static_cast<double>(layout.size);
  EXPECT_NEAR(frame_loss(layout, wrist, right, 1, 2).item<double>(), 12 / size, 1e-6);
  EXPECT_NEAR(frame_loss(layout, wrist, right, 4, 2).item<double>(), 48 / (size + 3 * 24), 1e-6);
}

TEST(InteractLosses, AreZeroWhereThePlanIsTheTruthAndTheLine) {
  torch::manual_seed(1);
  const torch::Tensor first = torch::randn({4, 3, 56}), none = torch::zeros({4, 3, 2});
  torch::Tensor rotation = none.clone();
  rotation.select(-1, 0).fill_(1);  // no rotation
  const torch::Tensor line = torch::cat({next_lines(first, rotation), first.slice(-1, 42)}, -1);
  const torch::Tensor wanted = torch::ones({4, 3, 2});
  const ControlLosses same = control_losses(line, line, line, wanted, {});
  EXPECT_NEAR(same.total.item<double>(), 0, 1e-12);
  const torch::Tensor off = line + 0.1;
  const ControlLosses l = control_losses(off, line, line, wanted, {});
  EXPECT_NEAR(l.trajectory.item<double>(), 0.03, 1e-5);
  EXPECT_NEAR(l.first.item<double>(), 0.03, 1e-5);
  EXPECT_NEAR(l.phase.item<double>(), 0.01, 1e-5);
  EXPECT_NEAR(l.total.item<double>(), 0.1 * 0.03 + 2 * 0.03 + 5 * 0.03 + 0.02 * 0.01, 1e-5);
  // A hand without a contact does not count.
  torch::Tensor one = wanted.clone();
  one.select(-1, 0).zero_();
  torch::Tensor right_off = line.clone();
  right_off.slice(-1, 0, 21) += 1;
  EXPECT_NEAR(control_losses(right_off, line, line, one, {}).total.item<double>(), 0, 1e-12);
}

TEST(InteractLosses, TheNextLineGoesFromThePlannedHandToTheContact) {
  torch::Tensor output = torch::zeros({1, 56});
  output.slice(1, 0, 3).copy_(torch::tensor({1.F, 2.F, 0.F}));
  const torch::Tensor quarter = torch::tensor({0.F, 1.F}).view({1, 2});  // what was left is ahead's opposite now
  const torch::Tensor line = next_lines(output, quarter).view({2, 7, 3});
  EXPECT_TRUE(torch::allclose(line[0][0], torch::tensor({0.F, 2.F, -1.F}), 0, 1e-6)) << line[0][0];
  EXPECT_TRUE(torch::allclose(line[0][3], torch::tensor({0.F, 1.F, -0.5F}), 0, 1e-6));
  EXPECT_EQ(line[0][6].abs().sum().item<float>(), 0);
}

}  // namespace
}  // namespace inhabit::interact
