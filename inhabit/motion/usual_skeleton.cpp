#include "inhabit/motion/usual_skeleton.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <set>

#include "inhabit/body/proportions.h"
#include "inhabit/error.h"
#include "inhabit/motion/joint_label.h"
#include "inhabit/motion/landmarks.h"

namespace inhabit {
namespace {

using Names = std::vector<std::string>;

constexpr size_t kMostJoints = 1000;

const Names kPelvis = {"pelvis", "hips", "hip", "root", "midhip", "hipcenter", "spinebase", "waist"};
const Names kTrunk = {"spine", "chest", "thorax", "abdomen", "torso", "back", "body"};
const Names kCollar = {"collar", "clavicle", "clav"};

bool holds(const std::string& part, const Names& words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& word) { return part.find(word) != std::string::npos; });
}

/// How far up the trunk a joint is, by its name: chests above spines, then by number.
int height_of(const std::string& part) {
  const size_t digit = part.find_first_of("0123456789");
  const int number = digit == std::string::npos ? 0 : part[digit] - '0';
  return number + (holds(part, {"upper", "shoulder"}) ? 20 : holds(part, {"chest", "thorax"}) ? 10 : 0);
}

/// The joints of names that stand for parts; -1 where there is none.
struct Parts {
  int pelvis = -1, head = -1;
  std::vector<int> spine, necks;
  std::array<int, 2> hip{-1, -1}, knee{-1, -1}, ankle{-1, -1}, collar{-1, -1}, shoulder{-1, -1}, elbow{-1, -1},
      wrist{-1, -1};
  std::vector<JointLabel> labels;

  int find(const Names& names, int side) const {
    for (const std::string& name : names)
      for (size_t j = 0; j < labels.size(); ++j)
        if (labels[j].side == side && labels[j].part == name) return static_cast<int>(j);
    return -1;
  }

  Parts(const Names& names, const std::string& subject) {
    labels = joint_labels(names);
    pelvis = find(kPelvis, -1);
    if (pelvis < 0) throw Error(subject, "no joint is called pelvis, hips or root; \"parents\" tell what hangs where");
    head = find(part_names::kHead, -1);
    for (int j = 0; j < static_cast<int>(labels.size()); ++j) {
      const auto& [side, part] = labels[static_cast<size_t>(j)];
      if (side >= 0 || j == pelvis || j == head) continue;
      if (part.find("neck") != std::string::npos)
        necks.push_back(j);
      else if (holds(part, kTrunk))
        spine.push_back(j);
    }
    for (std::vector<int>* chain : {&spine, &necks})
      std::stable_sort(chain->begin(), chain->end(), [&](int a, int b) {
        return height_of(labels[static_cast<size_t>(a)].part) < height_of(labels[static_cast<size_t>(b)].part);
      });
    for (size_t s = 0; s < 2; ++s) {
      const int side = static_cast<int>(s);
      hip[s] = find(part_names::kHip, side);
      knee[s] = find(part_names::kKnee, side);
      ankle[s] = find(part_names::kAnkle, side);
      shoulder[s] = find(part_names::kShoulder, side);
      elbow[s] = find(part_names::kElbow, side);
      wrist[s] = find(part_names::kWrist, side);
      collar[s] = find(kCollar, side);
      if (const int also = find({"shoulder"}, side); collar[s] < 0 && also != shoulder[s]) collar[s] = also;
    }
  }

  int trunk() const { return spine.empty() ? pelvis : spine.back(); }

  int parent(int j) const {
    if (j == pelvis) return -1;
    const auto before = [j](const std::vector<int>& chain, int start) {
      const auto at = std::find(chain.begin(), chain.end(), j);
      return at == chain.begin() ? start : *(at - 1);
    };
    if (std::find(spine.begin(), spine.end(), j) != spine.end()) return before(spine, pelvis);
    if (std::find(necks.begin(), necks.end(), j) != necks.end()) return before(necks, trunk());
    if (j == head) return necks.empty() ? trunk() : necks.back();
    const auto or_else = [](int one, int other) { return one >= 0 ? one : other; };
    for (size_t s = 0; s < 2; ++s) {
      if (j == hip[s]) return pelvis;
      if (j == knee[s]) return or_else(hip[s], pelvis);
      if (j == ankle[s]) return or_else(knee[s], pelvis);
      if (j == collar[s]) return trunk();
      if (j == shoulder[s]) return or_else(collar[s], trunk());
      if (j == elbow[s]) return or_else(shoulder[s], trunk());
      if (j == wrist[s]) return or_else(elbow[s], trunk());
    }
    const auto& [side, part] = labels[static_cast<size_t>(j)];
    if (holds(part, {"eye", "ear", "nose", "head", "jaw", "chin", "face"})) return or_else(head, trunk());
    if (side < 0) return pelvis;
    const auto s = static_cast<size_t>(side);
    if (holds(part, {"hand", "thumb", "finger", "index", "middle", "ring", "pinky", "knuckle"}))
      return or_else(wrist[s], trunk());
    return or_else(holds(part, {"toe", "heel", "foot", "ball"}) ? ankle[s] : -1, pelvis);
  }
};

/// The joints, parents before children: as they are given where they are so. Throws where parents go round in a circle
/// or there is not one root.
std::vector<int> parents_first(const std::vector<int>& parents, const std::string& subject) {
  const auto count = static_cast<int>(parents.size());
  std::vector<int> order;
  bool already = true;
  for (int j = 0; j < count; ++j) {
    const int parent = parents[static_cast<size_t>(j)];
    already = already && parent < j;
    if (parent < -1 || parent >= count || parent == j) throw Error(subject, "a joint's parent does not exist");
    if (parent == -1) order.push_back(j);
  }
  if (order.size() != 1) throw Error(subject, "not one joint but " + std::to_string(order.size()) + " have no parent");
  if (already) {
    order.resize(parents.size());
    std::iota(order.begin(), order.end(), 0);
    return order;
  }
  for (size_t k = 0; k < order.size(); ++k)
    for (int j = 0; j < count; ++j)
      if (parents[static_cast<size_t>(j)] == order[k]) order.push_back(j);
  if (order.size() != parents.size()) throw Error(subject, "parents go round in a circle");
  return order;
}

}  // namespace

Skeleton standing_skeleton() {
  Skeleton out{standard_joint_names(), standard_parents(), torch::zeros({kStandardJoints, 3})};
  const std::array<Eigen::Vector3d, kStandardJoints> rest = builtin_rest_joints();
  for (int j = 0; j < kStandardJoints; ++j) {
    const int parent = out.parents[static_cast<size_t>(j)];
    Eigen::Vector3d offset = rest[static_cast<size_t>(j)];
    if (parent >= 0) offset -= rest[static_cast<size_t>(parent)];
    if (j >= 18) offset = -offset.norm() * Eigen::Vector3d::UnitY();  // at rest arms are stretched sideways
    for (int k = 0; k < 3; ++k) out.offsets[j][k] = offset[k];
  }
  return out;
}

UsualSkeleton usual_skeleton(const std::vector<std::string>& names, const std::vector<int>& parents,
                             const std::string& subject) {
  if (names.empty() || names.size() > kMostJoints)
    throw Error(subject, std::to_string(names.size()) + " joints are named, not 1 to " + std::to_string(kMostJoints));
  if (std::set<std::string>(names.begin(), names.end()).size() != names.size())
    throw Error(subject, "a name is there twice");
  UsualSkeleton out;
  if (names == standard_joint_names() && (parents.empty() || parents == standard_parents())) {
    out.skeleton = standing_skeleton();
    for (int j = 0; j < kStandardJoints; ++j) out.order.push_back(j);
    return out;
  }
  std::vector<int> tree = parents;
  if (tree.empty()) {
    const Parts parts(names, subject);
    for (int j = 0; j < static_cast<int>(names.size()); ++j) tree.push_back(parts.parent(j));
  }
  if (tree.size() != names.size()) throw Error(subject, "there are not as many parents as names");
  out.order = parents_first(tree, subject);
  std::vector<int> place(names.size());
  for (size_t k = 0; k < out.order.size(); ++k) place[static_cast<size_t>(out.order[k])] = static_cast<int>(k);
  out.skeleton.offsets = torch::zeros({static_cast<int64_t>(names.size()), 3});
  for (size_t k = 0; k < out.order.size(); ++k) {
    const auto j = static_cast<size_t>(out.order[k]);
    out.skeleton.names.push_back(names[j]);
    out.skeleton.parents.push_back(tree[j] < 0 ? -1 : place[static_cast<size_t>(tree[j])]);
  }
  find_landmarks(out.skeleton, subject);
  return out;
}

}  // namespace inhabit
