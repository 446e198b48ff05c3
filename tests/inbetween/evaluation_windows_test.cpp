// Protects what in-betweening is measured on: windows that follow on each other, on the standard skeleton at the
// model's rate with the floor at y = 0, spread over all that there are.
#include "inhabit/inbetween/evaluation_windows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "forecast/walker_data.h"
#include "inbetween/small_network.h"
#include "inhabit/motion/resample.h"
#include "inhabit/scene/floor.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit::inbetween {
namespace {

std::vector<std::string> window_names(const std::vector<Window>& windows) {
  std::vector<std::string> out;
  for (const Window& window : windows) out.push_back(window.name);
  return out;
}

TEST(WindowsOfData, AreOfOneSplitAndSpreadOverIt) {
  const TempFolder folder;
  const std::string data = write_walkers(folder / "walkers");
  Config config = small_inbetween_config();  // nine windows of 13 frames in 120
  EXPECT_EQ(windows_of_data({data}, "test", config, 100).size(), 9U);
  const auto some = windows_of_data({data}, "test", config, 3);
  EXPECT_THAT(window_names(some), testing::ElementsAre("clips/2.npz 0", "clips/2.npz 39", "clips/2.npz 78"));
  EXPECT_EQ(some[1].truth.frames(), 13);
  EXPECT_NE(some[1].scene, nullptr);
  config.frames = 121;
  EXPECT_THAT(refusal_of([&] { windows_of_data({data}, "test", config, 3); }),
              testing::HasSubstr("walkers: has no window of 121 frames in split test"));
}

TEST(WindowsOfRecordings, FollowOnEachOtherAtTheModelsRate) {
  const Config config = small_inbetween_config();  // 13 frames
  const Clip clip = walker(40, 1);
  const auto windows =
      windows_of_recordings({{"a", resample(clip, 60)}, {"b", walker(12, 1)}, {"c", walker(26, 1)}}, {}, config, 100);
  EXPECT_THAT(window_names(windows), testing::ElementsAre("a 0", "a 13", "a 26", "c 0", "c 13")) << "b is too short";
  EXPECT_EQ(windows[1].truth.rate, config.rate);
  EXPECT_EQ(windows[1].truth.frames(), 13);
  const torch::Tensor walked = windows[1].truth.joints - windows[0].truth.joints;
  EXPECT_TRUE(walked.select(2, 2).allclose(torch::full({13, 22}, 13 / config.rate), 0, 1e-3)) << "1 m/s";
  EXPECT_EQ(windows[0].scene, windows[2].scene) << "of one recording";
}

TEST(WindowsOfRecordings, StandOnAFloorAtZero) {
  const Config config = small_inbetween_config();
  const Clip clip = walker(13, 1);
  const double under = floor_under(clip, SceneQuery(assumed_floor(clip)));
  const Window assumed = windows_of_recordings({{"a", clip}}, {}, config, 1).front();
  EXPECT_TRUE(assumed.truth.joints.select(2, 1).allclose(clip.joints.select(2, 1) - under, 0, 1e-4));
  EXPECT_LT(assumed.scene->meshes[0].vertices.select(1, 1).abs().max().item<double>(), 1e-5);
  const Window given = windows_of_recordings({{"a", clip}}, raised(floor_scene(), under + 0.1), config, 1).front();
  EXPECT_TRUE(given.truth.joints.select(2, 1).allclose(clip.joints.select(2, 1) - under - 0.1, 0, 1e-4))
      << "the scene says where the floor is";
  EXPECT_LT(given.scene->meshes[0].vertices.select(1, 1).abs().max().item<double>(), 1e-5);
}

TEST(WindowsOfRecordings, AreSpreadOverAll) {
  const Config config = small_inbetween_config();
  const std::vector<std::pair<std::string, Clip>> recordings = {{"a", walker(52, 1)}, {"b", walker(26, 1)}};
  EXPECT_THAT(window_names(windows_of_recordings(recordings, {}, config, 3)),
              testing::ElementsAre("a 0", "a 26", "b 0"));
  EXPECT_THAT(refusal_of([&] {
                windows_of_recordings({{"short.bvh", walker(12, 1)}}, {}, config, 3);
              }),
              testing::HasSubstr("short.bvh: has no window of 13 frames"));
}

}  // namespace
}  // namespace inhabit::inbetween
