#include <gtest/gtest.h>

#include <chrono>
#include <random>

// The targets' own source: this program is the only other one that needs it.
#include "../fuzz/targets.cpp"  // NOLINT(bugprone-suspicious-include)
#include "inhabit/io/atomic_file.h"

namespace {

using Random = std::mt19937_64;

int64_t below(Random& random, size_t n) {
  return static_cast<int64_t>(std::uniform_int_distribution<size_t>(0, n - 1)(random));
}

/// One to four small faults of the kinds that files have: bits flipped, bytes lost, doubled, cut off, numbers made
/// absurd.
std::string mutated(std::string bytes, Random& random) {
  static const std::vector<std::string> words = {
      "nan", "-1", "inf", "1e999", "99999999999",          "0",
      ",",   "{",  "}",   "\n",    std::string(4, '\xFF'), std::string(4, '\0'),
      "\x7F"};
  for (int64_t k = below(random, 4); k >= 0 && !bytes.empty(); --k) {
    const int64_t at = below(random, bytes.size());
    const auto from = bytes.begin() + at;
    const int64_t length = std::min<int64_t>(1 + below(random, 64), static_cast<int64_t>(bytes.size()) - at);
    const std::string& word = words[static_cast<size_t>(below(random, words.size()))];
    switch (below(random, 6)) {
      case 0:
        *from = static_cast<char>(*from ^ (1 << below(random, 8)));
        break;
      case 1:
        *from = static_cast<char>(below(random, 256));
        break;
      case 2:
        bytes.erase(from, from + length);
        break;
      case 3:
        bytes.insert(static_cast<size_t>(at), std::string(from, from + length));
        break;
      case 4:
        bytes.resize(static_cast<size_t>(at));
        break;
      default:
        bytes.replace(static_cast<size_t>(at), std::min(word.size(), bytes.size() - static_cast<size_t>(at)), word);
    }
  }
  return bytes;
}

class FuzzSmoke : public ::testing::TestWithParam<FuzzTarget> {};

/// Fixed seed, so that a fault comes again; the time is bounded, so that a slow machine does less.
TEST_P(FuzzSmoke, SeedsAndTheirMutationsEndInAValueOrAnError) {
  const FuzzTarget& target = GetParam();
  const std::string folder = INHABIT_SOURCE_DIR "/tests/fuzz/seeds/" + target.name;
  std::vector<std::string> seeds, refused;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const bool bad = entry.path().filename().string().rfind("bad_", 0) == 0;  // must be refused
    (bad ? refused : seeds).push_back(inhabit::read_whole_file(entry.path().string()));
  }
  std::sort(seeds.begin(), seeds.end());
  ASSERT_FALSE(seeds.empty()) << folder;
  int accepted = 0;
  auto run = [&](const std::string& bytes) {
    try {
      accepted += target.run(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()) ? 1 : 0;
    } catch (const std::exception& e) {
      const std::string kept = (std::filesystem::temp_directory_path() / ("inhabit_fuzz_" + target.name)).string();
      inhabit::write_atomically(kept, bytes);
      FAIL() << target.name << " threw something else than an Error (input kept in " << kept << "): " << e.what();
    }
  };
  run("");
  for (const std::string& seed : seeds) run(seed);
  EXPECT_EQ(accepted, static_cast<int>(seeds.size())) << "a seed is no longer a good file";
  for (const std::string& bytes : refused) run(bytes);
  EXPECT_EQ(accepted, static_cast<int>(seeds.size())) << "a bad file is taken for a good one";
  Random random(20240611);
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(1000);
  int runs = 0;
  for (; runs < 3000 && !HasFatalFailure(); ++runs) {
    if (std::chrono::steady_clock::now() > end) break;
    run(mutated(seeds[static_cast<size_t>(below(random, seeds.size()))], random));
  }
  EXPECT_GT(runs, 0);
}

INSTANTIATE_TEST_SUITE_P(Readers, FuzzSmoke, ::testing::ValuesIn(fuzz_targets()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
