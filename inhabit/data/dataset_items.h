#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "inhabit/data/native.h"

namespace inhabit {

/// What came of an item of work (a room, a recording): its clips, and what the generator wants to know at the end.
struct DatasetItem {
  std::vector<DatasetClip> clips;
  nlohmann::json facts;
};

/// Items by their place in the whole job.
using DatasetItems = std::map<int64_t, DatasetItem>;

/// Keeps the items of a shard in FOLDER/shards/ and gives those of all shards once they are all there: to the last of
/// them, which writes the index. Nothing before that. The items themselves where there is only one shard.
std::optional<DatasetItems> gather_items(const Dataset& dataset, DatasetItems items);

}  // namespace inhabit
