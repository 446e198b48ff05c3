#include <algorithm>
#include <filesystem>
#include <memory>

#include "inhabit/data/import_set.h"
#include "inhabit/error.h"
#include "inhabit/io/pickle.h"
#include "inhabit/io/upright.h"
#include "inhabit/lower_case.h"
#include "inhabit/motion/human36m_joints.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

constexpr double kHuman36mRate = 50;

ImportedMotion positions_motion(const torch::Tensor& given, const std::string& subject) {
  ImportedMotion out{human36m_clip(given, kHuman36mRate, subject), {}};
  rotate_upright(out.clip);
  return out;
}

/// "walking" of "WalkDog 1", "Walking" and "walking_2".
std::string action_of(std::string name) {
  name.resize(std::min(name.find_first_of(" _"), name.size()));
  return lower_case(name);
}

}  // namespace

// S1/ACTION_N.txt (exponential maps, motion_set.h), or data_3d_h36m.npz with positions_3d: a dictionary of people, each
// one of recordings (T, 32, 3), metres, 50 Hz, +Z up.
ImportSet open_human36m(const std::string& folder, const ClipReadOptions&) {
  ImportSet set;
  const std::string file = fs::is_directory(folder) ? folder + "/data_3d_h36m.npz" : folder;
  if (!fs::exists(file)) {
    add_motion_set(set, "h36m:" + folder);
    if (set.recordings.empty() && set.broken.empty())
      set.missing.emplace_back("S1/ACTION_N.txt (exponential maps) or data_3d_h36m.npz (positions of joints)");
    return set;
  }
  const auto pickle = std::make_shared<Pickle>(read_npz_objects(file, "positions_3d"));
  set.splits = "as in the paper's table of 17 joints: S9 and S11 are tested on";
  const auto& people = pickle->root->items;
  if (pickle->root->kind != PickleValue::Kind::dict) throw Error(file, "its positions_3d is no dictionary of people");
  for (size_t p = 0; p + 1 < people.size(); p += 2) {
    const std::string& person = pickle->text(*people[p], "name of a person");
    const auto& recordings = people[p + 1]->items;
    for (size_t k = 0; people[p + 1]->kind == PickleValue::Kind::dict && k + 1 < recordings.size(); k += 2) {
      const std::string& name = pickle->text(*recordings[k], "name of a recording");
      ImportRecording r{.name = person, .person = person, .action = action_of(name)};
      r.name.append("/").append(name);
      r.split = person == "S9" || person == "S11" ? "test" : "train";
      if (std::find(set.actions.begin(), set.actions.end(), r.action) == set.actions.end())
        set.actions.push_back(r.action);
      set.recordings.push_back(std::move(r));
    }
  }
  set.read = [pickle, file](const ImportRecording& r) {
    const PickleValue& recordings = pickle->at(*pickle->root, r.person);
    const std::string name = r.name.substr(r.person.size() + 1), subject = file + ": " + r.name;
    return positions_motion(pickle->numbers(pickle->at(recordings, name), name), subject);
  };
  return set;
}

}  // namespace inhabit
