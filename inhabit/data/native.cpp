#include "inhabit/data/native.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <map>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/gltf.h"
#include "inhabit/io/json_text.h"
#include "inhabit/io/many_files.h"
#include "inhabit/io/scene_file.h"

namespace inhabit {
namespace {

using nlohmann::json;

constexpr const char* kFormat = "inhabit-dataset";
constexpr int kVersion = 1;
constexpr uint64_t kLargestIndex = uint64_t{1} << 28;
constexpr int64_t kMostFrames = 100'000'000;
constexpr size_t kMostJoints = 1024, kMostActions = 4096;

std::string index_path(const std::string& folder) { return folder + "/dataset.json"; }

const json& member(const json& object, const char* key, const std::string& where, const std::string& subject) {
  if (!object.is_object()) throw Error(subject, where + " is not an object");
  const auto it = object.find(key);
  if (it == object.end()) throw Error(subject, where + " has no \"" + key + "\"");
  return *it;
}

std::string text(const json& value, const std::string& where, const std::string& subject) {
  if (!value.is_string()) throw Error(subject, where + " is not a text");
  return value.get<std::string>();
}

const json& list(const json& value, const std::string& where, const std::string& subject, size_t most) {
  if (!value.is_array()) throw Error(subject, where + " is not a list");
  if (value.size() > most) throw Error(subject, where + " has more than " + std::to_string(most) + " entries");
  return value;
}

std::vector<std::string> texts(const json& value, const std::string& where, const std::string& subject, size_t most) {
  std::vector<std::string> out;
  for (const json& v : list(value, where, subject, most))
    out.push_back(text(v, where + "[" + std::to_string(out.size()) + "]", subject));
  return out;
}

int64_t whole_number(const json& value, const std::string& where, const std::string& subject, int64_t low,
                     int64_t high) {
  const bool fits = value.is_number_unsigned() ? value.get<uint64_t>() <= static_cast<uint64_t>(high)
                                               : value.is_number_integer() && value.get<int64_t>() <= high;
  if (!fits || value.get<int64_t>() < low)
    throw Error(subject, where + " is not a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return value.get<int64_t>();
}

// A path that stays inside the folder, with one of the given extensions.
void check_path(const std::string& path, const std::string& where, const std::string& subject, bool scene) {
  const std::filesystem::path p(path);
  bool inside = !path.empty() && path.size() < 1024 && p.is_relative() && path.find('\\') == std::string::npos &&
                path.find(':') == std::string::npos;
  for (const unsigned char c : path) inside &= c >= 0x20;
  for (const auto& part : p) inside &= part != ".." && part != "." && !part.empty();
  if (!inside) throw Error(subject, where + " is not a path inside the data set's folder");
  const std::string extension = extension_of(path);
  if (scene ? !is_scene_extension(extension) : extension != "npz")
    throw Error(subject, where + (scene ? " is no scene file" : " is no .npz file"));
}

// Everything that must hold between the entries, whoever wrote them.
void check(const Dataset& d, const std::string& subject) {
  if (!(d.rate > 0 && d.rate <= 1000)) throw Error(subject, "\"rate\" is not in (0, 1000]");
  Skeleton skeleton{d.joint_names, d.parents, torch::zeros({static_cast<int64_t>(d.parents.size()), 3})};
  skeleton.validate(subject);
  std::map<std::string, std::string> split_of;
  for (size_t i = 0; i < d.clips.size(); ++i) {
    const DatasetClip& c = d.clips[i];
    const std::string where = "clips[" + std::to_string(i) + "]";
    check_path(c.file, where + ".file", subject, false);
    if (c.split != "train" && c.split != "val" && c.split != "test")
      throw Error(subject, where + ".split is not train, val or test");
    if (c.scene.empty()) continue;
    check_path(c.scene, where + ".scene", subject, true);
    const auto [it, fresh] = split_of.emplace(c.scene, c.split);
    if (!fresh && it->second != c.split)
      throw Error(subject, where + ": scene " + c.scene + " is in both " + it->second + " and " + c.split);
  }
}

bool holds_motion(const std::string& folder) {
  try {
    return std::filesystem::is_directory(folder) && !motion_files({folder}).empty();
  } catch (const Error&) {
    return false;
  }
}

bool is_motion(const std::string& file) {
  if (extension_of(file) == "json" && std::filesystem::path(file).filename() == "dataset.json") return false;
  try {
    return is_clip_file(file);
  } catch (const Error&) {
    return false;
  }
}

/// What is read for a data set's clip: training without it would lose data without a word.
template <class Read>
auto of_dataset(const Read& read) {
  try {
    return read();
  } catch (const Error& e) {
    throw Error(std::string(e.what()) + "; remove the clip from dataset.json or make it again");
  }
}

/// Throws Error(file, ...) where a clip's file or its scene's is missing, or the clip's archive is torn.
void require_files(const Dataset& dataset, const DatasetClip& entry) {
  for (const std::string& name : {entry.file, entry.scene})
    if (const std::string path = dataset.folder + "/" + name; !name.empty() && !std::filesystem::exists(path))
      throw Error(path,
                  "there is no such file, dataset.json names it; remove the clip from dataset.json or make it again");
  read_npz(dataset.folder + "/" + entry.file, {"rate"});
}

}  // namespace

void require_split(const std::string& name) {
  if (name != "train" && name != "val" && name != "test" && name != "all")
    throw Error("split", "'" + name + "' is none of train, val, test and all");
}

std::vector<DatasetClip> Dataset::split(const std::string& name) const {
  require_split(name);
  std::vector<DatasetClip> out;
  for (const DatasetClip& c : clips)
    if (name == "all" || c.split == name) out.push_back(c);
  return out;
}

Dataset open_dataset(const std::string& folder) {
  const std::string subject = index_path(folder);
  const auto no_dataset = [&](const char* but) {
    return Error(folder, std::string("is no data set but ") + but + "; `inhabit synth fit --mocap " + folder +
                             " --out DATASET` makes one of it");
  };
  if (!std::filesystem::exists(subject) && holds_motion(folder)) throw no_dataset("a folder of motion");
  if (std::filesystem::is_regular_file(folder)) {
    if (is_motion(folder)) throw no_dataset("a motion file");
    throw Error(folder, "is a file, no folder of a data set");
  }
  const json root = parse_json(read_whole_file(subject, kLargestIndex), subject);
  if (!root.is_object() || root.value("format", json()) != kFormat)
    throw Error(subject, "is no index of a data set (\"format\" is not \"inhabit-dataset\")");
  if (root.value("version", json()) != kVersion) throw Error(subject, "\"version\" is not " + std::to_string(kVersion));
  Dataset out;
  out.folder = folder;
  const json& rate = member(root, "rate", "the index", subject);
  if (!rate.is_number()) throw Error(subject, "\"rate\" is not a number");
  out.rate = rate.get<double>();
  const json& skeleton = member(root, "skeleton", "the index", subject);
  out.joint_names = texts(member(skeleton, "names", "skeleton", subject), "skeleton.names", subject, kMostJoints);
  for (const json& p : list(member(skeleton, "parents", "skeleton", subject), "skeleton.parents", subject, kMostJoints))
    out.parents.push_back(static_cast<int>(whole_number(p, "skeleton.parents", subject, -1, kMostJoints)));
  out.actions = texts(member(root, "actions", "the index", subject), "actions", subject, kMostActions);
  out.provenance = root.value("provenance", json::object());
  for (const json& c : list(member(root, "clips", "the index", subject), "clips", subject, kLargestIndex)) {
    const std::string where = "clips[" + std::to_string(out.clips.size()) + "]";
    DatasetClip entry;
    entry.file = text(member(c, "file", where, subject), where + ".file", subject);
    entry.split = text(member(c, "split", where, subject), where + ".split", subject);
    entry.frames = whole_number(member(c, "frames", where, subject), where + ".frames", subject, 1, kMostFrames);
    if (c.contains("scene")) entry.scene = text(c["scene"], where + ".scene", subject);
    if (c.contains("source")) entry.source = text(c["source"], where + ".source", subject);
    out.clips.push_back(std::move(entry));
  }
  check(out, subject);
  return out;
}

std::vector<size_t> clips_at_hand(const Dataset& dataset, const std::string& split) {
  require_split(split);
  std::vector<size_t> out;
  size_t skipped = 0;
  for (size_t c = 0; c < dataset.clips.size(); ++c) {
    const DatasetClip& entry = dataset.clips[c];
    if (split != "all" && entry.split != split) continue;
    try {
      require_files(dataset, entry);
      out.push_back(c);
    } catch (const Error& e) {
      if (entry.split != "train") throw;
      spdlog::warn("skipped: {}", e.what());
      ++skipped;
    }
  }
  if (skipped > 0) spdlog::warn("{}: {} of {} clips were skipped", dataset.folder, skipped, out.size() + skipped);
  return out;
}

Clip load_clip(const Dataset& dataset, const DatasetClip& entry) {
  const std::string path = dataset.folder + "/" + entry.file;
  return of_dataset([&] { return clip_from_arrays(dataset, entry, read_npz(path), path); });
}

Clip clip_from_arrays(const Dataset& dataset, const DatasetClip& entry, const Npz& arrays, const std::string& subject) {
  for (const char* name : {"joint_names", "parents", "offsets"})
    if (!arrays.has(name) && arrays.strings.count(name) == 0)
      throw Error(subject, std::string("has no ") + name + ": every clip of a data set says its own skeleton");
  Clip clip = clip_from_npz(arrays, subject);
  if (clip.frames() != entry.frames)
    throw Error(subject,
                "has " + std::to_string(clip.frames()) + " frames, dataset.json says " + std::to_string(entry.frames));
  if (std::abs(clip.rate - dataset.rate) > 1e-6) throw Error(subject, "its frame rate is not the data set's");
  if (clip.skeleton.parents != dataset.parents) throw Error(subject, "its skeleton is not the data set's");
  if (clip.action.defined() && (clip.action.min().item<int64_t>() < 0 ||
                                clip.action.max().item<int64_t>() >= static_cast<int64_t>(dataset.actions.size())))
    throw Error(subject, "has an action that dataset.json does not name");
  return clip;
}

Scene load_scene(const Dataset& dataset, const std::string& name) {
  check_path(name, "scene \"" + name + "\"", index_path(dataset.folder), true);
  return of_dataset([&] { return read_scene_file(dataset.folder + "/" + name).scene; });
}

Dataset create_dataset(const std::string& folder, const std::vector<std::string>& actions, const Shard& shard) {
  const auto require_none = [&] {
    if (std::filesystem::exists(index_path(folder))) throw Error(folder, "a data set is there already");
  };
  require_none();
  Dataset out = continue_dataset(folder, actions, shard);
  require_none();  // another run may have written one until it was locked
  return out;
}

Dataset continue_dataset(const std::string& folder, const std::vector<std::string>& actions, const Shard& shard) {
  std::vector<std::string> inside = {"/clips", "/scenes"};
  if (!shard.is_all()) inside.emplace_back("/shards");
  for (const std::string& sub : inside) {
    std::error_code failed;
    std::filesystem::create_directories(folder + sub, failed);
    if (failed) throw Error(folder + sub, "cannot be made: " + failed.message());
  }
  Dataset out;
  out.locks.push_back(std::make_shared<FileLock>(folder, "another run", !shard.is_all()));
  if (!shard.is_all())
    out.locks.push_back(std::make_shared<FileLock>(folder + "/shards/" + shard.name() + ".lock", "another run"));
  out.shard = shard;
  out.folder = folder;
  out.joint_names = standard_joint_names();
  out.parents = standard_parents();
  out.actions = actions;
  return out;
}

void write_scene(const Dataset& dataset, const std::string& name, const Scene& scene) {
  write_glb(dataset.folder + "/" + name, {}, &scene);
}

void write_clip(const Dataset& dataset, DatasetClip& entry, const Clip& clip) {
  entry.frames = clip.frames();
  write_clip_npz(dataset.folder + "/" + entry.file, clip);
}

std::string summary(const Dataset& dataset) {
  if (!dataset.whole)
    return fmt::format("{}: shard {}, {} clips; the others are still to come", dataset.folder, dataset.shard.name(),
                       dataset.clips.size());
  double seconds = 0;
  for (const DatasetClip& clip : dataset.clips) seconds += static_cast<double>(clip.frames) / dataset.rate;
  const auto clips_in = [&](const char* split) { return dataset.split(split).size(); };
  return fmt::format("{}: {} clips, {:.1f} minutes; train {}, val {}, test {}", dataset.folder, dataset.clips.size(),
                     seconds / 60, clips_in("train"), clips_in("val"), clips_in("test"));
}

void write_index(const Dataset& dataset) {
  const std::string path = index_path(dataset.folder);
  check(dataset, path);
  json clips = json::array();
  for (const DatasetClip& c : dataset.clips) {
    json entry = {{"file", c.file}, {"split", c.split}, {"frames", c.frames}};
    if (!c.scene.empty()) entry["scene"] = c.scene;
    if (!c.source.empty()) entry["source"] = c.source;
    clips.push_back(std::move(entry));
  }
  const json root = {
      {"format", kFormat},          {"version", kVersion},
      {"rate", dataset.rate},       {"skeleton", {{"names", dataset.joint_names}, {"parents", dataset.parents}}},
      {"actions", dataset.actions}, {"provenance", dataset.provenance},
      {"clips", std::move(clips)}};
  write_atomically(path, root.dump(1) + "\n");
}

}  // namespace inhabit
