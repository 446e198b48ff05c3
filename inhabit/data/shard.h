#pragma once
#include <cstdint>
#include <string>

namespace inhabit {

/// A part of a big job, for several machines or processes that write one data set: shard I of N does every Nth item.
/// What an item becomes does not depend on N.
struct Shard {
  int64_t number = 1;  ///< I, from 1
  int64_t of = 1;      ///< N

  /// Whether an item, counted from 0 over the whole job, is in this part.
  bool has(int64_t item) const { return item % of == number - 1; }
  /// Whether there is only one part.
  bool is_all() const { return of == 1; }
  /// "2-of-8", for files.
  std::string name() const { return std::to_string(number) + "-of-" + std::to_string(of); }
};

/// "2/8". Throws Error("--shard", ...) for anything else, or more than 100,000 shards.
Shard parse_shard(const std::string& text);

}  // namespace inhabit
