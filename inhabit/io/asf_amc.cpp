#include "inhabit/io/asf_amc.h"

#include <Eigen/Geometry>
#include <filesystem>
#include <map>

#include "inhabit/body/bones.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/text_lines.h"
#include "inhabit/io/utf8.h"
#include "inhabit/lower_case.h"
#include "inhabit/motion/locomotion.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

constexpr size_t kMostBones = 500;

struct Bone {
  std::string name;
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();  // end relative to start, file units; the root has none
  Eigen::Quaterniond axis = Eigen::Quaterniond::Identity();
  std::string axis_order = "XYZ";
  std::vector<std::string> dof;  // "rx", "ty", "l", ... in the order of the .amc's numbers
  std::vector<size_t> children;
};

struct Acclaim {
  std::vector<Bone> bones;  // 0 is the root
  std::map<std::string, size_t, std::less<>> by_name;
  double length = 1;
  bool radians = false;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // the root's rest position, file units
};

// Angles about x, y, z; the first axis of the order is applied first: "XYZ" is Rz Ry Rx.
Eigen::Quaterniond rotation_of(const Eigen::Vector3d& radians, const std::string& order) {
  Eigen::Quaterniond out = Eigen::Quaterniond::Identity();
  for (const char c : order) out = Eigen::AngleAxisd(radians[c - 'X'], Eigen::Vector3d::Unit(c - 'X')) * out;
  return out;
}

Eigen::Vector3d read_vector(const TextLines& lines, std::string_view& rest) {
  Eigen::Vector3d out;
  for (int k = 0; k < 3; ++k) {
    out[k] = lines.real(next_word(rest));
    if (!(std::abs(out[k]) < 1e9)) lines.fail("a number is too large");
  }
  return out;
}

std::string read_order(const TextLines& lines, std::string_view word) {
  std::string order;
  for (const char c : word) order += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string sorted = order;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != "XYZ") lines.fail(in_quotes(word) + " is no order of axes");
  return order;
}

std::string read_dof(const TextLines& lines, std::string_view word) {
  std::string dof = lower_case(word);
  const bool known =
      dof == "l" || (dof.size() == 2 && (dof[0] == 'r' || dof[0] == 't') && dof[1] >= 'x' && dof[1] <= 'z');
  if (!known) lines.fail(in_quotes(word) + " is no degree of freedom");
  return dof;
}

void read_bone(TextLines& lines, Acclaim& out) {
  if (out.bones.size() > kMostBones) lines.fail("more than " + std::to_string(kMostBones) + " bones");
  Bone bone;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::Zero();
  double length = 0;
  for (std::string_view line; lines.next_filled(line);) {
    const std::string key = lower_case(next_word(line));
    if (key == "end") {
      if (bone.name.empty()) lines.fail("a bone has no name");
      if (direction.norm() > 0) bone.tip = direction.normalized() * length;
      bone.axis = rotation_of(axis * (out.radians ? 1.0 : M_PI / 180), bone.axis_order);
      if (!out.by_name.emplace(bone.name, out.bones.size()).second)
        lines.fail("two bones are called " + in_quotes(bone.name));
      out.bones.push_back(std::move(bone));
      return;
    }
    if (key == "name") bone.name = std::string(next_word(line));
    if (key == "direction") direction = read_vector(lines, line);
    if (key == "length") length = lines.real(next_word(line));
    if (key == "axis") {
      axis = read_vector(lines, line);
      const std::string_view order = next_word(line);
      if (!order.empty()) bone.axis_order = read_order(lines, order);
    }
    if (key == "dof")
      for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
        bone.dof.push_back(read_dof(lines, word));
        if (bone.dof.size() > 7) lines.fail("more than 7 degrees of freedom");
      }
    // id, limits, bodymass, cofmass and lines that go on with limits say nothing about the motion.
  }
  lines.fail("the file ends inside a bone");
}

// The line after "root" or ":hierarchy begin": a parent and its children.
void read_children(TextLines& lines, std::string_view line, Acclaim& out, std::vector<bool>& has_parent) {
  const auto find = [&](std::string_view word) {
    const auto found = out.by_name.find(word);
    if (found == out.by_name.end()) lines.fail("unknown bone " + in_quotes(word));
    return found->second;
  };
  const size_t parent = find(next_word(line));
  for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
    const size_t child = find(word);
    if (child == 0) lines.fail("the root cannot hang on a bone");
    if (has_parent[child]) lines.fail("bone " + in_quotes(word) + " hangs on two others");
    has_parent[child] = true;
    out.bones[parent].children.push_back(child);
  }
}

Acclaim parse_asf(std::string_view text, const std::string& name) {
  TextLines lines(text, name);
  Acclaim out;
  out.bones.push_back({});
  out.bones[0].name = "root";
  out.by_name["root"] = 0;
  std::vector<bool> has_parent;
  Eigen::Vector3d orientation = Eigen::Vector3d::Zero();
  std::string section;
  for (std::string_view line; lines.next_filled(line);) {
    if (line.front() == '#') continue;
    if (line.front() == ':') {
      section = lower_case(next_word(line));
      continue;
    }
    const std::string_view whole = line;
    const std::string key = lower_case(next_word(line));
    if (section == ":units") {
      if (key == "length") out.length = lines.real(next_word(line));
      if (key == "angle") out.radians = lower_case(next_word(line)).substr(0, 3) == "rad";
      if (!(out.length > 0)) lines.fail("the unit of length must be positive");
    } else if (section == ":root") {
      if (key == "order") {
        for (std::string_view word = next_word(line); !word.empty() && out.bones[0].dof.size() < 7;
             word = next_word(line))
          out.bones[0].dof.push_back(read_dof(lines, word));
      } else if (key == "axis") {
        out.bones[0].axis_order = read_order(lines, next_word(line));
      } else if (key == "position") {
        out.place = read_vector(lines, line);
      } else if (key == "orientation") {
        orientation = read_vector(lines, line);
      }
    } else if (section == ":bonedata") {
      if (key != "begin") lines.fail("expected 'begin' of a bone, found " + in_quotes(key));
      read_bone(lines, out);
    } else if (section == ":hierarchy") {
      has_parent.resize(out.bones.size(), false);
      if (key != "begin" && key != "end") read_children(lines, whole, out, has_parent);
    }
  }
  if (out.bones.size() == 1) throw Error(name, "holds no bones; is it an .asf file?");
  if (out.bones[0].children.empty()) throw Error(name, "no bone hangs on the root");
  if (out.bones[0].dof.empty()) out.bones[0].dof = {"tx", "ty", "tz", "rx", "ry", "rz"};
  out.bones[0].axis = rotation_of(orientation * (out.radians ? 1.0 : M_PI / 180), out.bones[0].axis_order);
  return out;
}

// Joints of the skeleton: parents first. `bone` is -1 for a tip.
struct Layout {
  std::vector<int> bone;
  std::vector<int> joint_of_bone;
};

Layout lay_out(const Acclaim& asf, Skeleton& skeleton, const std::string& name) {
  Layout out;
  out.joint_of_bone.assign(asf.bones.size(), -1);
  std::vector<Eigen::Vector3d> offsets;
  struct Step {
    int bone, parent;
  };
  std::vector<Step> open = {{0, -1}};
  while (!open.empty()) {  // depth first, in the file's order
    const Step step = open.back();
    open.pop_back();
    const int joint = static_cast<int>(out.bone.size());
    const size_t from = step.parent < 0 ? 0 : static_cast<size_t>(out.bone[static_cast<size_t>(step.parent)]);
    out.bone.push_back(step.bone);
    skeleton.parents.push_back(step.parent);
    offsets.push_back(step.parent < 0 ? Eigen::Vector3d::Zero() : asf.bones[from].tip);
    if (step.bone < 0) {
      skeleton.names.push_back(as_utf8(asf.bones[from].name) + "_end");
      continue;
    }
    const Bone& bone = asf.bones[static_cast<size_t>(step.bone)];
    skeleton.names.push_back(as_utf8(bone.name));
    out.joint_of_bone[static_cast<size_t>(step.bone)] = joint;
    if (bone.children.empty()) open.push_back({-1, joint});
    for (auto child = bone.children.rbegin(); child != bone.children.rend(); ++child)
      open.push_back({static_cast<int>(*child), joint});
  }
  for (size_t b = 0; b < asf.bones.size(); ++b)
    if (out.joint_of_bone[b] < 0)
      throw Error(name, "bone " + in_quotes(asf.bones[b].name) + " does not hang on the root (or on a cycle)");
  skeleton.offsets = torch::empty({static_cast<int64_t>(offsets.size()), 3});
  for (size_t j = 0; j < offsets.size(); ++j)
    Eigen::Map<Eigen::Vector3f>(skeleton.offsets.data_ptr<float>() + 3 * j) = offsets[j].cast<float>();
  skeleton.validate(name);
  return out;
}

/// Metres of the .asf's unit of length: as given; else as it says itself where its people are as tall as people are;
/// else by their size, which is noted.
void set_unit(SourceMotion& out, const Acclaim& asf, std::optional<double> given, const std::string& name) {
  const double reach = longest_reach(out.clip.skeleton), stated = 0.0254 / asf.length;
  if (given) {
    out.metres_per_unit = *given;
    out.unit = "units of the given scale";
  } else if (reach * stated > 0.5 && reach * stated < 2.6) {
    out.metres_per_unit = stated;
    out.unit = "ASF units";
  } else {
    const LengthUnit unit = guess_length_unit(reach, name);
    out.metres_per_unit = unit.metres;
    out.unit = unit.name;
    out.notes.push_back("lengths taken for " + unit.name + " from the size of the person");
  }
}

/// The frames of an .amc, as far as they are read.
struct AmcFrames {
  const Acclaim& asf;
  const std::string& asf_name;
  const Layout& layout;
  const Bones rest;         // metres
  double metres_per_unit;   // of translations
  double radians_per_unit;  // of angles
  PoseTrack track;
  std::vector<int> seen;  // frame in which a bone last stood
  int frame = -1;
  bool bones_move = false, bones_stretch = false;
};

/// Fails where a bone of the present frame, if there is one, is missing.
void end_frame(const AmcFrames& frames, const TextLines& lines) {
  for (size_t b = 0; frames.frame >= 0 && b < frames.asf.bones.size(); ++b)
    if (!frames.asf.bones[b].dof.empty() && frames.seen[b] != frames.frame)
      lines.fail("frame " + std::to_string(frames.frame + 1) + " lacks bone " + in_quotes(frames.asf.bones[b].name));
}

/// The line with a frame's number: `number`, and nothing in `words` behind it.
void begin_frame(AmcFrames& frames, const TextLines& lines, std::string_view number, std::string_view words,
                 size_t most_rotations) {
  end_frame(frames, lines);
  lines.whole(number, 0, 1'000'000'000);
  if (!next_word(words).empty()) lines.fail("more than a frame's number");
  ++frames.frame;
  PoseTrack& track = frames.track;
  track.trans.emplace_back(Eigen::Vector3d::Zero());
  track.local.insert(track.local.end(), static_cast<size_t>(track.joints), Eigen::Quaterniond::Identity());
  track.places.insert(track.places.end(), frames.rest.offsets.begin(), frames.rest.offsets.end());
  if (track.local.size() > most_rotations) lines.fail("too many bones without a degree of freedom");
}

/// A line of the present frame: the bone's name, and in `words` a number for each of its degrees of freedom.
void read_frame_line(AmcFrames& frames, const TextLines& lines, std::string_view name, std::string_view words) {
  const Acclaim& asf = frames.asf;
  if (frames.frame < 0) lines.fail("expected the number of the first frame, found " + in_quotes(name));
  const auto found = asf.by_name.find(name);
  if (found == asf.by_name.end()) lines.fail("bone " + in_quotes(name) + " is not in " + frames.asf_name);
  const Bone& bone = asf.bones[found->second];
  if (frames.seen[found->second] == frames.frame) lines.fail("bone " + in_quotes(name) + " stands twice in one frame");
  frames.seen[found->second] = frames.frame;
  Eigen::Vector3d angles = Eigen::Vector3d::Zero(), moved = Eigen::Vector3d::Zero();
  for (const std::string& dof : bone.dof) {
    const std::string_view word = next_word(words);
    if (word.empty()) lines.fail("bone " + in_quotes(name) + " needs " + std::to_string(bone.dof.size()) + " numbers");
    const double value = lines.real(word);
    if (!(std::abs(value) < 1e9)) lines.fail(in_quotes(word) + " is too large");
    if (dof[0] == 'r') angles[dof[1] - 'x'] = value * frames.radians_per_unit;
    if (dof[0] == 't') moved[dof[1] - 'x'] = value;
    if (dof[0] == 'l') frames.bones_stretch = true;
  }
  if (!next_word(words).empty())
    lines.fail("bone " + in_quotes(name) + " has more than " + std::to_string(bone.dof.size()) + " numbers");
  PoseTrack& track = frames.track;
  const int joint = frames.layout.joint_of_bone[found->second];
  track.at(frames.frame, joint) = bone.axis * rotation_of(angles, bone.axis_order) * bone.axis.conjugate();
  if (found->second == 0) {
    track.at(frames.frame, 0) = rotation_of(angles, bone.axis_order) * bone.axis;
    track.trans.back() = (asf.place + moved) * frames.metres_per_unit;
  } else if (moved.norm() > 0) {
    frames.bones_move = true;
    track.places[track.places.size() - static_cast<size_t>(track.joints) + static_cast<size_t>(joint)] +=
        bone.axis * moved * frames.metres_per_unit;
  }
}

}  // namespace

SourceMotion parse_asf_amc(std::string_view asf_text, const std::string& asf_name, std::string_view amc_text,
                           const std::string& amc_name, std::optional<double> metres_per_unit) {
  if (metres_per_unit && !(*metres_per_unit > 0 && std::isfinite(*metres_per_unit)))
    throw Error(amc_name, "the scale must be a positive number");
  const Acclaim asf = parse_asf(asf_text, asf_name);
  SourceMotion out;
  out.clip.rate = 120;
  out.rate_assumed = true;
  const Layout layout = lay_out(asf, out.clip.skeleton, asf_name);
  set_unit(out, asf, metres_per_unit, asf_name);
  out.clip.skeleton.offsets *= out.metres_per_unit;

  TextLines lines(amc_text, amc_name);
  AmcFrames frames{asf,
                   asf_name,
                   layout,
                   bones_of(out.clip.skeleton),
                   out.metres_per_unit,
                   asf.radians ? 1.0 : M_PI / 180,
                   {},
                   std::vector<int>(asf.bones.size(), -1)};
  frames.track.joints = out.clip.skeleton.size();
  for (std::string_view line; lines.next_filled(line);) {
    if (line.front() == '#') continue;
    std::string_view words = line;
    const std::string_view first = next_word(words);
    if (first.front() == ':') {
      const std::string key = lower_case(first);
      if (key == ":degrees") frames.radians_per_unit = M_PI / 180;
      if (key == ":radians") frames.radians_per_unit = 1;
      if (key == ":samples-per-second") out.clip.rate = lines.real(next_word(words)), out.rate_assumed = false;
    } else if (first.front() >= '0' && first.front() <= '9') {
      // Bones that never rotate need no number in the file: keep them from growing past all measure.
      begin_frame(frames, lines, first, words, amc_text.size() + kMostBones);
    } else {
      read_frame_line(frames, lines, first, words);
    }
  }
  if (frames.frame < 0) throw Error(amc_name, "holds no frames");
  end_frame(frames, lines);
  if (frames.bones_stretch) out.notes.emplace_back("changes of bones' lengths were left out");
  if (!frames.bones_move) frames.track.places.clear();
  set_pose(out.clip, frames.track);
  if (frames.bones_move) set_translations(out.clip, out.clip.translations);
  validate(out.clip, amc_name);
  return out;
}

std::string find_asf(const std::string& amc_path) {
  namespace fs = std::filesystem;
  const fs::path amc(amc_path);
  const fs::path folder = amc.has_parent_path() ? amc.parent_path() : fs::path(".");
  std::error_code error;
  std::string stem = amc.stem().string();
  for (;;) {
    for (const char* extension : {".asf", ".ASF"})
      if (const fs::path path = folder / (stem + extension); fs::is_regular_file(path, error)) return path.string();
    const size_t cut = stem.find_last_of("_-");
    if (cut == std::string::npos || cut == 0) break;
    stem.resize(cut);
  }
  std::vector<std::string> found;
  for (auto it = fs::directory_iterator(folder, error); !error && it != fs::directory_iterator(); it.increment(error))
    if (lower_case(it->path().extension().string()) == ".asf") found.push_back(it->path().string());
  if (found.size() == 1) return found.front();
  throw Error(amc_path, found.empty()
                            ? "no .asf skeleton lies beside it"
                            : "several .asf skeletons lie beside it and none has its name; say which with --asf");
}

SourceMotion read_asf_amc(const std::string& amc_path, const std::string& asf_path,
                          std::optional<double> metres_per_unit) {
  const std::string amc = read_whole_file(amc_path);
  const std::string asf_name = asf_path.empty() ? find_asf(amc_path) : asf_path;
  return parse_asf_amc(read_whole_file(asf_name), asf_name, amc, amc_path, metres_per_unit);
}

}  // namespace inhabit
