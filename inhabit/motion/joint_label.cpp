#include "inhabit/motion/joint_label.h"

#include <algorithm>
#include <cctype>
#include <map>

namespace inhabit {

namespace part_names {
const std::vector<std::string> kHip = {"upleg", "upperleg", "thigh", "thighbend", "femur", "hip"};
const std::vector<std::string> kKnee = {"knee", "lowleg", "lowerleg", "shin", "calf", "tibia", "foreleg", "leg"};
const std::vector<std::string> kAnkle = {"ankle", "foot"};
const std::vector<std::string> kToe = {"toebase", "toe", "toes", "toe0", "ball", "forefoot", "foot"};
const std::vector<std::string> kShoulder = {"upperarm", "uparm",     "uarm", "humerus",
                                            "shldr",    "shldrbend", "arm",  "shoulder"};
const std::vector<std::string> kElbow = {"forearm", "forearmbend", "lowerarm", "lowarm", "farm", "elbow", "radius"};
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

namespace {

using Words = std::vector<std::string>;

/// Letters and digits between separators, in lower case; all before a name space's colon is left out.
Words words_of(const std::string& name) {
  const size_t space = name.find_last_of(":|");
  Words words(1);
  for (const char c : space == std::string::npos ? name : name.substr(space + 1)) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u))
      words.back() += static_cast<char>(std::tolower(u));
    else if (!words.back().empty())
      words.emplace_back();
  }
  if (words.back().empty() && words.size() > 1) words.pop_back();
  return words;
}

JointLabel label_of(const Words& words) {
  JointLabel out;
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

/// Takes off the first word (or the last) that four in five names share; false where there is none.
bool drop_shared(std::vector<Words>& names, bool first) {
  const auto end_of = [first](Words& words) { return first ? words.begin() : words.end() - 1; };
  std::map<std::string, size_t> times;
  for (Words& words : names)
    if (words.size() > 1) ++times[*end_of(words)];
  for (const auto& [word, count] : times) {
    if (5 * count < 4 * names.size()) continue;
    for (Words& words : names)
      if (words.size() > 1 && *end_of(words) == word) words.erase(end_of(words));
    return true;
  }
  return false;
}

}  // namespace

JointLabel joint_label(const std::string& name) { return label_of(words_of(name)); }

std::vector<JointLabel> joint_labels(const std::vector<std::string>& names) {
  std::vector<Words> words;
  for (const std::string& name : names) words.push_back(words_of(name));
  if (names.size() > 4)
    for (const bool first : {true, false})
      while (drop_shared(words, first)) {
      }
  std::vector<JointLabel> out;
  for (const Words& one : words) out.push_back(label_of(one));
  return out;
}

}  // namespace inhabit
