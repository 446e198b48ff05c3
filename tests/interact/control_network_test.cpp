// Protects ControlNet: frames one by one give what the sequence gives, and its LSTM is the textbook's.
#include "inhabit/interact/control_network.h"

#include <gtest/gtest.h>

#include "interact/small_networks.h"
#include "largest.h"

namespace inhabit::interact {
namespace {

using torch::Tensor;

TEST(ControlNetwork, StepsGiveTheSequence) {
  const torch::NoGradGuard no_gradients;
  ControlNetwork network = untrained_networks(small_interact_config()).control;
  const Tensor pose = torch::randn({9, 2, 66}), control = torch::randn({9, 2, 56});
  ControlState whole = network->start(2), step = network->start(2);
  const Tensor expected = network->forward(pose, control, whole);
  ASSERT_EQ(expected.sizes(), control.sizes());
  for (int64_t t = 0; t < 9; ++t)
    EXPECT_LT(largest_difference(network->step(pose[t], control[t], step), expected[t]), 1e-6) << t;
  EXPECT_LT(largest_difference(step.cell, whole.cell), 1e-6);
  EXPECT_LT(largest_difference(step.hidden, whole.hidden), 1e-6);
}

TEST(ControlNetwork, IsTheEquations) {
  const torch::NoGradGuard no_gradients;
  ControlNetwork network = untrained_networks(small_interact_config()).control;
  network->h0.uniform_(-1, 1);
  network->c0.uniform_(-1, 1);
  const auto p = network->named_parameters();
  const auto linear = [&](const std::string& name, const Tensor& x) {
    return p[name + ".weight"].matmul(x) + p[name + ".bias"];
  };
  const auto encode = [&](const std::string& name, const Tensor& x) {
    const auto leaky = [](const Tensor& h) { return torch::where(h > 0, h, 0.05 * h); };
    return leaky(linear(name + ".2", leaky(linear(name + ".0", x))));
  };
  const Tensor pose = torch::randn({66}), control = torch::randn({56});
  Tensor x = torch::cat({encode("encoder1", pose), encode("encoder2", control)});
  for (const int64_t layer : {0, 1}) {
    const std::string l = std::to_string(layer);
    const Tensor gates = (p["rnn.weight_ih_l" + l].matmul(x) + p["rnn.bias_ih_l" + l] +
                          p["rnn.weight_hh_l" + l].matmul(network->h0[layer][0]) + p["rnn.bias_hh_l" + l])
                             .view({4, -1});
    const Tensor cell = torch::sigmoid(gates[1]) * network->c0[layer][0] + torch::sigmoid(gates[0]) * gates[2].tanh();
    x = torch::sigmoid(gates[3]) * cell.tanh();
  }
  ControlState state = network->start(1);
  const Tensor got = network->step(pose.unsqueeze(0), control.unsqueeze(0), state);
  EXPECT_LT(largest_difference(got[0], linear("fc", x)), 1e-5);
}

TEST(ControlNetwork, HasThePapersSizes) {
  const ControlNetwork network(preset("paper"));
  const auto p = network->named_parameters();
  EXPECT_EQ(p["rnn.weight_ih_l0"].sizes(), at::IntArrayRef({4 * 512, 2 * 128}));
  EXPECT_EQ(p["rnn.weight_hh_l1"].sizes(), at::IntArrayRef({4 * 512, 512}));
  EXPECT_EQ(p["encoder2.0.weight"].sizes(), at::IntArrayRef({128, 56}));
  EXPECT_EQ(p["fc.weight"].sizes(), at::IntArrayRef({56, 512}));
}

}  // namespace
}  // namespace inhabit::interact
