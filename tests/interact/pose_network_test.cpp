// Protects PoseNet and SAMP's network: rows have the paper's parts, blended outputs are those of blended weights, each
// part of a row reaches what it is for.
#include "inhabit/interact/pose_network.h"

#include <gtest/gtest.h>

#include "interact/small_networks.h"
#include "largest.h"

namespace inhabit::interact {
namespace {

using torch::Tensor;

TEST(PoseNetwork, RowsHaveThePapersParts) {
  const PoseSizes s = pose_sizes(preset("paper"));
  EXPECT_EQ(s.inputs, (std::vector<int64_t>{355, 117, 1408, 2048, 104}));
  EXPECT_EQ(s.row, 4344);
  EXPECT_EQ(s.gating, 416);
  EXPECT_EQ(s.outputs, 536);
  const PoseSizes plain = nsm_sizes(preset("paper"), false), contacts = nsm_sizes(preset("paper"), true);
  EXPECT_EQ(plain.inputs, (std::vector<int64_t>{355, 117, 1408, 2048}));
  EXPECT_EQ(plain.row, 4344 - 104);
  EXPECT_EQ(plain.gating, 312);
  EXPECT_EQ(contacts.inputs[1], 117 + 8);
  EXPECT_EQ(contacts.row, plain.row + 8);
  Config released;
  released.ego_rings = released.ego_layers = 9;
  EXPECT_EQ(pose_sizes(released).row, 4970);
}

/// The network as the paper has it: weights are blended, then one network of them is run, sample by sample.
Tensor with_blended_weights(PoseNetwork network, const Tensor& x) {
  const Tensor gates = network->gates(x);
  std::vector<Tensor> rows;
  for (int64_t b = 0; b < x.size(0); ++b) {
    std::vector<Tensor> codes;
    int64_t first = 0;
    for (size_t i = 0; i < network->encoders.size(); ++i) {
      const int64_t width = network->sizes.inputs[i];
      codes.push_back(network->encoders[i]->forward(x.slice(0, b, b + 1).slice(1, first, first + width)));
      first += width;
    }
    Tensor h = torch::cat(codes, 1)[0];
    for (size_t layer = 0; layer < 3; ++layer) {
      const Tensor w = torch::einsum("e,eoi->oi", {gates[b], network->experts->weights[layer]});
      h = w.mv(h) + gates[b].matmul(network->experts->biases[layer]);
      if (layer < 2) h = torch::elu(h);
    }
    rows.push_back(h);
  }
  return torch::stack(rows);
}

TEST(PoseNetwork, BlendsWeights) {
  const torch::NoGradGuard no_gradients;
  const Networks n = untrained_networks(small_interact_config());
  for (PoseNetwork network : {n.pose, n.nsm, n.nsm_control}) {
    for (auto& bias : network->experts->biases) bias.uniform_(-1, 1);
    const Tensor x = 3 * torch::randn({5, network->sizes.row});
    const Tensor y = network->forward(x), expected = with_blended_weights(network, x);
    EXPECT_LT(largest_difference(y, expected), 1e-5 * largest(expected));
    const Tensor gates = network->gates(x);
    EXPECT_LT(largest_difference(gates.sum(1), torch::ones({5})), 1e-6);
    EXPECT_GT(largest_difference(gates[0], gates[1]), 1e-3) << "experts are chosen by what is seen";
    EXPECT_LT(largest_difference(network->forward(x.slice(0, 2, 3)), y.slice(0, 2, 3)), 1e-5) << "any batch";
  }
}

TEST(PoseNetwork, SeesEveryPartOfARow) {
  const torch::NoGradGuard no_gradients;
  const Networks n = untrained_networks(small_interact_config());
  PoseNetwork network = n.pose;
  const PoseSizes& s = network->sizes;
  const Tensor x = torch::randn({1, s.row}), y = network->forward(x), gates = network->gates(x);
  for (int64_t i = 0; i < s.row; ++i) {
    Tensor other = x.clone();
    other[0][i] += 3;
    EXPECT_GT(largest_difference(network->forward(other), y), 0) << i;
    EXPECT_EQ(largest_difference(network->gates(other), gates) > 0, i >= s.row - s.gating) << i;
  }
}

TEST(PoseNetwork, DropsOutInTrainingAlone) {
  const torch::NoGradGuard no_gradients;
  const Networks n = untrained_networks(small_interact_config());
  PoseNetwork network = n.pose;
  const Tensor x = torch::randn({2, network->sizes.row});
  EXPECT_TRUE(torch::equal(network->forward(x), network->forward(x)));
  network->train();
  EXPECT_FALSE(torch::equal(network->forward(x), network->forward(x)));
}

TEST(SampNetwork, DrawsFromWhatItReads) {
  const torch::NoGradGuard no_gradients;
  const Config c = small_interact_config();
  const Networks n = untrained_networks(c);
  for (const bool contacts : {false, true}) {
    SampNetwork network = contacts ? n.samp_control : n.samp;
    const PoseSizes rows = nsm_sizes(c, contacts);
    ASSERT_EQ(network->row, rows.row);
    const Tensor x = torch::randn({3, rows.row}), next = torch::randn({3, rows.outputs});
    const nn::LatentDistribution q = network->encode(next, x);
    EXPECT_EQ(q.mean.sizes(), at::IntArrayRef({3, c.baselines.samp_z}));
    const Tensor z = q.sample(torch::randn_like(q.mean)), y = network->decode(z, x);
    EXPECT_EQ(y.sizes(), next.sizes());
    EXPECT_GT(largest_difference(network->decode(z + 1, x), y), 1e-3);
    const int64_t ego = rows.inputs[0] + rows.inputs[1], chair = ego + rows.inputs[2], end = chair + rows.inputs[3];
    for (const auto& [first, last, read] :
         {std::tuple(int64_t{0}, ego, true), {ego, chair, false}, {chair, end, true}, {end, rows.row, false}}) {
      Tensor other = x.clone();
      other.slice(1, first, last) += 1;
      EXPECT_EQ(largest_difference(network->decode(z, other), y) > 0, read) << first;
    }
  }
}

}  // namespace
}  // namespace inhabit::interact
