#include "inhabit/data/dataset_items.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>

#include "inhabit/each_item.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"
#include "inhabit/version.h"

namespace inhabit {
namespace {

using nlohmann::json;

std::string part_path(const std::string& folder, const Shard& shard) {
  return folder + "/shards/" + shard.name() + ".json";
}

json to_json(int64_t item, const DatasetItem& made) {
  json clips = json::array();
  for (const DatasetClip& c : made.clips) clips.push_back({c.file, c.scene, c.split, c.frames, c.source});
  return {{"item", item}, {"clips", std::move(clips)}, {"facts", made.facts}};
}

void read_item(const json& one, DatasetItems& items) {
  DatasetItem& item = items[one.at("item").get<int64_t>()];
  item.facts = one.at("facts");
  for (const json& c : one.at("clips"))
    item.clips.push_back({c.at(0).get<std::string>(), c.at(1).get<std::string>(), c.at(2).get<std::string>(),
                          c.at(3).get<int64_t>(), c.at(4).get<std::string>()});
}

void read_part(const std::string& path, DatasetItems& items) {
  try {
    for (const json& one : parse_json(read_whole_file(path, uint64_t{1} << 28), path)) read_item(one, items);
  } catch (const json::exception&) {
    throw Error(path, "is no list of a shard's clips; remove it and make that shard again");
  }
}

std::string unfinished_path(const Dataset& dataset) {
  return dataset.folder + "/unfinished" + (dataset.shard.is_all() ? "" : "-" + dataset.shard.name()) + ".jsonl";
}

/// The items that an unfinished run has made: a first line with its job, then a line for each.
class Unfinished {
 public:
  Unfinished(const Dataset& dataset, const json& job)
      : path_(unfinished_path(dataset)), head_(json({{"version", INHABIT_VERSION}, {"job", job}}).dump()) {
    if (std::filesystem::exists(path_)) read(dataset.folder);
  }

  const DatasetItems& items() const { return items_; }

  /// From several threads at once.
  void add(int64_t item, const DatasetItem& made) {
    const std::lock_guard<std::mutex> lock(mutex_);
    items_[item] = made;
    if (made.clips.empty()) return;  // a full disk or a signal may be why
    if (!file_.is_open()) {          // what was read, without a line that was not written to its end
      std::string lines = head_ + "\n";
      for (const auto& [number, known] : items_)
        if (number != item && !known.clips.empty()) lines += to_json(number, known).dump() + "\n";
      write_atomically(path_, lines);
      file_.open(path_, std::ios::app);
    }
    errno = 0;
    file_ << to_json(item, made).dump() << std::endl;
    if (!file_) throw Error(path_, std::string("cannot be written: ") + std::strerror(errno));
  }

 private:
  void read(const std::string& folder) {
    std::istringstream lines(read_whole_file(path_, uint64_t{1} << 30));
    std::string line;
    std::getline(lines, line);
    if (line != head_)
      throw Error(path_, "is of a run with other settings, or of another version than " INHABIT_VERSION
                         ", that was not finished: finish it as it was begun, or remove " +
                             folder);
    DatasetItems found;
    const Error damaged(path_, "is damaged; remove " + folder);
    try {
      while (std::getline(lines, line) && !lines.eof()) read_item(parse_json(line, path_), found);
    } catch (const json::exception&) {
      throw damaged;
    } catch (const Error&) {
      throw damaged;
    }
    const auto filled = [&](const std::string& file) {  // a machine that went down may have left it empty
      std::error_code missing;
      const auto size = std::filesystem::file_size(folder + "/" + file, missing);
      return !missing && size > 0;
    };
    const auto there = [&](const DatasetClip& clip) {
      return filled(clip.file) && (clip.scene.empty() || filled(clip.scene));
    };
    for (auto& [item, made] : found)
      if (std::all_of(made.clips.begin(), made.clips.end(), there)) items_[item] = std::move(made);
  }

  std::string path_, head_;
  DatasetItems items_;
  std::ofstream file_;
  std::mutex mutex_;
};

}  // namespace

DatasetItems gather_items(Dataset& dataset, DatasetItems items) {
  const Shard& shard = dataset.shard;
  const std::string& folder = dataset.folder;
  dataset.whole = true;
  if (!shard.is_all()) {
    json part = json::array();
    for (const auto& [item, made] : items) part.push_back(to_json(item, made));
    write_atomically(part_path(folder, shard), part.dump(1) + "\n");
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

DatasetItems make_items(Dataset& dataset, const json& job, const std::vector<int64_t>& shard_items,
                        const Progress& progress, const std::function<DatasetItem(int64_t item)>& make) {
  Unfinished unfinished(dataset, job);
  std::vector<int64_t> left;
  std::copy_if(shard_items.begin(), shard_items.end(), std::back_inserter(left),
               [&](int64_t item) { return unfinished.items().count(item) == 0; });
  each_item(static_cast<int64_t>(left.size()), progress, [&](int64_t k) {
    const int64_t item = left[static_cast<size_t>(k)];
    unfinished.add(item, make(item));
  });
  return gather_items(dataset, unfinished.items());
}

void finish_items(const Dataset& dataset) {
  if (dataset.whole) write_index(dataset);
  std::filesystem::remove(unfinished_path(dataset));
}

}  // namespace inhabit
