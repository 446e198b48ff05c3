// Protects the denoiser: shapes with every part there or left out, gradients that reach every parameter, inputs that
// all matter where they should and nowhere else.
#include "inhabit/inbetween/network.h"

#include <gtest/gtest.h>

#include "gradients.h"
#include "inbetween/small_network.h"
#include "largest.h"

namespace inhabit::inbetween {
namespace {

using torch::Tensor;

TEST(Denoiser, ShapesHoldWhateverPartsThereAre) {
  const torch::NoGradGuard no_gradients;
  for (int parts = 0; parts < 16; ++parts) {
    SCOPED_TRACE(parts);
    Config c = small_inbetween_config();
    c.global_scene = parts & 1;
    c.local_scene = parts & 2;
    c.body_shape = parts & 4;
    c.partial_keys = parts & 8;
    Denoiser network = untrained(c);
    const NetworkInput in(c, 3);
    EXPECT_EQ(network->embed_scene(in.occupancy).sizes(), (std::vector<int64_t>{3, c.width}));
    EXPECT_EQ(network->embed_shape(in.shape).sizes(), (std::vector<int64_t>{3, c.width}));
    EXPECT_EQ(network->embed_offsets(in.offsets, in.keys).sizes(),
              (std::vector<int64_t>{3, c.local_scene ? kLocalChannels : 0, c.frames}));
    EXPECT_EQ(in.through(network).sizes(), in.x.sizes());
    // A part that is left out takes no notice.
    EXPECT_EQ(largest(network->embed_scene(in.occupancy)) > 0, c.global_scene);
    EXPECT_EQ(largest(network->embed_shape(in.shape)) > 0, c.body_shape);
    bool scene = false, shape = false, local = false;
    for (const auto& p : network->named_parameters()) {
      scene |= p.key().rfind("scene_embedding", 0) == 0;
      shape |= p.key().rfind("beta_process", 0) == 0;
      local |= p.key().rfind("cond_process", 0) == 0;
    }
    EXPECT_EQ(scene, c.global_scene);
    EXPECT_EQ(shape, c.body_shape);
    EXPECT_EQ(local, c.local_scene);
  }
}

TEST(Denoiser, GradientsReachEveryParameter) {
  Config c = small_inbetween_config();
  c.partial_keys = true;
  Denoiser network = untrained(c);
  const NetworkInput in(c, 2);
  (in.through(network) - in.x).square().mean().backward();
  expect_gradients_everywhere(*network);
}

TEST(Denoiser, StartsWithoutAnOpinion) {
  torch::manual_seed(1);
  const Config c = small_inbetween_config();
  EXPECT_EQ(largest(NetworkInput(c, 2).through(Denoiser(c))), 0);
}

TEST(Denoiser, EveryInputMatters) {
  const torch::NoGradGuard no_gradients;
  const Config c = small_inbetween_config();
  Denoiser network = untrained(c);
  const NetworkInput in(c, 2);
  const Tensor before = in.through(network);
  const auto changed_by = [&](const auto& change) {
    NetworkInput other = in;
    change(other);
    return largest(other.through(network) - before);
  };
  EXPECT_GT(changed_by([](auto& i) { i.x = i.x + 0.1; }), 1e-4);
  EXPECT_GT(changed_by([](auto& i) { i.mask = 1 - i.mask; }), 1e-4);
  EXPECT_GT(changed_by([](auto& i) { i.occupancy = -i.occupancy; }), 1e-4);
  EXPECT_GT(changed_by([](auto& i) { i.shape = i.shape + 0.3; }), 1e-4);
  EXPECT_GT(changed_by([](auto& i) { i.steps = (i.steps + 17) % 50; }), 1e-4);
  EXPECT_GT(changed_by([](auto& i) { i.offsets = i.offsets * (1 + i.keys).unsqueeze(1).unsqueeze(1); }), 1e-4);
  // Offsets are seen at key frames only.
  EXPECT_EQ(changed_by([](auto& i) { i.offsets = i.offsets * (1 + 5 * (1 - i.keys)).unsqueeze(1).unsqueeze(1); }), 0);
}

TEST(Denoiser, AScenesPlaceMatters) {
  const torch::NoGradGuard no_gradients;
  const Config c = small_inbetween_config();
  Denoiser network = untrained(c);
  const Tensor free = torch::full({1, 24, 48, 48}, -1.F);
  Tensor ahead = free.clone(), behind = free.clone();
  ahead.slice(3, 30, 40).slice(2, 20, 28).fill_(1);
  behind.slice(3, 8, 18).slice(2, 20, 28).fill_(1);
  EXPECT_GT(largest(network->embed_scene(ahead) - network->embed_scene(behind)), 1e-3);
}

TEST(Denoiser, SamplesOfABatchDoNotSeeEachOther) {
  const torch::NoGradGuard no_gradients;
  const Config c = small_inbetween_config();
  Denoiser network = untrained(c);
  const NetworkInput in(c, 3);
  NetworkInput one = in;
  for (Tensor* t : {&one.x, &one.mask, &one.occupancy, &one.offsets, &one.keys, &one.shape, &one.steps})
    *t = t->slice(0, 1, 2);
  EXPECT_LT(largest(in.through(network)[1] - one.through(network)[0]), 1e-4);
}

}  // namespace
}  // namespace inhabit::inbetween
