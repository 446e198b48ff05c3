#include "inhabit/data/shard.h"

#include <charconv>

#include "inhabit/error.h"

namespace inhabit {

constexpr int64_t kMostShards = 100'000;

Shard parse_shard(const std::string& text) {
  Shard out;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, out.number);
  const bool slash = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
  const auto second = slash ? std::from_chars(first.ptr + 1, end, out.of) : first;
  if (!slash || second.ec != std::errc() || second.ptr != end || out.of < 1 || out.of > kMostShards || out.number < 1 ||
      out.number > out.of)
    throw Error("--shard", "'" + text.substr(0, 40) + "' is not I/N with I from 1 to N, such as 2/8");
  return out;
}

}  // namespace inhabit
