// Protects the authors' networks as a preset: labels are of the legs and the same for the same seed, and a model is
// trained, written, read and forecasts for as long as is asked.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "anticipate/people.h"
#include "inhabit/anticipate/futures.h"
#include "inhabit/anticipate/intention_anticipator.h"
#include "inhabit/anticipate/released_labels.h"
#include "inhabit/anticipate/train.h"
#include "temp_folder.h"

namespace inhabit::anticipate {
namespace {

using torch::Tensor;

Config tiny_released() {
  Config c = preset("paper");
  c.hidden = 20;
  c.noise = 4;
  c.intention_features = 6;
  c.labels = 3;
  c.training.steps = 3;
  c.training.batch = 4;
  c.training.discriminator_hidden = 8;
  return c;
}

TEST(ReleasedLabels, AreOfTheLegsAndTheSameForTheSameSeed) {
  std::vector<Tensor> poses;
  for (const Sequence& s : people(80)) poses.push_back(intention_poses(s.features));
  const IntentionClusters a = cluster_released(poses, 3, 5), b = cluster_released(poses, 3, 5);
  EXPECT_TRUE(torch::equal(a.codes, b.codes));
  const Tensor labels = intention_labels(poses[0], a);
  EXPECT_TRUE(torch::equal(labels, intention_labels(poses[0], b)));
  EXPECT_EQ(labels.size(0), 80);
  Tensor arms = poses[0].clone();
  arms.slice(1, 3 * 15, 63) += 0.3;  // shoulders to hands
  EXPECT_TRUE(torch::equal(intention_labels(arms, a), labels)) << "the arms say nothing";
  Tensor legs = poses[0].clone();
  legs.slice(1, 0, 6) += 0.5;
  EXPECT_FALSE(torch::equal(label_views(legs), label_views(poses[0])));
  // Who walks has other labels than who stands.
  EXPECT_GT((labels != intention_labels(poses[2], a)).to(torch::kFloat32).mean().item<double>(), 0.5);
}

TEST(ReleasedPreset, IsTrainedWrittenReadAndForecasts) {
  const TempFolder folder;
  const std::string data = write_people(folder / "people", 170);
  const Config config = tiny_released();
  TrainRun run;
  run.data = {data};
  run.out = folder / "model.safetensors";
  run.stages = {"intention"};
  ASSERT_TRUE(train(run, config, nullptr));
  const Networks networks = load_networks(run.out);
  EXPECT_TRUE(networks.config == config);
  ASSERT_TRUE(networks.forecasts());
  const Tensor past = people(60)[0].features.slice(0, 0, 50).unsqueeze(0);
  const Futures futures = future_function(networks)(past, draw_noise(config, 2, 230, 1), 230);
  EXPECT_EQ(futures.features.sizes(), (std::vector<int64_t>{2, 230, 67}));
  EXPECT_EQ(futures.labels.sizes(), (std::vector<int64_t>{2, 230}));
  EXPECT_LT(futures.labels.max().item<int64_t>(), 3);
  EXPECT_GT((futures.features[0] - futures.features[1]).abs().max().item<double>(), 0) << "z tells futures apart";
  EXPECT_LT((futures.features.select(1, 0) - past.select(1, 49)).abs().max().item<double>(), 1)
      << "added to the last pose";
  save_networks(folder / "again.safetensors", networks);
  const Futures same =
      future_function(load_networks(folder / "again.safetensors"))(past, draw_noise(config, 2, 30, 1), 30);
  EXPECT_TRUE(torch::allclose(same.features, futures.features.slice(1, 0, 30), 0, 1e-6));
  const IntentionAnticipator facade = IntentionAnticipator::load(run.out);
  EXPECT_EQ(facade.run(person("walk", 60), {}, {.samples = 1, .seconds = 1}).futures.size(), 1U);
}

}  // namespace
}  // namespace inhabit::anticipate
