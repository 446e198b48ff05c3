// Protects the words of --shard, and that a part's damaged list is named.
#include "inhabit/data/shard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "inhabit/data/dataset_items.h"
#include "inhabit/io/atomic_file.h"
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
  for (const char* damaged : {"[{\"item\": 1}]", "{}1", "[{\"item\": \"x\", \"facts\": 1, \"clips\": []}]", "[1]"}) {
    write_atomically(folder / "d/shards/2-of-2.json", damaged);
    EXPECT_THAT(refusal_of([&] { gather_items(part, {}); }), testing::HasSubstr("2-of-2.json")) << damaged;
  }
}

}  // namespace
}  // namespace inhabit
