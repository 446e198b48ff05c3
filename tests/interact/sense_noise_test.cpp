// Protects the noise on what is sensed in training: occupancies change and nothing else does, the same in every frame
// of a rollout.
#include "inhabit/interact/sense_noise.h"

#include <gtest/gtest.h>

#include "inhabit/interact/rollout.h"
#include "interact/sitter_data.h"
#include "largest.h"
#include "temp_folder.h"

namespace inhabit::interact {
namespace {

TEST(SenseNoise, ChangesOccupanciesAlone) {
  const Config config = preset("paper");
  const InputLayout layout = input_layout(config);
  int disturbed = 0;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    std::mt19937_64 random(seed);
    torch::Tensor row = torch::full({layout.size}, -7.F);
    SenseNoise(layout, config, 0.5, random).apply(row.data_ptr<float>());
    const torch::Tensor changed = row != -7;
    disturbed += changed.any().item<bool>() ? 1 : 0;
    EXPECT_TRUE(torch::logical_and(row >= 0, row <= 1).index({changed}).all().item<bool>());
    const torch::Tensor chair = changed.slice(0, layout.chair.first, layout.chair.end()).view({-1, 4}).slice(1, 0, 3);
    EXPECT_FALSE(chair.any().item<bool>()) << "voxels stay where they are";
    EXPECT_FALSE(changed.slice(0, 0, layout.ego.first).any().item<bool>());
    EXPECT_FALSE(changed.slice(0, layout.hands.first).any().item<bool>());
  }
  EXPECT_GT(disturbed, 10);
  EXPECT_LT(disturbed, 30);
}

TEST(SenseNoise, IsTheSameThroughARollout) {
  TempFolder folder;
  const Config config = preset("compact");
  const Data data({write_sitters(folder / "sitters")}, "train", config, false);
  const InputLayout layout = input_layout(config);
  std::mt19937_64 random(3);
  const SenseNoise noise(layout, config, 1, random);
  const auto still = [](const torch::Tensor& input, const torch::Tensor&) {
    torch::Tensor y = torch::zeros({input.size(0), 536});
    y.slice(1, 0, 264).copy_(input.slice(1, 0, 264));
    return y;
  };
  const torch::Tensor plain = rollout(data, {20}, 3, still).input, rows = rollout(data, {20}, 3, still, {noise}).input;
  EXPECT_GT(largest(rows - plain), 0.01F);
  for (int64_t t = 0; t < 3; ++t) {
    torch::Tensor expected = plain[t].clone();
    noise.apply(expected.data_ptr<float>());
    EXPECT_LT(largest(rows[t] - expected), 1e-6F) << t;
  }
}

}  // namespace
}  // namespace inhabit::interact
