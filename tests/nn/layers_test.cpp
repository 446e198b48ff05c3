#include "inhabit/nn/layers.h"

#include <gtest/gtest.h>
#include <torch/csrc/autograd/autograd.h>

#include "inhabit/nn/fast_point_voxel.h"
#include "inhabit/nn/grid_conv.h"
#include "inhabit/nn/gru_kernel.h"
#include "inhabit/nn/motion_attention.h"
#include "inhabit/nn/row_layers.h"
#include "inhabit/nn/trajectory_graph.h"
#include "largest.h"

using namespace inhabit;
using torch::Tensor;

namespace {

/// A grid whose voxels are mostly empty.
Tensor sparse_grid(int64_t batch, int64_t channels, int64_t grid, double fraction) {
  return torch::randn({batch, channels, grid, grid, grid}) *
         (torch::rand({batch, 1, grid, grid, grid}) < fraction).to(torch::kFloat32);
}

struct Gradients {
  Tensor value, x, weight, bias;
};

template <class F>
Gradients gradients_of(const F& f, const Tensor& x, const Tensor& weight, const Tensor& bias, const Tensor& mix) {
  std::vector<Tensor> leaves{x.detach().clone().requires_grad_(true), weight.detach().clone().requires_grad_(true),
                             bias.detach().clone().requires_grad_(true)};
  const Tensor value = f(leaves[0], leaves[1], leaves[2]);
  const auto g = torch::autograd::grad({(value * mix).sum()}, leaves);
  return {value.detach(), g[0], g[1], g[2]};
}

}  // namespace

TEST(GridConvolution, EqualsTheDenseOneInValueAndGradients) {
  torch::manual_seed(0);
  for (const int64_t grid : {2, 3, 6}) {
    const Tensor x = sparse_grid(2, 5, grid, 0.2), weight = torch::randn({4, 5, 3, 3, 3}), bias = torch::randn({4});
    const Tensor mix = torch::randn({2, 4, grid, grid, grid});
    const Gradients got = gradients_of(nn::grid_conv3d, x, weight, bias, mix);
    const Gradients dense =
        gradients_of([](const Tensor& a, const Tensor& w, const Tensor& b) { return torch::conv3d(a, w, b, 1, 1); }, x,
                     weight, bias, mix);
    EXPECT_LT(largest_difference(got.value, dense.value), 1e-4) << grid;
    EXPECT_LT(largest_difference(got.weight, dense.weight), 1e-4) << grid;
    EXPECT_LT(largest_difference(got.bias, dense.bias), 1e-4) << grid;
    const Tensor occupied = (x != 0).to(torch::kFloat32);
    EXPECT_LT(largest_difference(got.x, dense.x * occupied), 1e-4) << grid;
  }
}

TEST(GridConvolution, OverABackgroundEqualsTheDenseOne) {
  torch::manual_seed(1);
  for (const int64_t grid : {2, 3, 5}) {
    const Tensor background = torch::randn({3}), weight = torch::randn({4, 3, 3, 3, 3}), bias = torch::randn({4});
    const Tensor difference = sparse_grid(2, 3, grid, 0.1);
    const Tensor x = difference + background.view({1, 3, 1, 1, 1});
    EXPECT_LT(
        largest_difference(nn::grid_conv3d_over(background, x, weight, bias), torch::conv3d(x, weight, bias, 1, 1)),
        1e-4);
    EXPECT_LT(largest_difference(nn::grid_conv3d_over(torch::zeros({3}), x, weight, bias),
                                 torch::conv3d(x, weight, bias, 1, 1)),
              1e-4);
  }
}

// Points several to a voxel: value and gradients of features, weight and bias against the grid stored and convolved
// densely.
TEST(GridConvolution, OfPointsEqualsTheDenseOneInValueAndGradients) {
  torch::manual_seed(8);
  for (const int64_t channels : {3, 16, 37}) {  // less than a block of channels, one block, several and a rest
    const int64_t grid = 4;
    const nn::SparseMap average = nn::voxel_average(nn::voxel_coordinates(torch::randn({2, 50, 3}), grid), grid);
    const Tensor x = torch::randn({2, channels, 50}), weight = torch::randn({4, channels, 3, 3, 3}),
                 bias = torch::randn({4}), mix = torch::randn({2, 4, grid, grid, grid});
    const Gradients got = gradients_of(
        [&](const Tensor& a, const Tensor& w, const Tensor& b) { return nn::grid_conv3d_of_points(average, a, w, b); },
        x, weight, bias, mix);
    const Gradients dense = gradients_of(
        [&](const Tensor& a, const Tensor& w, const Tensor& b) {
          return torch::conv3d(nn::scatter(average, a).view({2, channels, grid, grid, grid}), w, b, 1, 1);
        },
        x, weight, bias, mix);
    EXPECT_LT(largest_difference(got.value, dense.value), 1e-4) << channels;
    EXPECT_LT(largest_difference(got.x, dense.x), 1e-4) << channels;
    EXPECT_LT(largest_difference(got.weight, dense.weight), 2e-4) << channels;
    EXPECT_LT(largest_difference(got.bias, dense.bias), 1e-4) << channels;
  }
}

// Gradients of every parameter and of the features, skipping empty voxels against not.
TEST(PointVoxelConvolution, TrainsAsTheDenseOneDoes) {
  torch::manual_seed(2);
  nn::PointVoxelConv layer(6, 8, 6);
  const Tensor points = torch::randn({3, 40, 3}) * torch::tensor({1.0F, 0.1F, 1.0F});
  const Tensor mix = torch::randn({3, 8, 40});
  std::vector<Tensor> results[2];
  for (const bool dense : {false, true}) {
    layer->dense = dense;
    layer->train();
    layer->zero_grad();
    torch::manual_seed(5);
    const Tensor features = torch::randn({3, 6, 40}).requires_grad_(true);
    const Tensor out = layer(nn::PointFeatures{features, points}).features;
    (out * mix).sum().backward();
    results[dense] = {out.detach(), features.grad()};
    for (const auto& parameter : layer->parameters()) results[dense].push_back(parameter.grad().clone());
  }
  ASSERT_EQ(results[0].size(), results[1].size());
  for (size_t i = 0; i < results[0].size(); ++i) {
    const double scale = std::max(1.0, results[1][i].abs().max().item<double>());
    EXPECT_LT(largest_difference(results[0][i], results[1][i]) / scale, 2e-4) << i;
  }
}

TEST(SetAbstraction, TakesTheLargestResponseAroundEachCentre) {
  torch::manual_seed(3);
  nn::SetAbstraction layer(4, 5, 0.9, 6, std::vector<int>{7, 3});
  layer->eval();
  torch::NoGradGuard no_gradients;
  const Tensor points = torch::randn({1, 30, 3}), features = torch::randn({1, 4, 30});
  const nn::PointFeatures got = layer(nn::PointFeatures{features, points});
  for (int64_t m = 0; m < 5; ++m) {
    Tensor best = torch::full({3}, -1.0F);
    int found = 0;
    for (int64_t n = 0; n < 30 && found < 6; ++n) {
      const Tensor offset = points[0][n] - got.points[0][m];
      if (!(offset.square().sum().item<float>() < 0.81F)) continue;
      ++found;
      const Tensor input = torch::cat({offset, features[0].select(1, n)}).view({1, 7, 1, 1});
      best = torch::maximum(best, layer->mlp(input).flatten());
    }
    EXPECT_GT(found, 0);
    EXPECT_LT(largest_difference(got.features[0].select(1, m), best), 1e-5);
  }
}

// The first layer's halves at centres and at points are the layer over both joined at the points.
TEST(FeaturePropagation, EqualsTheMlpOfJoinedFeaturesInValueAndGradients) {
  torch::manual_seed(9);
  nn::FeaturePropagation layer(5 + 3, std::vector<int>{6, 4});
  const Tensor points = torch::randn({2, 20, 3}), centres = points.slice(1, 0, 7), mix = torch::randn({2, 4, 20});
  std::vector<Tensor> results[2];
  for (const bool joined : {false, true}) {
    torch::manual_seed(10);
    const Tensor coarse = torch::randn({2, 5, 7}).requires_grad_(true),
                 fine = torch::randn({2, 3, 20}).requires_grad_(true);
    layer->zero_grad();
    const Tensor out =
        joined ? layer->mlp(torch::cat({nn::gather(nn::nearest_interpolation(points, centres), coarse), fine}, 1))
               : layer(nn::PointFeatures{coarse, centres}, nn::PointFeatures{fine, points}).features;
    (out * mix).sum().backward();
    results[joined] = {out.detach(), coarse.grad(), fine.grad()};
    for (const auto& parameter : layer->parameters()) results[joined].push_back(parameter.grad().clone());
  }
  ASSERT_EQ(results[0].size(), results[1].size());
  for (size_t i = 0; i < results[0].size(); ++i) EXPECT_LT(largest_difference(results[0][i], results[1][i]), 1e-4) << i;
}

TEST(RowProducts, GatherMultiplyAndScatterRows) {
  torch::manual_seed(4);
  for (const int64_t out : {1, 64, 70, 130}) {
    for (const int64_t count : {0, 1, 2, 5, 6, 7, 23}) {
      const int64_t in = 9;
      const Tensor w = torch::randn({in, out}), x = torch::randn({30, 12});
      const nn::PackedMatrix packed = nn::pack_matrix(w.data_ptr<float>(), in, out, out, 1);
      const Tensor from = torch::randint(30, {count}, torch::kInt32),
                   to = torch::randperm(30).slice(0, 0, count).to(torch::kInt32);
      Tensor y = torch::zeros({30, packed.stride()});
      y.slice(1, 0, out).normal_();
      Tensor expected = y.clone();
      const int64_t depth = 7;
      for (int64_t i = 0; i < count; ++i)
        expected[to[i].item<int>()].slice(0, 0, out) +=
            x[from[i].item<int>()].slice(0, 0, depth).matmul(w.slice(0, 0, depth));
      nn::accumulate_rows(packed, depth, x.data_ptr<float>(), 12, from.data_ptr<int32_t>(), to.data_ptr<int32_t>(),
                          count, y.data_ptr<float>());
      EXPECT_LT(largest_difference(y, expected), 1e-5) << out << " columns, " << count << " rows";
    }
  }
}

TEST(RowGru, EqualsTheModule) {
  torch::manual_seed(5);
  torch::nn::GRU gru(5, 6);
  torch::nn::Linear encode(4, 5);
  torch::NoGradGuard no_gradients;
  const Tensor x = torch::randn({11, 4});
  std::vector<float> state(6);
  nn::last_gru_state(nn::row_layer(encode->weight, encode->bias), nn::row_gru(*gru), x.data_ptr<float>(), 11,
                     state.data());
  const Tensor expected = std::get<1>(gru->forward(encode(x).unsqueeze(1))).flatten();
  EXPECT_LT(largest_difference(torch::from_blob(state.data(), {6}), expected), 1e-6);
}

TEST(GruUpdate, IsTheTextbooksForEveryWidthAndSize) {
  torch::manual_seed(6);
  for (int64_t hidden = 1; hidden <= 70; ++hidden)
    for (const double size : {1.0, 10.0, 100.0}) {
      const Tensor in = size * torch::randn({3 * hidden}), rec = size * torch::randn({3 * hidden}),
                   state = torch::rand({hidden}) * 2 - 1;
      const auto gate = [&](const Tensor& half, int64_t i) {
        return half.slice(0, i * hidden, (i + 1) * hidden).to(torch::kFloat64);
      };
      const Tensor reset = (gate(in, 0) + gate(rec, 0)).sigmoid(), keep = (gate(in, 1) + gate(rec, 1)).sigmoid(),
                   candidate = (gate(in, 2) + reset * gate(rec, 2)).tanh();
      const Tensor expected = (1 - keep) * candidate + keep * state;
      Tensor next = torch::empty({hidden});
      nn::gru_update(hidden, in.data_ptr<float>(), rec.data_ptr<float>(), state.data_ptr<float>(),
                     next.data_ptr<float>());
      // The gates' sums are rounded to float before they are used: by some 1e-7 of their size.
      EXPECT_LT(largest_difference(next, expected), 1e-6 + 5e-7 * size) << hidden << " wide, gates of " << size;
      const Tensor in_place = state.clone();
      nn::gru_update(hidden, in.data_ptr<float>(), rec.data_ptr<float>(), in_place.data_ptr<float>(),
                     in_place.data_ptr<float>());
      EXPECT_TRUE(torch::equal(in_place, next)) << hidden;
    }
}

TEST(GruUpdate, SaturatesWithoutNan) {
  const int64_t hidden = 37;
  for (const float reset : {-1e30F, 0.0F, 1e30F})
    for (const float keep : {-1e30F, 1e30F})
      for (const float candidate : {-1e30F, 1e30F}) {
        const Tensor in = torch::cat(
                         {torch::full({hidden}, reset), torch::full({hidden}, keep), torch::full({hidden}, candidate)}),
                     rec = torch::zeros({3 * hidden}), state = torch::full({hidden}, 0.25F);
        Tensor next = torch::empty({hidden});
        nn::gru_update(hidden, in.data_ptr<float>(), rec.data_ptr<float>(), state.data_ptr<float>(),
                       next.data_ptr<float>());
        const float expected = keep > 0 ? 0.25F : candidate > 0 ? 1.0F : -1.0F;
        EXPECT_LT((next - expected).abs().max().item<double>(), 1e-6) << reset << " " << keep << " " << candidate;
      }
}

TEST(TrajectoryGraph, RepeatsTheLastFrameWhereTheNetworkAddsNothing) {
  const torch::NoGradGuard no_gradients;
  torch::manual_seed(7);
  nn::TrajectoryGraph network(9, 8, 5, 12, 2);
  network->eval();
  const Tensor past = torch::randn({3, 8, 9});
  EXPECT_EQ(network->forward(past).sizes(), (torch::IntArrayRef{3, 5, 9}));
  EXPECT_GT(largest_difference(network->forward(past), past.slice(1, 7).expand({-1, 5, -1})), 0.01);
  network->out->weight.zero_();
  network->out->bias.zero_();
  EXPECT_LT(largest_difference(network->forward(past), past.slice(1, 7).expand({-1, 5, -1})), 1e-5);
}

TEST(MotionAttention, GoesOnAsWhatWasMostAlikeDid) {
  const torch::NoGradGuard no_gradients;
  torch::manual_seed(9);
  nn::MotionAttention network(9, 6, 4, 12, 2);
  network->eval();
  const Tensor past = torch::randn({3, 40, 9});
  EXPECT_EQ(network->forward(past).sizes(), (torch::IntArrayRef{3, 4, 9}));
  EXPECT_EQ(network->attention(past).sizes(), (torch::IntArrayRef{3, 31}));
  EXPECT_LT(largest_difference(network->attention(past).sum(1), torch::ones({3})), 1e-5);
  const Tensor once = network->forward(past), twice = network->continued(past, 7);
  EXPECT_LT(
      largest_difference(twice, torch::cat({once, network->forward(torch::cat({past, once}, 1)).slice(1, 0, 3)}, 1)),
      1e-6)
      << "goes on after what it said itself";
  // Queries that are alike alone where they are the same: each frame tells which it is, of a period of 15.
  const int64_t period = 15, frames = 50;
  nn::MotionAttention planted(period, 6, 4, period, 1);
  planted->eval();
  for (const torch::nn::Sequential& part : {planted->query_network, planted->key_network}) {
    for (Tensor& p : part->parameters()) p.zero_();
    // The last frame of six: through both kernels, channel by channel.
    Tensor first = part->ptr(0)->as<torch::nn::Conv1d>()->weight,
           second = part->ptr(2)->as<torch::nn::Conv1d>()->weight;
    for (int64_t k = 0; k < period; ++k) first[k][k][first.size(2) - 1] = second[k][k][second.size(2) - 1] = 1;
  }
  planted->out->weight.zero_();
  planted->out->bias.zero_();
  const Tensor cyclic = torch::eye(period).repeat({4, 1}).slice(0, 0, frames).unsqueeze(0);
  const Tensor counted = planted->attention(cyclic)[0];  // what ends at frame 5 + n is like what ends at 49
  for (int64_t n = 0; n < counted.size(0); ++n)
    EXPECT_NEAR(counted[n].item<double>(), (n + 5) % period == 49 % period ? 1.0 / 2 : 0, 1e-5) << n;
  EXPECT_LT(largest_difference(planted->forward(cyclic), cyclic.slice(1, frames - 1).expand({-1, 4, -1})), 1e-5)
      << "the graph network adds nothing: the last frame repeated";
  // It sees what followed: another continuation of what was alike, another forecast.
  Tensor other = cyclic.clone();
  other.slice(1, 35, 38).add_(1);  // after one of the two
  nn::MotionAttention whole(period, 6, 4, period, 1);
  whole->eval();
  EXPECT_GT(largest_difference(whole->forward(other), whole->forward(cyclic)), 1e-4);
}

TEST(TrajectoryGraph, GradientsReachEveryParameterAndFarCoordinates) {
  torch::manual_seed(8);
  nn::TrajectoryGraph network(9, 8, 5, 12, 2);
  const Tensor past = torch::randn({6, 8, 9}).requires_grad_(true);
  const Tensor future = network->forward(past);
  (future * torch::randn({6, 5, 9})).sum().backward();
  for (const auto& parameter : network->named_parameters()) {
    ASSERT_TRUE(parameter.value().grad().defined()) << parameter.key();
    EXPECT_GT(parameter.value().grad().abs().max().item<double>(), 0) << parameter.key();
  }
  network->eval();  // the learned graph joins every coordinate with every other
  const Tensor one = torch::randn({1, 8, 9}).requires_grad_(true);
  const Tensor slope = torch::autograd::grad({network->forward(one).select(2, 0).sum()}, {one})[0];
  EXPECT_GT(slope.abs().amax(1).min().item<double>(), 0);
}
