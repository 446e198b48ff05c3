#include "inhabit/motion/landmarks.h"

#include <algorithm>

#include "inhabit/error.h"
#include "inhabit/motion/joint_label.h"

namespace inhabit {
namespace {

class Finder {
 public:
  Finder(const Skeleton& skeleton, const std::string& subject) : skeleton_(skeleton), subject_(subject) {
    for (const std::string& name : skeleton.names) labels_.push_back(joint_label(name));
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
  out.head = finder.need(part_names::kHead, -1, -1, "head");
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

}  // namespace inhabit
