#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

#include "inhabit/data/import_set.h"
#include "inhabit/error.h"
#include "inhabit/io/pickle.h"
#include "inhabit/io/upright.h"
#include "inhabit/motion/usual_skeleton.h"

namespace fs = std::filesystem;

namespace inhabit {
namespace {

constexpr double kHuman36mRate = 50;

struct Human36mJoint {
  int64_t row;  ///< of the 32
  const char* name;
  int parent;  ///< among these 17
};

// The 17 joints of the 32 that move, with the tree that they hang in.
constexpr std::array<Human36mJoint, 17> kHuman36mJoints = {{{0, "Hips", -1},
                                                            {1, "RightUpLeg", 0},
                                                            {2, "RightLeg", 1},
                                                            {3, "RightFoot", 2},
                                                            {6, "LeftUpLeg", 0},
                                                            {7, "LeftLeg", 4},
                                                            {8, "LeftFoot", 5},
                                                            {12, "Spine", 0},
                                                            {13, "Spine1", 7},
                                                            {14, "Neck", 8},
                                                            {15, "Head", 9},
                                                            {17, "LeftArm", 8},
                                                            {18, "LeftForeArm", 11},
                                                            {19, "LeftHand", 12},
                                                            {25, "RightArm", 8},
                                                            {26, "RightForeArm", 14},
                                                            {27, "RightHand", 15}}};

ImportedMotion positions_motion(const torch::Tensor& given, const std::string& subject) {
  if (given.dim() != 3 || given.size(2) != 3 || (given.size(1) != 32 && given.size(1) != 17) || given.size(0) == 0)
    throw Error(subject, "is not (T, 32, 3) or (T, 17, 3)");
  std::vector<int64_t> rows;
  std::vector<std::string> names;
  std::vector<int> parents;
  for (const Human36mJoint& joint : kHuman36mJoints) {
    rows.push_back(given.size(1) == 32 ? joint.row : static_cast<int64_t>(rows.size()));
    names.emplace_back(joint.name);
    parents.push_back(joint.parent);
  }
  const UsualSkeleton usual = usual_skeleton(names, parents, subject);
  ImportedMotion out;
  Clip& clip = out.clip;
  clip.skeleton = usual.skeleton;
  clip.rate = kHuman36mRate;
  const std::vector<int64_t> order(usual.order.begin(), usual.order.end());
  clip.joints =
      given.to(torch::kFloat32).index_select(1, torch::tensor(rows)).index_select(1, torch::tensor(order)).contiguous();
  validate(clip, subject);
  turn_upright(clip);
  return out;
}

/// "walking" of "WalkDog 1", "Walking" and "walking_2".
std::string action_of(std::string name) {
  name.resize(std::min(name.find_first_of(" _"), name.size()));
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
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
