#pragma once
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "inhabit/data/native.h"
#include "inhabit/progress.h"

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

/// Makes the items of a shard on all threads and gathers them. Each that has clips is kept in FOLDER/unfinished.jsonl
/// (unfinished-2-of-8.jsonl) as soon as it is made, so that a run that was ended goes on where it was when it is
/// started again; what nothing came of is tried again. The file is there until finish_items().
/// @param job all that the items depend on. @param shard_items their places in the whole job. @param make called with
/// such a place, from several threads at once
/// @return what gather_items does. Throws Error(FOLDER/unfinished.jsonl, ...) where the run that was ended had another
/// job, or was of another version of this library, which may make other clips of it
DatasetItems make_items(Dataset& dataset, const nlohmann::json& job, const std::vector<int64_t>& shard_items,
                        const Progress& progress, const std::function<DatasetItem(int64_t item)>& make);

/// Writes the index where all shards are there, and removes what make_items keeps.
void finish_items(const Dataset& dataset);

}  // namespace inhabit
