#include "inhabit/data/dataset_items.h"

#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"

namespace inhabit {
namespace {

using nlohmann::json;

std::string part_path(const std::string& folder, const Shard& shard) {
  return folder + "/shards/" + shard.name() + ".json";
}

json to_json(const DatasetItems& items) {
  json out = json::array();
  for (const auto& [item, made] : items) {
    json clips = json::array();
    for (const DatasetClip& c : made.clips) clips.push_back({c.file, c.scene, c.split, c.frames, c.source});
    out.push_back({{"item", item}, {"clips", std::move(clips)}, {"facts", made.facts}});
  }
  return out;
}

void read_part(const std::string& path, DatasetItems& items) {
  try {
    for (const json& one : parse_json(read_whole_file(path, uint64_t{1} << 28), path)) {
      DatasetItem& item = items[one.at("item").get<int64_t>()];
      item.facts = one.at("facts");
      for (const json& c : one.at("clips"))
        item.clips.push_back({c.at(0).get<std::string>(), c.at(1).get<std::string>(), c.at(2).get<std::string>(),
                              c.at(3).get<int64_t>(), c.at(4).get<std::string>()});
    }
  } catch (const json::exception&) {
    throw Error(path, "is no list of a shard's clips; remove it and make that shard again");
  }
}

}  // namespace

DatasetItems gather_items(Dataset& dataset, DatasetItems items) {
  const Shard& shard = dataset.shard;
  const std::string& folder = dataset.folder;
  dataset.whole = true;
  if (!shard.is_all()) {
    write_atomically(part_path(folder, shard), to_json(items).dump(1) + "\n");
    for (Shard other{1, shard.of}; other.number <= shard.of; ++other.number)
      if (!std::filesystem::exists(part_path(folder, other))) dataset.whole = false;
    for (Shard other{1, shard.of}; dataset.whole && other.number <= shard.of; ++other.number)
      if (other.number != shard.number) read_part(part_path(folder, other), items);
  }
  dataset.clips.clear();
  for (const auto& [item, made] : items)
    dataset.clips.insert(dataset.clips.end(), made.clips.begin(), made.clips.end());
  return items;
}

}  // namespace inhabit
