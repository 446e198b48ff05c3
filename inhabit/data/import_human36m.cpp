#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <set>

#include "inhabit/data/import_set.h"
#include "inhabit/data/import_smpl.h"
#include "inhabit/error.h"
#include "inhabit/io/cdf.h"
#include "inhabit/io/extension.h"
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

/// "walking" of "Walking", "Walking 1" and "walking_2". Two actions of S1 have names of their own.
std::string action_of(std::string name) {
  name.resize(std::min(name.find_first_of(" _"), name.size()));
  name = lower_case(name);
  return name == "takingphoto" ? "photo" : name == "walkingdog" ? "walkdog" : name;
}

/// Adds a recording of positions, split as in the papers that use them.
void add_positions(ImportSet& set, const std::string& person, const std::string& name) {
  ImportRecording r{.name = person, .person = person, .action = action_of(name)};
  r.name.append("/").append(name);
  r.split = person == "S9" || person == "S11" ? "test" : "train";
  if (std::find(set.actions.begin(), set.actions.end(), r.action) == set.actions.end()) set.actions.push_back(r.action);
  set.recordings.push_back(std::move(r));
}

constexpr const char* kSplitsOfPositions = "as in the paper's table of 17 joints: S9 and S11 are tested on";

/// "S11" of a path through a folder of that name, of several the innermost; empty where there is none.
std::string person_on(const fs::path& path) {
  std::string person;
  for (const fs::path& part : path) {
    const std::string name = part.string();
    if (name.size() > 1 && name[0] == 'S' && name.find_first_not_of("0123456789", 1) == std::string::npos)
      person = name;
  }
  return person;
}

/// Adds the owners' files of positions, S1/MyPoseFeatures/D3_Positions/ACTION.cdf. Beside that folder lie others, of
/// features that are not read. @return what is there of the same people, but cannot be used
std::string add_owners_files(ImportSet& set, const std::string& folder) {
  const auto files = std::make_shared<std::map<std::string, std::string>>();
  std::set<std::string> people;
  std::string unused;
  for (const std::string& path : files_below(folder, [](const std::string& f) { return extension_of(f) == "cdf"; })) {
    const fs::path parent = fs::absolute(path).lexically_normal().parent_path();
    const std::string feature = parent.filename().string(), person = person_on(parent);
    if (feature.rfind("D3_Positions_mono", 0) == 0)
      unused = feature + " is not read: positions as four cameras see them, without the room's floor and upright";
    if (person.empty() || (feature != "D3_Positions" && feature != person)) continue;
    const std::string name = fs::path(path).stem().string();
    std::string recording = person;
    recording.append("/").append(name);
    people.insert(person);
    if (files->emplace(recording, path).second)
      add_positions(set, person, name);
    else
      set.broken.push_back(path + ": there is another recording of this name");
  }
  if (people.empty()) return unused;
  for (const char* person : {"S1", "S5", "S6", "S7", "S8", "S9", "S11"})
    if (people.count(person) == 0) set.missing.push_back(std::string(person) + "/MyPoseFeatures/D3_Positions");
  set.splits = kSplitsOfPositions;
  set.read = [files](const ImportRecording& r) {
    const std::string& path = files->at(r.name);
    const torch::Tensor pose = read_cdf(path).at("Pose", path);  // (..., 96) millimetres, all frames in one record
    if (pose.dim() < 2 || pose.size(-1) != 96 || pose.numel() == 0)
      throw Error(path, "its variable Pose does not have 32 joints a frame");
    return positions_motion(pose.to(torch::kFloat64).reshape({-1, 32, 3}) * 0.001, path);
  };
  return "";
}

}  // namespace

// data_3d_h36m.npz with positions_3d, a dictionary of people, each one of recordings (T, 32, 3), metres, 50 Hz, +Z up;
// or the owners' files of the same in millimetres; or S1/ACTION_N.txt (exponential maps, motion_set.h). What comes
// first here is read: the text has other splits, and who is trained on in one is tested on in the other.
ImportSet open_human36m(const std::string& folder, const ClipReadOptions&) {
  ImportSet set;
  const std::string file = fs::is_directory(folder) ? folder + "/data_3d_h36m.npz" : folder;
  if (!fs::exists(file)) {
    const std::string unused = add_owners_files(set, folder);
    if (!set.recordings.empty()) return set;
    add_motion_set(set, "h36m:" + folder);
    if (set.recordings.empty() && set.broken.empty())
      set.missing.insert(set.missing.begin(),
                         unused.empty() ? "S1/MyPoseFeatures/D3_Positions/ACTION.cdf or data_3d_h36m.npz (positions of "
                                          "joints), or S1/ACTION_N.txt (exponential maps)"
                                        : unused);
    return set;
  }
  const auto pickle = std::make_shared<Pickle>(read_npz_objects(file, "positions_3d"));
  set.splits = kSplitsOfPositions;
  const auto& people = pickle->root->items;
  if (pickle->root->kind != PickleValue::Kind::dict) throw Error(file, "its positions_3d is no dictionary of people");
  for (size_t p = 0; p + 1 < people.size(); p += 2) {
    const std::string& person = pickle->text(*people[p], "name of a person");
    const auto& recordings = people[p + 1]->items;
    for (size_t k = 0; people[p + 1]->kind == PickleValue::Kind::dict && k + 1 < recordings.size(); k += 2) {
      add_positions(set, person, pickle->text(*recordings[k], "name of a recording"));
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
