// Protects the words of --shard, and that damaged lists of what other parts and earlier runs made are named.
#include "inhabit/data/shard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/data/dataset_items.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/version.h"
#include "refusal_of.h"
#include "temp_folder.h"

namespace inhabit {
namespace {

TEST(Shard, IsIOfN) {
  EXPECT_EQ(parse_shard("2/8").name(), "2-of-8");
  EXPECT_TRUE(parse_shard("1/1").is_all());
  std::vector<int64_t> items;
  for (int64_t i = 0; i < 10; ++i)
    if (parse_shard("3/4").has(i)) items.push_back(i);
  EXPECT_THAT(items, testing::ElementsAre(2, 6));
  for (const char* wrong :
       {"", "2", "2/", "/3", "0/3", "4/3", "-1/3", "1/0", "1/2/3", "a/b", "1/99999999999999999999", "1 / 2"})
    EXPECT_THAT(refusal_of([&] { parse_shard(wrong); }), testing::HasSubstr("--shard: ")) << wrong;
}

TEST(Shard, ADamagedListOfAnotherPartIsNamed) {
  const TempFolder folder;
  Dataset part = create_dataset(folder / "d", {}, {1, 2});
  const std::string deep =
      "[{\"item\": 1, \"clips\": [], \"facts\": " + std::string(100'000, '[') + std::string(100'000, ']') + "}]";
  for (const std::string& damaged :
       {std::string("[{\"item\": 1}]"), std::string("{}1"),
        std::string("[{\"item\": \"x\", \"facts\": 1, \"clips\": []}]"), std::string("[1]"), deep}) {
    write_atomically(folder / "d/shards/2-of-2.json", damaged);
    EXPECT_THAT(refusal_of([&] { gather_items(part, {}); }), testing::HasSubstr("2-of-2.json"))
        << damaged.substr(0, 100);
  }
}

TEST(UnfinishedItems, ADamagedLineIsSaidAndOneThatWasCutIsNot) {
  const TempFolder folder;
  Dataset dataset = create_dataset(folder / "d", {});
  const std::string kept = folder / "d/unfinished.jsonl";
  write_atomically(folder / "d/clips/a.npz", "whole");
  const auto items_after = [&](const std::string& lines) {
    write_atomically(kept, nlohmann::json{{"version", INHABIT_VERSION}, {"job", "walks"}}.dump() + "\n" + lines);
    return make_items(dataset, "walks", {}, {}, {});
  };
  const std::string whole = "{\"item\": 3, \"clips\": [[\"clips/a.npz\", \"\", \"train\", 9, \"\"]], \"facts\": 0}\n";
  EXPECT_EQ(items_after(whole + "{\"item\": 4, \"cl").count(3), 1);
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  for (const std::string& damaged : {std::string(), std::string("{"), std::string("[]"), std::string("{\"item\": 4}"),
                                     "{\"item\": 4, \"clips\": [], \"facts\": " + deep + "}"})
    EXPECT_EQ(refusal_of([&] { items_after(whole + damaged + "\n"); }), kept + ": is damaged; remove " + dataset.folder)
        << damaged.substr(0, 100);
}

}  // namespace
}  // namespace inhabit
