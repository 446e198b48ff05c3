#include "inhabit/data/import_dataset.h"

#include <c10/util/Exception.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>

#include "inhabit/body/body_model.h"
#include "inhabit/data/dataset_items.h"
#include "inhabit/data/import_clip.h"
#include "inhabit/data/import_state.h"
#include "inhabit/each_item.h"
#include "inhabit/error.h"
#include "inhabit/io/clip_npz.h"
#include "inhabit/metrics/touch_labels.h"
#include "inhabit/motion/canonical.h"
#include "inhabit/motion/floor.h"
#include "inhabit/scene/floor.h"
#include "inhabit/scene/query.h"

namespace inhabit {
namespace {

constexpr double kFloorSize = 40;  ///< metres: a floor where no scene is given

/// What became of a recording.
struct Imported {
  std::optional<DatasetClip> entry;
  bool kept = false;
  std::string skipped;
};

/// Recordings that share a scene, in one split.
struct Group {
  std::string scene;  ///< file in the data set
  std::vector<size_t> members;
};

class Import {
 public:
  Import(const ImportSet& set, const std::string& folder, const Shard& shard)
      : set_(set),
        dataset_(continue_dataset(folder, set.actions.empty() ? told_actions() : set.actions, shard)),
        state_(folder, set.format, shard),
        made_(set.recordings.size()) {}

  /// Those of this shard.
  std::vector<Group> groups() {
    std::map<std::string, Group> by_scene;
    std::vector<Group> out;
    std::set<std::string> used;
    for (size_t i = 0; i < set_.recordings.size(); ++i) {
      const ImportRecording& r = set_.recordings[i];
      std::string name = import_file_name(r.name);
      while (!used.insert(name).second) name += "_";
      files_.push_back("clips/" + name + ".npz");
      const std::string scene = (r.scene.empty() ? "floor" : import_file_name(r.scene)) + "_" + r.split;
      Group& group = by_scene[scene];
      group.scene = "scenes/" + scene + ".glb";
      group.members.push_back(i);
    }
    for (const auto& [name, group] : by_scene) {
      // A floor has nothing to be read once: each recording by itself.
      if (!set_.recordings[group.members.front()].scene.empty()) {
        out.push_back(group);
        continue;
      }
      write_floor(group.scene);
      for (const size_t member : group.members) out.push_back({group.scene, {member}});
    }
    std::vector<Group> mine;
    for (size_t g = 0; g < out.size(); ++g)
      if (dataset_.shard.has(static_cast<int64_t>(g))) mine.push_back(out[g]);
    for (const Group& group : mine) mine_.insert(group.members.begin(), group.members.end());
    return mine;
  }

  template <class Done>
  void run(const Group& group, const Done& done) {
    std::unique_ptr<TouchLabels> labels;
    const ImportRecording& first = set_.recordings[group.members.front()];
    std::string no_scene;  // why it cannot be read
    for (const size_t i : group.members) {
      Imported& made = made_[i];
      const ImportRecording& recording = set_.recordings[i];
      DatasetClip entry{files_[i], group.scene, recording.split, 0, recording.name};
      try {
        if (!no_scene.empty()) throw Error(no_scene);
        if (state_.has_floor(group.scene) && (made.entry = imported_clip(dataset_, entry))) {
          made.kept = true;
        } else {
          ImportedMotion motion = prepared_motion(set_, recording);
          const double floor = floor_of(group.scene, first, motion.clip, no_scene);
          motion.clip = transformed(motion.clip, {0, {0, -floor, 0}});
          if (!labels) labels = std::make_unique<TouchLabels>(load_scene(dataset_, group.scene), builtin_body());
          write(entry, motion, *labels, recording);
          made.entry = entry;
        }
      } catch (const Error& e) {
        made.skipped = e.what();
      } catch (const c10::Error& e) {  // arrays of shapes that nobody thought of: no reason to end the others
        const std::string message = e.what_without_backtrace();
        made.skipped = recording.name + ": " + message.substr(0, message.find('\n'));
      }
      done();
    }
  }

  ImportResult finish(std::vector<std::string> skipped) {
    ImportResult out;
    DatasetItems items;
    for (const size_t i : mine_) {
      const Imported& made = made_[i];
      DatasetItem& item = items[static_cast<int64_t>(i)];
      item.facts = made.skipped;
      if (!made.entry) continue;
      item.clips = {*made.entry};
      ++(made.kept ? out.kept : out.made);
    }
    for (const auto& [i, item] : gather_items(dataset_, items))
      if (const auto reason = item.facts.get<std::string>(); !reason.empty()) skipped.push_back(reason);
    if (dataset_.whole && dataset_.clips.empty())
      throw Error(set_.folder, "no recording can be used; of the first: " + (skipped.empty() ? "" : skipped.front()));
    dataset_.provenance = {{"command", "inhabit import " + set_.format}, {"splits", set_.splits}};
    if (!skipped.empty()) dataset_.provenance["skipped"] = skipped;
    if (!set_.missing.empty()) dataset_.provenance["missing"] = set_.missing;
    if (dataset_.whole) write_index(dataset_);
    dataset_.locks.clear();  // it is made
    out.skipped = std::move(skipped);
    out.dataset = dataset_;
    return out;
  }

 private:
  void write_floor(const std::string& name) {
    if (state_.has_floor(name)) return;
    write_scene(dataset_, name, floor_scene(kFloorSize));
    state_.set_floor(name, 0);
  }

  /// How far up the floor is in the recording's world; the scene is written when the first asks.
  double floor_of(const std::string& name, const ImportRecording& first, const Clip& clip, std::string& no_scene) {
    if (first.scene.empty()) return floor_under(clip);
    if (state_.has_floor(name) && std::filesystem::exists(dataset_.folder + "/" + name)) return state_.floor(name);
    Scene scene;
    try {
      scene = set_.scene(first);
    } catch (const Error& e) {
      no_scene = e.what();
      throw;
    }
    const double floor = floor_under(clip, SceneQuery(scene));
    write_scene(dataset_, name, raised(scene, -floor));
    state_.set_floor(name, floor);
    return floor;
  }

  void write(DatasetClip& entry, ImportedMotion& motion, const TouchLabels& labels, const ImportRecording& recording) {
    Clip& clip = motion.clip;
    labels.label(clip);
    label_actions(clip);
    if (!set_.actions.empty()) {
      const auto action = std::find(set_.actions.begin(), set_.actions.end(), recording.action) - set_.actions.begin();
      clip.action_names = set_.actions;
      clip.action = torch::full({clip.frames()}, static_cast<int64_t>(action), torch::kInt64);
    }
    const std::string path = dataset_.folder + "/" + entry.file;
    Npz arrays = npz_from_clip(clip, path);
    arrays.tensors.insert(motion.more.begin(), motion.more.end());
    entry.frames = clip.frames();
    write_npz(path, arrays);
  }

  const ImportSet& set_;
  Dataset dataset_;
  ImportState state_;
  std::vector<std::string> files_;
  std::vector<Imported> made_;
  std::set<size_t> mine_;  ///< recordings of this shard
};

}  // namespace

ImportResult import_dataset(const ImportSet& set, const std::string& folder, const ImportOptions& options) {
  if (options.jobs < 0) throw Error("jobs", "are fewer than none");
  Import importing(set, folder, options.shard);
  const std::vector<Group> groups = importing.groups();
  size_t recordings = 0;
  for (const Group& group : groups) recordings += group.members.size();
  std::mutex counting;
  int64_t count = 0;
  each_item(
      static_cast<int64_t>(groups.size()), {},
      [&](int64_t g) {
        const torch::NoGradGuard no_gradient;
        importing.run(groups[static_cast<size_t>(g)], [&] {
          const std::lock_guard<std::mutex> lock(counting);
          ++count;
          if (options.progress) options.progress(count, static_cast<int64_t>(recordings));
        });
      },
      options.jobs);
  return importing.finish(set.broken);
}

}  // namespace inhabit
