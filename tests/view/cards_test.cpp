// Pages of many files: `inhabit view FOLDER`, training logs and evaluations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "cli/refusal.h"
#include "in_browser.h"
#include "inhabit/io/files.h"
#include "inhabit/metrics/score_json.h"
#include "inhabit/synth/room.h"
#include "inhabit/view/charts.h"
#include "refusal_of.h"
#include "view/striding.h"

namespace inhabit {
namespace {

void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

/// Two stages of fifty reports each, whose losses fall, and a validation in the middle and at the end of the first.
std::string a_log() {
  std::string text;
  for (const char* stage : {"first", "second"})
    for (int step = 1; step <= 50; ++step) {
      const std::string begin = "{\"stage\":\"" + std::string(stage) + "\",\"step\":" + std::to_string(20 * step);
      const std::string loss = std::to_string(10.0 / step);
      text += begin + ",\"seconds\":" + std::to_string(step) + ",\"rate\":0.001,\"losses\":{\"total\":" + loss +
              ",\"path\":" + loss + "}}\n";
      if (stage == std::string("first") && step % 25 == 0)
        text += begin + ",\"validation\":" + std::to_string(12.5 / step) + ",\"best\":0.2}\n";
    }
  return text;
}

std::string a_table() {
  const auto row = [](const char* data, const char* method, const char* near, const char* far, const char* mean) {
    const auto value = [](const char* number) {
      return std::string("{\"mean\":") + number + ",\"interval95\":" + (std::string(number) == "null" ? "null" : "1") +
             "}";
    };
    return std::string("{\"data\":\"") + data + "\",\"method\":\"" + method +
           "\",\"path_error\":{\"0.5s\":" + value(near) + ",\"1.0s\":" + value(far) + ",\"mean\":" + value(mean) +
           "},\"windows\":7}";
  };
  return "{\"unit\":\"millimetres\",\"rows\":[" + row("all", "held", "12", "28", "20") + "," +
         row("all", "<img src=x onerror=window.hacked=1>", "6", "14", "10") + "," +
         row("walking", "held", "null", "30", "30") + "]}";
}

TEST(Charts, ReadsATrainingLog) {
  TempFolder folder;
  write(folder / "m.log.jsonl", a_log() + "{\"stage\":\"second\",\"st");  // a training at work
  const PageChart chart = read_training_log(folder / "m.log.jsonl");
  ASSERT_EQ(chart.panels.size(), 4U);
  EXPECT_EQ(chart.panels[0].title, "validation");
  EXPECT_EQ(chart.panels[1].title, "loss: total");
  EXPECT_EQ(chart.panels[3].title, "learning rate");
  ASSERT_EQ(chart.panels[1].series.size(), 2U);
  EXPECT_EQ(chart.panels[1].series[0].name, "first");
  EXPECT_EQ(chart.panels[1].series[0].x.size(), 50U);
  EXPECT_NEAR(chart.panels[1].series[0].y[9], 1.0, 1e-6);
  EXPECT_EQ(chart.panels[0].series[0].x, (std::vector<double>{500, 1000}));
}

TEST(Charts, ThinsLongLogs) {
  TempFolder folder;
  std::ofstream log(folder / "m.log.jsonl");
  for (int step = 1; step <= 30'001; ++step) log << "{\"step\":" << step << ",\"losses\":{\"total\":1}}\n";
  log.close();
  const PageChart chart = read_training_log(folder / "m.log.jsonl");
  const auto& x = chart.panels.at(0).series.at(0).x;
  EXPECT_LE(x.size(), 2001U);
  EXPECT_EQ(x.back(), 30'001);
}

TEST(Charts, ReadsATable) {
  TempFolder folder;
  write(folder / "table.json", a_table());
  EXPECT_TRUE(is_score_table(folder / "table.json"));
  const PageChart chart = read_score_chart(folder / "table.json");
  ASSERT_EQ(chart.panels.size(), 6U);  // three of each data set
  const PageChart::Panel& path = chart.panels[0];
  EXPECT_EQ(path.title, "path_error");
  EXPECT_EQ(path.group, "all");
  EXPECT_FALSE(path.bars);
  EXPECT_EQ(path.ticks, (std::vector<std::string>{"0.5s", "1.0s"}));
  EXPECT_EQ(path.series[0].y, (std::vector<double>{12, 28}));
  EXPECT_EQ(path.series[0].interval, (std::vector<double>{1, 1}));
  EXPECT_TRUE(chart.panels[1].bars);
  EXPECT_TRUE(std::isnan(chart.panels[3].series[0].y[0]));
  write(folder / "clip.json", "{\"joints\": []}");
  EXPECT_FALSE(is_score_table(folder / "clip.json"));
}

TEST(Charts, ReadsScores) {
  TempFolder folder;
  write(folder / "ndms.json",
        "{\"ndms\":0.5,\"words\":9,\"files\":[{\"file\":\"in/a.npz\",\"ndms\":0.25,\"by_second\":[0.5,null,0.125]},"
        "{\"file\":\"in/a.npz\",\"ndms\":0.75,\"by_second\":[1]}],\"skipped\":[\"b.npz: is damaged\"]}");
  EXPECT_TRUE(is_score_table(folder / "ndms.json"));
  const PageChart chart = read_score_chart(folder / "ndms.json");
  ASSERT_EQ(chart.panels.size(), 4U);
  EXPECT_EQ(chart.x, "seconds");
  EXPECT_EQ(chart.panels[0].title, "ndms");
  EXPECT_TRUE(chart.panels[0].bars);
  EXPECT_EQ(chart.panels[0].series.at(0).y, std::vector<double>{0.5});
  EXPECT_EQ(chart.panels[1].title, "words");
  const PageChart::Panel& files = chart.panels[2];
  EXPECT_EQ(files.title, "ndms, each file");
  EXPECT_TRUE(files.bars);
  EXPECT_EQ(files.ticks, (std::vector<std::string>{"a.npz", "a.npz (2)"}));
  EXPECT_EQ(files.series.at(0).y, (std::vector<double>{0.25, 0.75}));
  const PageChart::Panel& seconds = chart.panels[3];
  EXPECT_EQ(seconds.title, "by_second");
  EXPECT_FALSE(seconds.bars);
  ASSERT_EQ(seconds.series.size(), 2U);
  EXPECT_EQ(seconds.series[0].x, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(seconds.series[0].y[0], 0.5);
  EXPECT_TRUE(std::isnan(seconds.series[0].y[1]));
  EXPECT_EQ(seconds.series[1].y, std::vector<double>{1});

  write(folder / "apd.json",
        "{\"apd_m\":1.5,\"by_horizon\":[{\"seconds\":0.4,\"value\":1},{\"seconds\":2,\"value\":3}]}");
  const PageChart::Panel horizon = read_score_chart(folder / "apd.json").panels.at(1);
  EXPECT_EQ(horizon.series.at(0).x, (std::vector<double>{0.4, 2}));
  EXPECT_EQ(horizon.series.at(0).y, (std::vector<double>{1, 3}));
  const CommandResult r =
      run_command("view " + (folder / "ndms.json") + " " + (folder / "apd.json") + " -o " + (folder / "scores.html"));
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, testing::HasSubstr("2 cards"));
  write(folder / "camera.json", "{\"fx\": 500, \"fy\": 500}");
  EXPECT_FALSE(is_score_table(folder / "camera.json"));
}

TEST(Charts, KnowsScoresOfEveryKind) {
  TempFolder folder;
  for (size_t kind = 0; kind < kScoreNames.size(); ++kind) {
    write(folder / "scores.json", begin_scores(static_cast<ScoreKind>(kind), 0.5).dump());
    EXPECT_TRUE(is_score_table(folder / "scores.json")) << kScoreNames[kind];
  }
}

TEST(Charts, RefusesWhatIsNone) {
  TempFolder folder;
  const auto refused = [&](const std::string& name, const std::string& text, const char* reason) {
    write(folder / name, text);
    const std::string said = refusal_of([&] {
      if (name.ends_with("jsonl"))
        read_training_log(folder / name);
      else
        read_score_chart(folder / name);
    });
    EXPECT_THAT(said, testing::HasSubstr(name));
    EXPECT_THAT(said, testing::HasSubstr(reason));
    EXPECT_EQ(said.find('\n'), std::string::npos);
  };
  refused("empty.jsonl", "", "no training log");
  refused("text.jsonl", "hello\n", "line 1 is not JSON");
  refused("second.jsonl", "{\"step\":1}\nhello\n", "line 2 is not JSON");
  refused("list.jsonl", "[1,2]\n", "line 1 has no step");
  refused("steps.jsonl", "{\"step\":1}\n{\"step\":2}\n", "no training log");
  refused("nan.jsonl", "{\"step\":1,\"losses\":{\"total\":NaN}}\n", "line 1 is not JSON");
  refused("deep.jsonl", std::string(100'000, '[') + "\n", "line 1");
  refused("object.json", "{}", "no list of rows");
  refused("rows.json", "[1, 2]", "no list of rows");
  refused("names.json", "[{\"error\": 1}]", "without a name");
  refused("numbers.json", "[{\"method\": \"held\"}]", "without a number");
  std::string rows = "[";
  for (int i = 0; i < 1001; ++i) rows += std::string(i > 0 ? "," : "") + "{\"m\":\"a\",\"e\":1}";
  refused("many.json", rows + "]", "1000 rows");
}

TEST(CardsInBrowser, ShowsFoldersAndCurves) {
  TempFolder folder;
  const std::string in = folder / "data";
  std::filesystem::create_directories(folder / "data/a");
  write_clip(folder / "data/a/far.npz", striding(60, 0, 0));
  write_clip(folder / "data/a/long.npz", striding(3000, 0, 0));
  write_clip(folder / "data/b.bvh", striding(30, 0, 0));
  write_clip(folder / "data/evil <img src=x onerror=window.hacked=1>.npz", striding(30, 0, 0));
  std::mt19937_64 random(7);
  write_scene(folder / "data/room.glb", make_room(random).scene());
  write(folder / "data/broken.bvh", "HIERARCHY");
  write(folder / "data/readme.md", "not looked at");
  const CommandResult r = run_command("view '" + in + "/' -o " + (folder / "gallery.html"));
  ASSERT_EQ(r.exit_code, 1) << "a file was skipped: " << r.err;
  EXPECT_NE(r.err.find("skipped: " + in + "/broken.bvh: "), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("1 of 6 files were skipped"), std::string::npos) << r.err;
  EXPECT_EQ((r.out + r.err).find("readme"), std::string::npos) << r.out << r.err;
  EXPECT_NE(r.out.find("5 cards"), std::string::npos) << r.out;
  EXPECT_NE(read_whole_file(folder / "gallery.html").find("<title>data</title>"), std::string::npos);

  write(folder / "m.log.jsonl", a_log());
  write(folder / "table.json", a_table());
  const CommandResult curves = run_command("view " + (folder / "m.log.jsonl") + " " + (folder / "table.json") + " -o " +
                                           (folder / "curves.html"));
  ASSERT_EQ(curves.exit_code, 0) << curves.err;

  std::string said;
  const int status = in_browser("cards_test.mjs", folder, said);
  if (status == kNoBrowser) GTEST_SKIP() << said;
  EXPECT_EQ(status, 0) << said;
}

TEST(ViewCommand, RefusesWhatMakesNoCards) {
  TempFolder folder;
  std::filesystem::create_directories(folder / "empty");
  std::filesystem::create_directories(folder / "bad");
  std::filesystem::create_directories(folder / "out");
  write(folder / "bad/one.bvh", "HIERARCHY");
  write(folder / "hostile.jsonl", "{\"step\": 1, \"losses\": {\"total\": 1e999}}\n");
  write(folder / "cut.json", "[{\"method\": \"held\", ");
  write(folder / "fine.log.jsonl", a_log());
  const std::string out = " -o " + (folder / "out/page.html");
  expect_refused("view " + (folder / "empty") + out, {"empty", "nothing that can be shown"}, folder / "out");
  expect_refused("view " + (folder / "bad") + out, {"nothing that can be shown", "one.bvh"}, folder / "out");
  expect_refused("view " + (folder / "hostile.jsonl") + out, {"hostile.jsonl", "line 1"}, folder / "out");
  expect_refused("view " + (folder / "cut.json") + out, {"cut.json", "cut short"}, folder / "out");
  expect_refused("view " + (folder / "fine.log.jsonl") + " " + (folder / "none.npz") + out, {"none.npz"},
                 folder / "out");
  expect_refused("view " + (folder / "fine.log.jsonl") + " --scene x.glb" + out, {"--scene"}, folder / "out");
}

}  // namespace
}  // namespace inhabit
