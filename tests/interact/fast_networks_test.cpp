// Protects the fast evaluations: they say what the networks say to 1e-4, for any number of people, at every level of
// vector instructions, from several threads, and they allocate nothing once warm.
#include <gtest/gtest.h>

#include <ATen/Parallel.h>

#include <thread>

#include "inhabit/interact/fast_control_network.h"
#include "inhabit/interact/fast_pose_network.h"
#include "interact/small_networks.h"
#include "largest.h"
#include "simd_levels.h"

namespace inhabit::interact {
namespace {

using torch::Tensor;

double relative_difference(const Tensor& got, const Tensor& expected) {
  return largest_difference(got, expected) / largest(expected);
}

/// Networks' biases are made as large as trained ones are.
Networks networks_of(const Config& config) {
  const torch::NoGradGuard no_gradients;
  Networks n = untrained_networks(config);
  for (PoseNetwork network : {n.pose, n.nsm, n.nsm_control})
    for (auto& bias : network->experts->biases) bias.uniform_(-0.5, 0.5);
  n.control->h0.uniform_(-0.5, 0.5);
  n.control->c0.uniform_(-1, 1);
  return n;
}

TEST(FastPoseNetwork, SaysWhatTheNetworkSays) {
  const torch::NoGradGuard no_gradients;
  const int before = at::get_num_threads();
  for (const int layers : {1, 2, 4}) {
    Config c = small_interact_config();
    c.encoder_layers = layers;
    c.hidden = 130;  // more than two blocks of columns and one of inputs
    const Networks n = networks_of(c);
    for (PoseNetwork network : {n.pose, n.nsm, n.nsm_control}) {
      const FastPoseNetwork fast(network);
      for (const int64_t rows : {1, 2, 5, 9, 48, 100}) {
        const Tensor x = 2 * torch::randn({rows, network->sizes.row});
        for (const int threads : {1, 3}) {
          at::set_num_threads(threads);
          EXPECT_LT(relative_difference(fast.forward(x), network->forward(x)), 1e-4)
              << layers << " layers, " << rows << " rows, " << threads << " threads";
        }
      }
    }
  }
  at::set_num_threads(before);
}

TEST(FastPoseNetwork, SaysItAtThePresetsSizes) {
  const torch::NoGradGuard no_gradients;
  for (const char* name : {"compact", "paper"}) {
    for (const bool trained : {false, true}) {
      torch::manual_seed(2);
      PoseNetwork network(pose_sizes(preset(name)));
      network->eval();
      // Training leaves few large weights and many small ones: as many as of a Laplace distribution.
      for (const auto& p : network->parameters())
        if (trained && p.dim() > 1) p.mul_(torch::empty_like(p).exponential_().div_(std::sqrt(2.0)));
      const FastPoseNetwork fast(network);
      const Tensor x = torch::randn({7, network->sizes.row});
      const double error = relative_difference(fast.forward(x), network->forward(x));
      std::cout << name << (trained ? ", as if trained: " : ": ") << error << "\n";
      EXPECT_LT(error, 8e-5) << name;  // some to spare for other weights
      EXPECT_LT(largest_difference(fast.forward(x.slice(0, 3, 4)), fast.forward(x).slice(0, 3, 4)), 1e-5);
    }
  }
}

TEST(FastPoseNetwork, LeavesOutExpertsThatDoNotCount) {
  const torch::NoGradGuard no_gradients;
  const Networks n = networks_of(small_interact_config());
  PoseNetwork network = n.pose;
  network->gating->fc2->bias[1] = -20;  // e^-20 = 2e-9
  const Tensor x = torch::randn({4, network->sizes.row}), expected = network->forward(x);
  EXPECT_LT(relative_difference(FastPoseNetwork(network).forward(x), expected), 1e-4);
  network->experts->weights[0][1] *= 1e30;  // would be seen if it were read
  EXPECT_LT(relative_difference(FastPoseNetwork(network).forward(x), expected), 1e-4);
}

/// Which layers are kept in floats is told by their weights.
TEST(PackedExperts, UnevenWeightsStayFloats) {
  torch::manual_seed(6);
  const Tensor bias = torch::randn({2, 70}), x = torch::randn({3, 200}), gates = torch::rand({3, 2});
  for (const bool uneven : {false, true}) {
    Tensor weight = torch::randn({2, 70, 200});
    if (uneven) weight *= torch::randn_like(weight).pow(5);
    const PackedExperts packed = pack_experts(weight.data_ptr<float>(), bias.data_ptr<float>(), 2, 70, 200);
    EXPECT_EQ(packed.floats, uneven);
    Tensor y = torch::full({3, 80}, 7.0F);  // rows longer than the layer's: what lies behind stays
    for (int64_t block = 0; block < packed.blocks(); ++block)
      expert_products(packed, block, x.data_ptr<float>(), 200, gates.data_ptr<float>(), 2, 3, Activation::kElu,
                      y.data_ptr<float>() + block * kExpertColumns, 80);
    const Tensor each = torch::einsum("bi,eoi->beo", {x, weight}) + bias;
    const Tensor expected = torch::elu((each * gates.unsqueeze(2)).sum(1));
    EXPECT_LT(relative_difference(y.slice(1, 0, 70), expected), uneven ? 1e-6 : 4e-5);
    EXPECT_EQ(largest_difference(y.slice(1, 70), torch::full({3, 10}, 7.0F)), 0);
  }
}

TEST(FastPoseNetwork, WeightsOfAnySizeStayPrecise) {
  const torch::NoGradGuard no_gradients;
  const Networks n = networks_of(small_interact_config());
  PoseNetwork network = n.pose;
  for (const auto& module : network->encoders[3]->children())
    if (auto* linear = module->as<torch::nn::LinearImpl>()) linear->weight[0] *= 300;  // one column large, others not
  network->experts->weights[2][0].zero_();
  const Tensor x = torch::randn({4, network->sizes.row});
  EXPECT_LT(relative_difference(FastPoseNetwork(network).forward(x), network->forward(x)), 1e-4);
}

TEST(FastPoseNetwork, IsTheSameAtAllLevelsAndFromSeveralThreads) {
  const torch::NoGradGuard no_gradients;
  Config c = small_interact_config();
  c.hidden = 130;
  const FastPoseNetwork fast(networks_of(c).pose);
  const Tensor x = torch::randn({11, fast.sizes().row});
  expect_same_at_all_levels([&] { return fast.forward(x); }, 1e-5, "frames");
  const Tensor expected = fast.forward(x);
  std::vector<std::thread> threads;
  std::vector<double> errors(4, 1);
  for (size_t t = 0; t < errors.size(); ++t)
    threads.emplace_back([&, t] {
      double most = 0;
      for (int i = 0; i < 20; ++i) most = std::max(most, largest_difference(fast.forward(x), expected));
      errors[t] = most;
    });
  for (auto& thread : threads) thread.join();
  for (const double error : errors) EXPECT_EQ(error, 0);
}

TEST(FastPoseNetwork, KeepsItsWorkspace) {
  const torch::NoGradGuard no_gradients;
  const FastPoseNetwork fast(networks_of(small_interact_config()).pose);
  FastPoseNetwork::Workspace workspace;
  const Tensor x = torch::randn({60, fast.sizes().row}), expected = fast.forward(x);
  Tensor y = torch::empty({60, fast.sizes().outputs});
  const float* before = nullptr;
  for (const int64_t rows : {60, 1, 7, 60}) {  // fewer rows than before leave nothing behind
    y.zero_();
    fast.forward(x.data_ptr<float>(), rows, y.data_ptr<float>(), workspace);
    EXPECT_TRUE(torch::equal(y.slice(0, 0, rows), expected.slice(0, 0, rows)) ||
                largest_difference(y.slice(0, 0, rows), expected.slice(0, 0, rows)) < 1e-6);
    EXPECT_TRUE(before == nullptr || workspace.layers.data() == before) << "no new memory";
    before = workspace.layers.data();
  }
}

/// `frames` steps of both, the largest relative difference.
double control_difference(ControlNetwork network, int64_t rows, int64_t frames) {
  const FastControlNetwork fast(network);
  FastControlNetwork::Workspace workspace;
  Tensor state = torch::empty({rows, fast.state_size()}), out = torch::empty({rows, fast.control_size()});
  for (int64_t r = 0; r < rows; ++r) fast.start(state[r].data_ptr<float>());
  ControlState plain = network->start(rows);
  double most = 0;
  for (int64_t t = 0; t < frames; ++t) {
    const Tensor pose = torch::randn({rows, fast.pose_size()}), control = torch::randn({rows, fast.control_size()});
    const Tensor expected = network->step(pose, control, plain);
    fast.step(pose.data_ptr<float>(), control.data_ptr<float>(), rows, state.data_ptr<float>(), out.data_ptr<float>(),
              workspace);
    most = std::max(most, relative_difference(out, expected));
  }
  const Tensor layers = state.view({rows, 2, plain.hidden.size(0), -1}).permute({1, 2, 0, 3});
  most = std::max(most, largest_difference(layers[0], plain.hidden));
  return std::max(most, relative_difference(layers[1], plain.cell));
}

TEST(FastControlNetwork, SaysWhatTheNetworkSaysFrameAfterFrame) {
  const torch::NoGradGuard no_gradients;
  const int before = at::get_num_threads();
  for (const int threads : {1, 3}) {
    at::set_num_threads(threads);
    for (const int layers : {1, 2, 3}) {
      Config c = small_interact_config();
      c.control_encoder = 70;
      c.control_layers = layers;
      const Networks n = networks_of(c);
      for (const int64_t rows : {1, 5, 60}) EXPECT_LT(control_difference(n.control, rows, 60), 1e-4) << rows;
    }
  }
  at::set_num_threads(before);
  for (const char* name : {"compact", "paper"}) {
    torch::manual_seed(3);
    const double error = control_difference(ControlNetwork(preset(name)), 3, 60);
    std::cout << name << ": " << error << "\n";
    EXPECT_LT(error, 1e-4) << name;
  }
}

TEST(FastControlNetwork, IsTheSameAtAllLevels) {
  const torch::NoGradGuard no_gradients;
  const FastControlNetwork fast(networks_of(small_interact_config()).control);
  const Tensor pose = torch::randn({2, fast.pose_size()}), control = torch::randn({2, fast.control_size()});
  const auto stepped = [&] {
    FastControlNetwork::Workspace workspace;
    Tensor state = torch::empty({2, fast.state_size()}), out = torch::empty({2, fast.control_size()});
    for (int64_t r = 0; r < 2; ++r) fast.start(state[r].data_ptr<float>());
    for (int t = 0; t < 5; ++t)
      fast.step(pose.data_ptr<float>(), control.data_ptr<float>(), 2, state.data_ptr<float>(), out.data_ptr<float>(),
                workspace);
    return torch::cat({out, state}, 1);
  };
  expect_same_at_all_levels(stepped, 1e-5, "control");
}

}  // namespace
}  // namespace inhabit::interact
