#include "inhabit/motion/joint_label.h"

#include <algorithm>
#include <cctype>

namespace inhabit {

namespace part_names {
const std::vector<std::string> kHip = {"upleg", "upperleg", "thigh", "thighbend", "femur", "hip"};
const std::vector<std::string> kKnee = {"knee", "lowleg", "lowerleg", "shin", "calf", "tibia", "foreleg", "leg"};
const std::vector<std::string> kAnkle = {"ankle", "foot"};
const std::vector<std::string> kToe = {"toebase", "toe", "toes", "toe0", "ball", "forefoot", "foot"};
const std::vector<std::string> kShoulder = {"upperarm", "uparm", "humerus", "shldr", "shldrbend", "arm", "shoulder"};
const std::vector<std::string> kElbow = {"forearm", "forearmbend", "lowerarm", "lowarm", "elbow", "radius"};
const std::vector<std::string> kWrist = {"wrist", "hand"};
const std::vector<std::string> kHead = {"head"};
}  // namespace part_names

namespace {

bool known_part(const std::string& part) {
  using namespace part_names;
  for (const auto* names : {&kHip, &kKnee, &kAnkle, &kToe, &kShoulder, &kElbow, &kWrist})
    if (std::find(names->begin(), names->end(), part) != names->end()) return true;
  return false;
}

bool take_off(std::string& text, const std::string& what) {
  const size_t at = text.find(what);
  if (at == std::string::npos) return false;
  text.erase(at, what.size());
  return true;
}

// What tools put before their joints' names.
bool is_prefix(const std::string& word) {
  static const std::vector<std::string> words = {"cc", "base", "def", "valvebiped", "j", "c"};
  return word.substr(0, 3) == "bip" || word.substr(0, 9) == "mixamorig" ||
         std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

JointLabel joint_label(const std::string& name) {
  JointLabel out;
  const size_t space = name.find_last_of(":|");
  std::vector<std::string> words(1);
  for (const char c : space == std::string::npos ? name : name.substr(space + 1)) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u))
      words.back() += static_cast<char>(std::tolower(u));
    else if (!words.back().empty())
      words.emplace_back();
  }
  for (const std::string& word : words) {
    if (out.side < 0 && (word == "l" || word == "r"))
      out.side = word == "r" ? 1 : 0;
    else if (!is_prefix(word))
      out.part += word;
  }
  if (out.side < 0) {
    if (take_off(out.part, "left"))
      out.side = 0;
    else if (take_off(out.part, "right"))
      out.side = 1;
    else if (out.part.size() > 1 && (out.part[0] == 'l' || out.part[0] == 'r') && known_part(out.part.substr(1))) {
      out.side = out.part[0] == 'r' ? 1 : 0;
      out.part.erase(0, 1);
    }
  }
  return out;
}

}  // namespace inhabit
