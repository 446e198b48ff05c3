// Protects the code of a sequence: what a GRU's cell comes to, step by step, whichever way round its batches lie.
#include "inhabit/nn/last_state.h"

#include <gtest/gtest.h>

#include "largest.h"

namespace inhabit::nn {
namespace {

using torch::Tensor;
using torch::nn::GRU;
using torch::nn::GRUOptions;

/// The same weights in the cell of a layer.
torch::nn::GRUCell cell_of(const GRU& gru, int64_t inputs, int layer) {
  torch::nn::GRUCell cell(inputs, gru->options.hidden_size());
  const auto weights = gru->named_parameters();
  const std::string of = "_l" + std::to_string(layer);
  cell->weight_ih.copy_(weights["weight_ih" + of]);
  cell->weight_hh.copy_(weights["weight_hh" + of]);
  cell->bias_ih.copy_(weights["bias_ih" + of]);
  cell->bias_hh.copy_(weights["bias_hh" + of]);
  return cell;
}

TEST(LastState, IsWhereTheCellsOfTheLastLayerEnd) {
  const torch::NoGradGuard no_gradients;
  torch::manual_seed(1);
  const Tensor x = torch::randn({3, 6, 5});
  for (const bool batch_first : {true, false})
    for (const int layers : {1, 2}) {
      GRU gru(GRUOptions(5, 4).batch_first(batch_first).num_layers(layers));
      Tensor expected, sequence = x;
      for (int layer = 0; layer < layers; ++layer) {
        torch::nn::GRUCell cell = cell_of(gru, sequence.size(2), layer);
        expected = torch::zeros({3, 4});
        std::vector<Tensor> states;
        for (int64_t t = 0; t < 6; ++t) states.push_back(expected = cell->forward(sequence.select(1, t), expected));
        sequence = torch::stack(states, 1);
      }
      const Tensor state = last_state(gru, x);
      ASSERT_EQ(state.sizes(), (torch::IntArrayRef{3, 4}));
      EXPECT_LT(largest_difference(state, expected), 1e-6) << batch_first << " " << layers;
    }
}

TEST(LastState, PassesGradientsToTheSequence) {
  torch::manual_seed(2);
  GRU gru(GRUOptions(5, 4).batch_first(true));
  const Tensor x = torch::randn({2, 3, 5}).requires_grad_(true);
  const Tensor gradient = torch::autograd::grad({last_state(gru, x).sum()}, {x})[0];
  EXPECT_GT(gradient.abs().amax(2).min().item<double>(), 0) << "of every frame";
}

}  // namespace
}  // namespace inhabit::nn
