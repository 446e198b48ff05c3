// Protects the fast denoiser: it says what the network says, whatever parts there are, batch, length and threads.
#include "inhabit/inbetween/fast_denoiser.h"

#include <ATen/Parallel.h>
#include <gtest/gtest.h>

#include "inbetween/small_network.h"
#include "inhabit/inbetween/residual_input.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

void expect_same(const Tensor& got, const Tensor& expected) {
  ASSERT_EQ(got.sizes(), expected.sizes());
  EXPECT_LT((got - expected).abs().max().item<double>(), 2e-5 * expected.abs().max().item<double>());
}

Tensor fast_through(FastDenoiser& fast, Denoiser network, const NetworkInput& in) {
  return fast.forward(in.x, in.mask, network->embed_offsets(in.offsets, in.keys), in.steps,
                      network->embed_scene(in.occupancy) + network->embed_shape(in.shape));
}

TEST(FastDenoiser, SaysWhatTheNetworkSays) {
  const torch::NoGradGuard no_gradients;
  const int before = at::get_num_threads();
  for (const std::vector<int>& multipliers : {std::vector<int>{1, 2}, {2, 2, 2}, {1, 2, 3, 2}}) {
    for (const bool parts : {true, false}) {
      Config c = small_inbetween_config();
      c.width = 24;  // neither the vectors' nor the column blocks' multiple
      c.multipliers = multipliers;
      c.local_scene = parts;
      c.partial_keys = parts;
      Denoiser network = untrained(c);
      FastDenoiser fast(network);
      for (const int threads : {1, 3}) {
        at::set_num_threads(threads);
        for (const int64_t batch : {1, 3}) {
          SCOPED_TRACE(std::to_string(multipliers.size()) + " levels, " + std::to_string(batch) + " clips, " +
                       std::to_string(threads) + " threads");
          const NetworkInput in(c, batch);
          expect_same(fast_through(fast, network, in), in.through(network));
        }
      }
    }
  }
  at::set_num_threads(before);
}

TEST(FastDenoiser, SaysWhatTheNetworkOfResidualMotionSays) {
  const torch::NoGradGuard no_gradients;
  Config c = small_inbetween_config();
  c.residual = true;
  c.global_scene = c.local_scene = false;
  Denoiser network = untrained(c);
  FastDenoiser fast(network);
  const Tensor input = torch::randn({2, kResidualChannels, c.frames}), bones = torch::rand({2, kBoneFeatures});
  const Tensor embedding = network->embed_shape(bones);
  expect_same(fast.residual(input, 7, embedding),
              network->residual(input, torch::full({2}, 7, torch::kInt64), embedding));
  expect_same(fast.features(), network->features(input, torch::full({2}, 7, torch::kInt64), embedding));
}

TEST(FastDenoiser, ForgetsTheLastClip) {
  const torch::NoGradGuard no_gradients;
  Config c = small_inbetween_config();
  Denoiser network = untrained(c);
  FastDenoiser fast(network);
  for (const int frames : {16, 9, 13}) {  // a longer clip before a shorter one leaves nothing behind its end
    Config of_length = c;
    of_length.frames = frames;
    const NetworkInput in(of_length, 2);
    expect_same(fast_through(fast, network, in), in.through(network));
  }
}

TEST(FastDenoiser, GuidesAsTwoCallsDo) {
  const torch::NoGradGuard no_gradients;
  const Config c = small_inbetween_config();
  Denoiser network = untrained(c);
  FastDenoiser fast(network);
  const NetworkInput in(c, 2);
  const Tensor local = network->embed_offsets(in.offsets, in.keys), scene = network->embed_scene(in.occupancy),
               shape = network->embed_shape(in.shape), steps = torch::full({2}, 17, torch::kInt64);
  const Tensor with = network->forward(in.x, in.mask, local, steps, scene + shape),
               without = network->forward(in.x, in.mask, local, steps, shape);
  expect_same(fast.guided(in.x, in.mask, local, 17, scene, shape, 2.5), without + 2.5 * (with - without));
}

}  // namespace
}  // namespace inhabit::inbetween
