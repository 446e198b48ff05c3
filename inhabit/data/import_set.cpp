#include "inhabit/data/import_set.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "inhabit/error.h"

namespace inhabit {
namespace {

using OpenImport = ImportSet (*)(const std::string&, const ClipReadOptions&);

struct ImportFormat {
  const char* name;
  OpenImport open;
};

constexpr ImportFormat kImportFormats[] = {
    {"amass", open_amass}, {"trumans", open_trumans}, {"samp", open_samp},
    {"prox", open_prox},   {"gta-im", open_gta_im},   {"human36m", open_human36m},
    {"cmu", open_cmu},     {"gimo", open_gimo},       {"couch", open_couch}};

/// FNV-1a, so that an order follows from names and is the same everywhere.
uint64_t hash_of(const std::string& text) {
  uint64_t hash = 14695981039346656037ULL;
  for (const unsigned char c : text) hash = (hash ^ c) * 1099511628211ULL;
  return hash;
}

/// What `key` says of the recordings that `chosen` takes, each once, in an order drawn by name.
template <class Chosen, class Key>
std::vector<std::string> keys_of(const ImportSet& set, const Chosen& chosen, const Key& key) {
  std::set<std::string> all;
  for (const ImportRecording& r : set.recordings)
    if (chosen(r)) all.insert(key(r));
  std::vector<std::string> out(all.begin(), all.end());
  std::sort(out.begin(), out.end(), [](const std::string& a, const std::string& b) {
    return std::pair(hash_of(a), a) < std::pair(hash_of(b), b);
  });
  return out;
}

}  // namespace

const std::vector<std::string>& import_formats() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const ImportFormat& format : kImportFormats) out.emplace_back(format.name);
    return out;
  }();
  return names;
}

ImportSet open_import_set(const std::string& format, const std::string& folder, const BodyModel* body) {
  std::error_code none;
  if (!std::filesystem::exists(folder, none)) throw Error(folder, "there is no such folder");
  if (!std::filesystem::is_directory(folder, none) && format != "human36m") throw Error(folder, "is no folder");
  ClipReadOptions reading;
  reading.body = body;
  for (const ImportFormat& known : kImportFormats) {
    if (format != known.name) continue;
    ImportSet set = known.open(folder, reading);
    set.format = format;
    set.folder = folder;
    if (set.recordings.empty()) {
      std::string reason = "holds no recording of " + format;
      if (!set.broken.empty())
        reason += " that can be read; the first: " + set.broken.front();
      else if (!set.missing.empty())
        reason += ": " + set.missing.front();
      throw Error(folder, reason);
    }
    std::sort(set.recordings.begin(), set.recordings.end(),
              [](const auto& a, const auto& b) { return a.name < b.name; });
    assign_splits(set);
    return set;
  }
  std::string all;
  for (const std::string& name : import_formats()) all += (all.empty() ? "" : ", ") + name;
  throw Error(format, "is no format of a data set: " + all);
}

void assign_splits(ImportSet& set) {
  const auto open = [](const ImportRecording& r) { return r.split.empty(); };
  const auto trained = [](const ImportRecording& r) { return r.split == "train"; };
  const auto name = [](const ImportRecording& r) { return r.name; };
  const auto person = [](const ImportRecording& r) { return r.person; };
  const auto scene = [](const ImportRecording& r) { return r.scene.empty() ? r.name : r.scene; };
  if (std::any_of(set.recordings.begin(), set.recordings.end(), open)) {
    const bool people = keys_of(set, open, person).size() >= 3;
    const std::vector<std::string> keys = people ? keys_of(set, open, person) : keys_of(set, open, name);
    const size_t tenth = keys.size() < 3 ? 0 : std::max<size_t>(1, keys.size() / 10);
    for (ImportRecording& r : set.recordings) {
      if (!r.split.empty()) continue;
      const auto place =
          static_cast<size_t>(std::find(keys.begin(), keys.end(), people ? r.person : r.name) - keys.begin());
      r.split = place < tenth ? "test" : place < 2 * tenth ? "val" : "train";
    }
    set.splits = std::string("even, ") + (people ? "by person" : "by recording") +
                 ": a tenth is tested on, a tenth validated on, drawn by name";
    return;
  }
  const auto validated = [](const ImportRecording& r) { return r.split == "val"; };
  if (std::any_of(set.recordings.begin(), set.recordings.end(), validated)) return;
  // The paper has no validation, training needs it: no person is in both where scenes allow that, no scene anyway.
  std::map<std::string, std::set<std::string>> people_of;
  for (const ImportRecording& r : set.recordings) people_of[scene(r)].insert(r.person);
  const bool people =
      keys_of(set, trained, person).size() >= 3 &&
      std::all_of(people_of.begin(), people_of.end(), [](const auto& s) { return s.second.size() == 1; });
  const std::vector<std::string> keys = people ? keys_of(set, trained, person) : keys_of(set, trained, scene);
  if (keys.size() < 3) return;
  const std::set<std::string> for_validation(
      keys.begin(), keys.begin() + std::max<std::ptrdiff_t>(1, static_cast<std::ptrdiff_t>(keys.size() / 10)));
  for (ImportRecording& r : set.recordings)
    if (trained(r) && for_validation.count(people ? r.person : scene(r)) != 0) r.split = "val";
  set.splits +=
      "; of what is trained on a tenth " + std::string(people ? "by person" : "by scene") + " is validated on";
}

}  // namespace inhabit
