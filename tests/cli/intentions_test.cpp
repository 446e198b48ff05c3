// Protects `inhabit intentions`: labels of a data set as a table, JSON and a page, the same for the same seed; and what
// it owes to bad input.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "anticipate/people.h"
#include "cli/refusal.h"
#include "inhabit/io/atomic_file.h"

namespace inhabit {
namespace {

using nlohmann::json;

const std::string kSmall = " --labels 3 --set clusters=6 ";  // waving has a mirror image, which nobody did

TEST(Intentions, TellWalkingFromWaving) {
  const TempFolder folder;
  const std::string data = write_people(folder / "people", 100), page = folder / "i.html", table = folder / "i.json";
  const CommandResult r = run_command("intentions " + data + kSmall + "-o " + page + " --json " + table);
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, ::testing::HasSubstr("segments"));
  const json labels = json::parse(read_whole_file(table)).at("labels");
  ASSERT_EQ(labels.size(), 3U);
  double frames = 0;
  std::set<std::string> first;
  for (const json& label : labels) {
    if (label["segments"] == 0) continue;
    frames += label["fraction"].get<double>();
    EXPECT_GT(label["seconds"].get<double>(), 0.5);
    EXPECT_GT(label["actions"][0]["fraction"].get<double>(), 0.8);
    first.insert(label["actions"][0]["name"]);
    EXPECT_GT(label["representative"]["last"], label["representative"]["first"]);
  }
  EXPECT_NEAR(frames, 1, 1e-9);
  EXPECT_EQ(first, (std::set<std::string>{"walk", "wave"}));

  const std::string text = read_whole_file(page);
  for (const char* part : {"\"role\":\"intention\"", "\"group\":\"walk\"", "\"group\":\"wave\"", "clips/6.npz (test)"})
    EXPECT_NE(text.find(part), std::string::npos) << part;

  const std::string again = folder / "again.json";
  ASSERT_EQ(run_command("intentions " + data + kSmall + "-o " + page + " --json " + again).exit_code, 0);
  EXPECT_EQ(read_whole_file(again), read_whole_file(table));
}

TEST(Intentions, RefuseWhatCannotBeClustered) {
  const TempFolder folder;
  const std::string out = folder / "out";
  std::filesystem::create_directories(out);
  const std::string to = " -o " + out + "/i.html --json " + out + "/i.json";
  expect_refused("intentions " + (folder / "nowhere") + to, {"nowhere"}, out);
  expect_refused("intentions cmu:" + (folder / "nowhere") + to, {"nowhere", "holds no motion"}, out);

  const std::string tests = write_people(folder / "tests", 30);
  Dataset data = open_dataset(tests);
  for (DatasetClip& clip : data.clips) clip.split = "test";
  write_index(data);
  expect_refused("intentions " + tests + to, {"tests", "no training recording"}, out);

  const std::string people = write_people(folder / "people", 30);
  expect_refused("intentions " + people + to + " --set colour=red", {"colour"}, out);
  expect_refused("intentions " + people + to + " --labels 0", {"labels"}, out);
  expect_refused("intentions " + people + " -o " + out + "/no/i.html", {"no/i.html"}, out);
}

}  // namespace
}  // namespace inhabit
