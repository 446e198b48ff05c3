#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "inhabit/data/native.h"

namespace inhabit {

/// What came of an item of work (a room, a recording): its clips, and what the generator wants to know at the end.
struct DatasetItem {
  std::vector<DatasetClip> clips;  ///< none where nothing could be made
  nlohmann::json facts;            ///< whatever the generator counts
};

/// Items by their place in the whole job.
using DatasetItems = std::map<int64_t, DatasetItem>;

/// Keeps the items of a shard in FOLDER/shards/, and says in `dataset` whether those of all shards are there (`whole`)
/// and which clips are known: of all of them then, of this shard before. The last shard writes the index.
/// @return the items that the clips are of
DatasetItems gather_items(Dataset& dataset, DatasetItems items);

}  // namespace inhabit
