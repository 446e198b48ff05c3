// Protects `inhabit eval forecast`: the table has every method and horizon, on paper and as JSON, and data that cannot
// be measured is refused in one line.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/refusal.h"
#include "cli/shards.h"
#include "cli/tiny_rooms.h"
#include "inhabit/io/atomic_file.h"

namespace inhabit {
namespace {

using nlohmann::json;

TEST(Eval, TableHasEveryMethodAtEveryHorizon) {
  const TempFolder folder;
  const CommandResult r =
      run_command("eval forecast --stride 30 --data " + make_tiny_rooms(folder) + " --json " + folder / "table.json");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const json table = json::parse(read_whole_file(folder / "table.json"));
  EXPECT_EQ(table["windows"], 4);  // two clips of 120 frames, windows of 90 frames that start at 0 and 30
  EXPECT_THAT(r.out, ::testing::HasSubstr("4 windows"));
  EXPECT_EQ(table["horizons_seconds"], json({0.5, 1.0, 1.5, 2.0}));
  std::map<std::string, json> rows;
  for (const json& row : table["rows"]) {
    rows[row["method"]] = row;
    EXPECT_THAT(r.out, ::testing::HasSubstr(row["method"].get<std::string>()));
    for (const char* error : {"path_error", "pose_error"}) {
      EXPECT_EQ(row[error].size(), 5U);
      for (const char* column : {"0.5s", "1.0s", "1.5s", "2.0s", "mean"}) {
        const double mm = row[error].at(column);
        EXPECT_GT(mm, 0) << row["method"] << error << column;
        EXPECT_LT(mm, 20000) << row["method"] << error << column;
      }
    }
  }
  EXPECT_EQ(table["rows"].size(), 10U);
  for (const char* method : {"last pose held", "constant velocity", "LTD", "w/o contact", "predicted contact",
                             "likeliest of 5", "best of 5", "w/ true of feet", "w/ true of others", "w/ true contact"})
    EXPECT_EQ(rows.count(method), 1U) << method;
  for (const auto& [column, mm] : rows["last pose held"]["pose_error"].items())
    EXPECT_NEAR(rows["constant velocity"]["pose_error"][column].get<double>(), mm.get<double>(), 0.01);
}

TEST(Eval, ShardsEndInTheSameTable) {
  const TempFolder folder;
  const std::string rooms = make_tiny_rooms(folder), of_rooms = "eval forecast --stride 5 --data " + rooms,
                    eval = of_rooms + " --json ";
  expect_shards_alike(of_rooms);
  // Parts of other settings are not mixed, damaged ones named, and without a table there is no place for them.
  ASSERT_EQ(run_command(eval + folder / "table.json --shard 2/2").exit_code, 0);
  const std::string other = "eval forecast --stride 6 --data " + rooms + " --json " + folder / "table.json";
  const CommandResult mixed = run_command(other + " --shard 1/2");
  EXPECT_EQ(mixed.exit_code, 2);
  EXPECT_THAT(mixed.err, ::testing::HasSubstr("table.json.2-of-2.part: is of another evaluation"));
  write_atomically(folder / "table.json.2-of-2.part", "no part");
  const CommandResult damaged = run_command(eval + folder / "table.json --shard 1/2");
  EXPECT_EQ(damaged.exit_code, 2);
  EXPECT_THAT(damaged.err, ::testing::HasSubstr("2-of-2.part"));
  const std::string out = folder / "out";
  std::filesystem::create_directory(out);
  expect_refused("eval forecast --data " + rooms + " --shard 1/2", {"--shard", "--json"}, out);
}

TEST(Eval, ShardsOfContactsAndDetoursDoToo) {
  const TempFolder folder;
  expect_shards_alike("eval contacts --stride 20 --data " + make_tiny_rooms(folder));
  expect_shards_alike("eval detour --rooms 4 --seeds 1 --no-refine");
}

TEST(Eval, RefusesDataThatCannotBeMeasured) {
  const TempFolder folder;
  const std::string out = folder / "out", rooms = make_tiny_rooms(folder), to = " --json " + out + "/t.json";
  std::filesystem::create_directory(out);
  expect_refused("eval forecast --data " + folder / "none" + to, {folder / "none", "no such file"}, out);
  expect_refused("eval forecast --data " INHABIT_SOURCE_DIR "/examples/data" + to,
                 {"is no data set but a folder of motion"}, out);
  expect_refused("eval forecast --data " + rooms + " --model " + rooms + "/dataset.json" + to, {"dataset.json"}, out);
  expect_refused("eval forecast --data " + rooms + " --split other" + to, {"--split"}, out);
  expect_refused("eval forecast --data " + rooms + " --stride 0" + to, {"--stride"}, out);
  expect_refused("eval forecast --data " + rooms + " --json " + folder / "none/t.json", {"none/t.json"}, out);
  expect_refused("eval forecast --data " + rooms + " --set past=10" + to, {"--set past=10", "how the networks"}, out);
  expect_refused("eval forecast --data " + rooms + " --set points=0" + to, {"--set", "points"}, out);
  expect_refused("eval inbetween --data " + rooms + " --set frames=0" + to, {"--set frames=0", "inference."}, out);
  expect_refused("eval detour --set inference.steps=0", {"--set", "inference.steps"}, out);
  expect_refused("eval inbetween" + to, {"either --data or --motion"}, out);
  expect_refused("eval inbetween --data " + rooms + " --row unnamed" + to, {"--row unnamed", "NAME: KEY=VALUE"}, out);
  expect_refused("eval inbetween --data " + rooms + " --row 'a: frames=3'" + to, {"--set frames=3"}, out);
  expect_refused("eval detour --rooms 1", {"--rooms"}, out);

  const json index = json::parse(read_whole_file(rooms + "/dataset.json"));
  const auto with = [&](const char* name, const auto& change) {
    json changed = index;
    change(changed);
    std::filesystem::create_directory(folder / name);
    for (const char* part : {"clips", "scenes"})
      std::filesystem::create_directory_symlink(rooms + "/" + part, folder / name + "/" + part);
    write_atomically(folder / name + "/dataset.json", changed.dump());
    return folder / name;
  };
  const std::string no_test = with("no_test", [](json& j) {
    for (json& clip : j["clips"])
      if (clip["split"] == "test") clip["split"] = "val", clip["scene"] = "";
  });
  expect_refused("eval forecast --data " + no_test + to, {no_test, "has no window of 90 frames in split test"}, out);
  const std::string few = with("few", [](json& j) {
    for (const char* key : {"names", "parents"}) j["skeleton"][key].erase(21);
  });
  expect_refused("eval forecast --data " + few + to, {few, "has 21 joints, the model 22"}, out);
  const std::string fast = with("fast", [](json& j) { j["rate"] = 60; });
  expect_refused("eval forecast --data " + fast + to, {fast, "has 60 frames a second, the model 30"}, out);
  const std::string longer = with("longer", [](json& j) {
    for (json& clip : j["clips"]) clip["frames"] = 200;
  });
  expect_refused("eval forecast --data " + longer + to, {longer, "has 120 frames, dataset.json says 200"}, out);
}

}  // namespace
}  // namespace inhabit
