// Protects the windows that networks are trained and measured on: which there are, where they lie, and that a seed says
// all about them.
#include "inhabit/forecast/sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "forecast/walker_data.h"
#include "inhabit/error.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::forecast {
namespace {

TEST(Data, HasEveryWholeWindowOfClipsThatHaveAScene) {
  const TempFolder folder;
  const std::string data = write_walkers(folder / "data");
  const Config config = preset("compact");
  EXPECT_EQ(Data({data}, "train", config, 5).size(), 7);  // starts 0, 5, ..., 30 of 120 frames
  EXPECT_EQ(Data({data}, "val", config, 30).size(), 2);
  EXPECT_EQ(Data({data}, "test", config, 31).size(), 1);
  EXPECT_EQ(Data({data}, "all", config, 30).size(), 6);
  EXPECT_EQ(Data({data, data}, "test", config, 30).size(), 4);
}

TEST(Data, WindowsHaveTheirRootAtTheOriginAndPointsAround) {
  const TempFolder folder;
  const std::string path = write_walkers(folder / "data");
  for (const char* name : {"compact", "paper"}) {
    const Config config = preset(name);
    const Data data({path}, "all", config, 30);
    for (int64_t i = 0; i < data.size(); ++i) {
      const Sample s = data.sample(i, 1, false);
      ASSERT_EQ(s.joints.sizes(), (torch::IntArrayRef{90, 22, 3}));
      ASSERT_EQ(s.points.sizes(), (torch::IntArrayRef{config.inference.points, 3}));
      EXPECT_LT(s.joints[config.past - 1][config.root].abs().max().item<float>(), 1e-6F);
      EXPECT_LT(s.points.norm(2, {1}).max().item<float>(), config.inference.radius + 1e-4);
      // The floor lies 0.95 m and the pelvis' offset below the root, everywhere the same.
      EXPECT_LT((s.points.select(1, 1) - s.points[0][1]).abs().max().item<float>(), 1e-4F);
      EXPECT_LT(s.points[0][1].item<float>(), -0.8F);
    }
  }
  // A person who goes where the hips face comes from -Z and goes on to +Z, 1.2 m a second.
  const Sample s = Data({path}, "test", preset("compact"), 30).sample(0, 1, false);
  EXPECT_LT((s.joints[89][0] - torch::tensor({0.F, 0.F, 2.4F})).abs().max().item<float>(), 1e-3F);
}

TEST(Data, SeedAndIndexSayEverything) {
  const TempFolder folder;
  const Data data({write_walkers(folder / "data")}, "train", preset("compact"), 5);
  const Sample a = data.sample(3, 7, true), b = data.sample(3, 8, true);
  EXPECT_FALSE(torch::equal(a.points, b.points));
  EXPECT_FALSE(torch::equal(a.joints, b.joints));
  std::vector<std::thread> threads;
  std::array<Sample, 4> again;
  for (Sample& s : again) threads.emplace_back([&] { s = data.sample(3, 7, true); });
  for (std::thread& t : threads) t.join();
  for (const Sample& s : again) {
    EXPECT_TRUE(torch::equal(s.points, a.points));
    EXPECT_TRUE(torch::equal(s.joints, a.joints));
  }
}

TEST(Data, AugmentationMovesPersonAndRoomTogetherOnTheFloor) {
  const TempFolder folder;
  const std::string path = write_walkers(folder / "data", 30, 1);
  for (const char* name : {"compact", "paper"}) {
    const Config config = preset(name);
    const Data data({path}, "train", config, 30);
    double widest = 0, farthest = 0;
    for (uint64_t seed = 0; seed < 24; ++seed) {
      const Sample plain = data.sample(1, seed, false), moved = data.sample(1, seed, true);
      // Distances between joints and points tell that both moved as one body; float64 against cancellation.
      const auto distances = [](const Sample& s) {
        return (s.joints[40].to(torch::kDouble).unsqueeze(1) -
                s.points.slice(0, 0, 200).to(torch::kDouble).unsqueeze(0))
            .norm(2, {2});
      };
      EXPECT_LT((distances(plain) - distances(moved)).abs().max().item<double>(), 1e-5);
      EXPECT_LT((plain.joints.select(2, 1) - moved.joints.select(2, 1)).abs().max().item<float>(), 1e-5F);
      const torch::Tensor shift = moved.joints[config.past - 1][config.root];
      farthest = std::max(farthest, shift.abs().max().item<double>());
      const auto yaw = [&](const Sample& s) {
        const torch::Tensor across = s.joints[config.past - 1][1] - s.joints[config.past - 1][2];
        return std::atan2(-across[2].item<double>(), across[0].item<double>());
      };
      widest = std::max(widest, std::abs(std::remainder(yaw(moved) - yaw(plain), 2 * M_PI)));
    }
    if (config.hips.empty()) {
      EXPECT_GT(widest, 2.0);  // [0, pi)
      EXPECT_GT(farthest, 0.25);
      EXPECT_LT(farthest, 0.5);
    } else {
      EXPECT_GT(widest, 0.15);
      EXPECT_LT(widest, 0.3001);
      EXPECT_LT(farthest, 1e-6);
    }
  }
}

// A walker at 1.2 m a second who is recorded at another pace goes faster or slower, in the same room.
TEST(Data, WindowsHaveThePaceThatIsAskedFor) {
  const TempFolder folder;
  const std::string path = write_walkers(folder / "data");
  const Data data({path}, "train", preset("compact"), 5);
  const auto travelled = [](const Sample& s) { return (s.joints[89][0] - s.joints[30][0]).norm().item<double>(); };
  const Sample plain = data.sample(1, 1, false);
  EXPECT_NEAR(travelled(data.sample(1, 1, false, 1.25)), 1.25 * travelled(plain), 0.02);
  EXPECT_NEAR(travelled(data.sample(1, 1, false, 0.8)), 0.8 * travelled(plain), 0.02);
  EXPECT_NEAR(travelled(data.sample(1, 1, false, 1 + 1e-9)), travelled(plain), 1e-4);
}

TEST(Data, RefusesDataOfAnotherKindThanTheModels) {
  const TempFolder folder;
  Config config = preset("compact");
  using ::testing::HasSubstr;
  const std::string slow = write_walkers(folder / "slow", 25), data = write_walkers(folder / "data");
  EXPECT_THAT(refusal_of([&] { Data({slow}, "all", config, 5); }), HasSubstr("25 frames a second, the model 30"));
  config.joints = 21;
  EXPECT_THAT(refusal_of([&] { Data({data}, "all", config, 5); }), HasSubstr("has 22 joints, the model 21"));
  EXPECT_THAT(refusal_of([&] { Data({folder / "none"}, "all", config, 5); }), HasSubstr(folder / "none"));
}

TEST(Data, NamesTheClipThatIsFarFromItsScene) {
  const TempFolder folder;
  const std::string path = folder / "data";
  Dataset data = create_dataset(path, {});
  write_scene(data, "scenes/far.glb", floor_scene(2, 90, 90));
  DatasetClip entry{"clips/far.npz", "scenes/far.glb", "train", 0, ""};
  write_clip(data, entry, walker(90, 1));
  data.clips = {entry};
  write_index(data);
  const Data windows({path}, "train", preset("compact"), 5);
  EXPECT_THAT(refusal_of([&] { windows.sample(0, 1, false); }),
              ::testing::AllOf(::testing::HasSubstr("clips/far.npz"), ::testing::HasSubstr("within 2.5 m")));
}

TEST(PointsNear, AreDistinctWhereThereAreEnoughElseEachAtLeastOnce) {
  const torch::Tensor pool = torch::arange(60).to(torch::kFloat32).view({20, 3}) / 100;
  const torch::Tensor center = torch::zeros({3});
  const auto rows = [](const torch::Tensor& points) {
    std::multiset<float> out;
    for (int64_t i = 0; i < points.size(0); ++i) out.insert(points[i][0].item<float>());
    return out;
  };
  const auto some = rows(points_near(pool, center, 10, 12, 3)), all = rows(points_near(pool, center, 10, 50, 3));
  EXPECT_EQ(std::set<float>(some.begin(), some.end()).size(), 12U);
  EXPECT_EQ(all.size(), 50U);
  EXPECT_EQ(std::set<float>(all.begin(), all.end()).size(), 20U);
  const torch::Tensor near = points_near(pool, center, 0.3, 50, 3);
  EXPECT_LT(near.norm(2, {1}).max().item<float>(), 0.3F + 1e-6F);
  EXPECT_THROW(points_near(pool, center + 50, 1, 4, 3), Error);
}

}  // namespace
}  // namespace inhabit::forecast
