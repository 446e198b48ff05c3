#include "inhabit/motion/landmarks.h"

#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/motion/joint_label.h"

namespace inhabit {
namespace {

class Finder {
 public:
  Finder(const Skeleton& skeleton, const std::string& subject) : skeleton_(skeleton), subject_(subject) {
    labels_ = joint_labels(skeleton.names);
  }

  // The joint of that part and side which hangs below `above` (any joint where that is -1).
  int find(const std::vector<std::string>& names, int side, int above) const {
    for (const std::string& name : names)
      for (int j = 0; j < skeleton_.size(); ++j) {
        const JointLabel& label = labels_[static_cast<size_t>(j)];
        if (label.side == side && label.part == name && (above < 0 || (j != above && is_below(j, above)))) return j;
      }
    return -1;
  }
  int need(const std::vector<std::string>& names, int side, int above, const std::string& part) const {
    const int found = find(names, side, above);
    if (found < 0)
      throw Error(subject_, "no joint of the skeleton (" + some_names() + ") stands for the " +
                                (side < 0    ? ""
                                 : side == 0 ? "left "
                                             : "right ") +
                                part);
    return found;
  }
  /// The last joint up the spine or neck from `above`, for skeletons that number these up to the head; -1 if none.
  int spine_end(int above) const {
    int out = -1;
    for (int j = above + 1; j < skeleton_.size(); ++j) {
      const JointLabel& label = labels_[static_cast<size_t>(j)];
      // The end site of the head's joint is where the skull ends (io/bvh.h).
      const bool central = label.side < 0 && !skeleton_.names[static_cast<size_t>(j)].ends_with("_end") &&
                           (label.part.rfind("spine", 0) == 0 || label.part.rfind("neck", 0) == 0);
      if (central && is_below(j, above) && (out < 0 || is_below(j, out))) out = j;
    }
    return out;
  }
  bool is_below(int joint, int above) const {
    while (joint > above) joint = parent(joint);
    return joint == above;
  }
  int parent(int joint) const { return skeleton_.parents[static_cast<size_t>(joint)]; }
  int common(int a, int b) const {
    while (a != b) (a > b ? a : b) = parent(std::max(a, b));
    return a;
  }
  std::vector<int> path(int from, int to) const {
    std::vector<int> out;
    for (int j = to; j != from; j = parent(j)) out.push_back(j);
    out.push_back(from);
    std::reverse(out.begin(), out.end());
    return out;
  }

 private:
  std::string some_names() const {
    std::string out = std::to_string(skeleton_.size()) + " joints:";
    for (size_t j = 0; j < skeleton_.names.size() && j < 6; ++j) {
      out += (j ? ", " : " ");
      for (const char c : skeleton_.names[j].substr(0, 24)) out += static_cast<unsigned char>(c) < 32 ? '?' : c;
    }
    return out + (skeleton_.names.size() > 6 ? ", ..." : "");
  }

  const Skeleton& skeleton_;
  const std::string& subject_;
  std::vector<JointLabel> labels_;
};

}  // namespace

Landmarks find_landmarks(const Skeleton& skeleton, const std::string& subject) {
  skeleton.validate(subject);
  const Finder finder(skeleton, subject);
  Landmarks out;
  for (int side = 0; side < 2; ++side) {
    const auto s = static_cast<size_t>(side);
    out.hip[s] = finder.need(part_names::kHip, side, -1, "hip");
    out.knee[s] = finder.need(part_names::kKnee, side, out.hip[s], "knee");
    out.ankle[s] = finder.need(part_names::kAnkle, side, out.knee[s], "ankle");
    out.toe[s] = finder.find(part_names::kToe, side, out.ankle[s]);
    out.shoulder[s] = finder.need(part_names::kShoulder, side, -1, "shoulder");
    out.elbow[s] = finder.need(part_names::kElbow, side, out.shoulder[s], "elbow");
    out.wrist[s] = finder.need(part_names::kWrist, side, out.elbow[s], "wrist");
  }
  out.head = finder.find(part_names::kHead, -1, -1);
  if (out.head < 0) out.head = finder.spine_end(finder.common(out.shoulder[0], out.shoulder[1]));
  if (out.head < 0) finder.need(part_names::kHead, -1, -1, "head");
  out.thorax = finder.common(finder.common(out.shoulder[0], out.shoulder[1]), out.head);
  out.pelvis = finder.common(finder.common(out.hip[0], out.hip[1]), out.thorax);
  if (out.thorax == out.head || out.thorax == out.shoulder[0] || out.thorax == out.shoulder[1] ||
      out.pelvis == out.hip[0] || out.pelvis == out.hip[1])
    throw Error(subject, "the skeleton's tree is not that of a person: legs, arms and head do not part");
  out.spine = finder.path(out.pelvis, out.thorax);
  const int neck = finder.path(out.thorax, out.head)[1];
  if (neck != out.head) out.neck = neck;
  for (size_t s = 0; s < 2; ++s) {
    const int collar = finder.path(out.thorax, out.shoulder[s])[1];
    if (collar != out.shoulder[s]) out.collar[s] = collar;
  }
  return out;
}

std::array<int, kStandardJoints> counterparts(const Landmarks& marks) {
  std::array<int, kStandardJoints> out;
  out.fill(-1);
  out[0] = marks.pelvis;
  out[9] = marks.thorax;
  out[12] = marks.neck;
  out[15] = marks.head;
  for (size_t s = 0; s < 2; ++s) {
    out[1 + s] = marks.hip[s], out[4 + s] = marks.knee[s], out[7 + s] = marks.ankle[s];
    out[10 + s] = marks.toe[s], out[13 + s] = marks.collar[s];
    out[16 + s] = marks.shoulder[s], out[18 + s] = marks.elbow[s], out[20 + s] = marks.wrist[s];
  }
  return out;
}

namespace {

/// None stands for any where the skeleton is empty or a creature's.
std::array<int, kStandardJoints> counterparts_in(const Skeleton& file) {
  try {
    if (file.size() > 0) return counterparts(find_landmarks(file, "skeleton"));
  } catch (const Error&) {
  }
  return counterparts({});
}

}  // namespace

int standard_joint_called(const std::string& name, const Skeleton& file) {
  const std::vector<std::string>& names = standard_joint_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<int>(found - names.begin());
  const std::array<int, kStandardJoints> known = counterparts_in(file);
  for (size_t j = 0; j < known.size(); ++j)
    if (known[j] >= 0 && file.names[static_cast<size_t>(known[j])] == name) return static_cast<int>(j);
  return -1;
}

std::string joint_names_for(const Skeleton& file) {
  std::string out, of_file;
  const std::vector<std::string>& names = standard_joint_names();
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  for (const int joint : counterparts_in(file)) {
    if (joint < 0) continue;
    const std::string& name = file.names[static_cast<size_t>(joint)];
    if (std::find(names.begin(), names.end(), name) == names.end()) of_file += (of_file.empty() ? "" : ", ") + name;
  }
  return of_file.empty() ? out : out + "; of the file " + of_file;
}

}  // namespace inhabit
