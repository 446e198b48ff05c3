// Protects the cache of clips and scenes where several threads ask: a value is made once, values of different keys at
// the same time, a failure is told to whoever waits and is not kept.
#include "inhabit/data/cache.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace inhabit {
namespace {

TEST(RecentCache, MakesAValueOnceHoweverManyThreadsAsk) {
  std::atomic<int> made = 0;
  RecentCache<int> cache(8, [&](const std::string& key) {
    ++made;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return static_cast<int>(key.size());
  });
  std::vector<std::future<int>> asked;
  asked.reserve(8);
  for (int i = 0; i < 8; ++i) asked.push_back(std::async(std::launch::async, [&] { return cache.get("four"); }));
  for (auto& value : asked) EXPECT_EQ(value.get(), 4);
  EXPECT_EQ(made, 1);
}

TEST(RecentCache, MakesValuesOfTwoKeysAtTheSameTime) {
  std::promise<void> second_began;
  RecentCache<int> cache(8, [&](const std::string& key) {
    if (key == "second") {
      second_began.set_value();
      return 2;
    }
    // Comes back in time only where the second is made beside this one.
    return second_began.get_future().wait_for(std::chrono::seconds(20)) == std::future_status::ready ? 1 : -1;
  });
  auto first = std::async(std::launch::async, [&] { return cache.get("first"); });
  EXPECT_EQ(cache.get("second"), 2);
  EXPECT_EQ(first.get(), 1);
}

TEST(RecentCache, ForgetsTheOneAskedForLongestAgo) {
  std::vector<std::string> made;
  RecentCache<int> cache(2, [&](const std::string& key) {
    made.push_back(key);
    return 0;
  });
  for (const char* key : {"a", "b", "a", "c", "a", "b"}) cache.get(key);
  EXPECT_EQ(made, (std::vector<std::string>{"a", "b", "c", "b"}));
}

TEST(RecentCache, AFailureIsNotKept) {
  bool fails = true;
  RecentCache<int> cache(2, [&](const std::string&) {
    if (fails) throw std::runtime_error("cannot be read");
    return 7;
  });
  EXPECT_THROW(cache.get("a"), std::runtime_error);
  fails = false;
  EXPECT_EQ(cache.get("a"), 7);
}

}  // namespace
}  // namespace inhabit
