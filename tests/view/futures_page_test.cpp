#include "inhabit/view/futures_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>

#include "cli/command.h"
#include "in_browser.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

/// Somebody who goes from `from` (x, z) with `step` metres a frame and swings the arms; 25 frames a second.
Clip going(int64_t frames, std::array<double, 2> from, std::array<double, 2> step) {
  Clip clip;
  clip.skeleton = builtin_body().skeleton;
  clip.rate = 25;
  torch::Tensor rest = torch::zeros({kStandardJoints, 3});
  for (int j = 1; j < kStandardJoints; ++j)
    rest[j] = rest[clip.skeleton.parents[static_cast<size_t>(j)]] + clip.skeleton.offsets[j];
  rest.select(1, 1).sub_(rest.select(1, 1).min());
  const torch::Tensor t = torch::arange(frames).to(torch::kFloat32);
  clip.joints = rest.unsqueeze(0).repeat({frames, 1, 1});
  clip.joints.select(2, 0).add_((from[0] + step[0] * t).unsqueeze(1));
  clip.joints.select(2, 2).add_((from[1] + step[1] * t).unsqueeze(1));
  for (const int hand : {20, 21}) clip.joints.select(1, hand).select(1, 2).add_(0.2 * torch::sin(t * 0.3));
  return clip;
}

struct Example {
  Clip past = going(25, {0, 0}, {0, 0.04});
  std::vector<Clip> futures;
  std::vector<torch::Tensor> labels;

  explicit Example(int count) {
    for (int i = 0; i < count; ++i) {
      futures.push_back(going(50, {0, 1}, {0.02 * (i - count / 2), 0.04}));
      labels.push_back((torch::arange(50) > 5 * i).to(torch::kInt64) * 2);
    }
  }
};

TEST(FuturesPage, FiftyFuturesOfThirtySecondsStayBelowFourMegabytes) {
  TempFolder folder;
  std::vector<Clip> futures;
  torch::manual_seed(1);
  for (int i = 0; i < 50; ++i) {
    Clip clip = going(750, {0, 0}, {0.001 * i, 0.04});
    // As restless as people: every joint sways by centimetres at its own pace.
    const torch::Tensor pace = 0.05 + 0.3 * torch::rand({1, kStandardJoints, 3});
    clip.joints += 0.05 * torch::sin(torch::arange(750).reshape({750, 1, 1}) * pace);
    futures.push_back(clip);
  }
  write_page(folder / "page.html", futures_page(going(50, {0, -2}, {0, 0.04}), futures, {}));
  EXPECT_LT(std::filesystem::file_size(folder / "page.html"), 4'000'000U);
}

TEST(FuturesPage, RefusesWhatDoesNotFit) {
  TempFolder folder;
  const std::string path = folder / "page.html";
  const Example good(2);
  EXPECT_THAT(refusal_of([&] { futures_page(good.past, {}, {}); }), testing::HasSubstr("none to show"));
  EXPECT_THAT(refusal_of([&] { futures_page(good.past, good.futures, {good.labels[0]}); }),
              testing::HasSubstr("labels of 1"));
  Page page = futures_page(good.past, good.futures, good.labels);
  page.people[1].labels = torch::zeros({3}, torch::kInt64);
  EXPECT_THAT(refusal_of([&] { write_page(path, page); }), testing::HasSubstr("differ in number"));
  page.people[1].labels = torch::full({50}, -1, torch::kInt64);
  EXPECT_THAT(refusal_of([&] { write_page(path, page); }), testing::HasSubstr("from 0 on"));
  page = futures_page(good.past, good.futures, good.labels);
  page.recordings = PageRecordings{{{"one", "walk", torch::zeros({2, 2}, torch::kInt64), {}}}, 25};
  EXPECT_THAT(refusal_of([&] { write_page(path, page); }), testing::HasSubstr("from 0 on"));
  page.recordings->rate = 0;
  EXPECT_THAT(refusal_of([&] { write_page(path, page); }), testing::HasSubstr("rate"));
  EXPECT_FALSE(std::filesystem::exists(path));
}

// viewer/test/futures_test.mjs opens the pages in headless Chromium; it skips (exit code 77) where there is none.
TEST(FuturesPageInBrowser, StandSideBySideAndGoOverlaid) {
  TempFolder folder;
  const Example example(9);
  write_page(folder / "futures.html", futures_page(example.past, example.futures, example.labels));

  Page in_room = futures_page(example.past, example.futures, example.labels);
  const Scene room = floor_scene();
  in_room.scene = &room;
  write_page(folder / "in_room.html", in_room);

  Page intentions;
  intentions.recordings.emplace();
  for (int64_t c = 0; c < 3; ++c) {
    PagePerson person;
    person.clip = going(20 + 10 * c, {0, 0}, {0, 0.04});
    person.name = std::to_string(c) + " · walk_about";
    person.role = PagePerson::Role::intention;
    person.labels = torch::full({person.clip.frames()}, c, torch::kInt64);
    intentions.people.push_back(person);
    intentions.recordings->rows.push_back(
        {"recording " + std::to_string(c), c == 1 ? "jump" : "walk", torch::arange(90).div(30, "floor"), {{0, 30}}});
  }
  write_page(folder / "intentions.html", intentions);

  nlohmann::json expected = nlohmann::json::array();  // the last future's joints at its frame 25, 2 s
  const torch::Tensor joints = example.futures[8].joints[25];
  for (int64_t j = 0; j < joints.size(0); ++j)
    expected.push_back({joints[j][0].item<float>(), joints[j][1].item<float>(), joints[j][2].item<float>()});
  std::ofstream(folder / "expected.json") << expected.dump();

  std::string said;
  const int status = in_browser("futures_test.mjs", folder, said);
  if (status == kNoBrowser) GTEST_SKIP() << said;
  EXPECT_EQ(status, 0) << said;
}

}  // namespace
}  // namespace inhabit
