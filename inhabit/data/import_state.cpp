#include "inhabit/data/import_state.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"

namespace inhabit {

ImportState::ImportState(const std::string& folder, const std::string& format, const Shard& shard)
    : path_(folder + (shard.is_all() ? "/import.json" : "/import-" + shard.name() + ".json")), format_(format) {
  if (!std::filesystem::exists(path_)) {
    if (std::filesystem::exists(folder + "/dataset.json")) throw Error(folder, "a data set is there already");
    return;
  }
  const nlohmann::json root = parse_json(read_whole_file(path_, uint64_t{1} << 26), path_);
  if (!root.is_object() || root.value("format", nlohmann::json()) != format)
    throw Error(folder, "an import of another format is there already");
  const nlohmann::json floors = root.value("floors", nlohmann::json::object());
  if (!floors.is_object()) throw Error(path_, "\"floors\" is no object");
  for (const auto& [scene, floor] : floors.items()) {
    if (!floor.is_number()) throw Error(path_, "the floor of " + scene + " is no number");
    floors_[scene] = floor.get<double>();
  }
}

bool ImportState::has_floor(const std::string& scene) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return floors_.count(scene) != 0;
}

double ImportState::floor(const std::string& scene) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return floors_.at(scene);
}

void ImportState::set_floor(const std::string& scene, double metres) {
  const std::lock_guard<std::mutex> lock(mutex_);
  floors_[scene] = metres;
  write_atomically(path_, nlohmann::json{{"format", format_}, {"floors", floors_}}.dump(1) + "\n");
}

}  // namespace inhabit
