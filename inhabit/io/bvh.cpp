#include "inhabit/io/bvh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "inhabit/body/bones.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/text_lines.h"
#include "inhabit/io/upright.h"
#include "inhabit/io/utf8.h"
#include "inhabit/math/quantile.h"
#include "inhabit/motion/locomotion.h"
#include "inhabit/motion/pose_track.h"

namespace inhabit {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr int kMostBvhJoints = 2000;

struct Channel {
  bool rotation;
  int axis;  // 0 x, 1 y, 2 z
};

struct Joint {
  std::string name;
  int parent;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::vector<Channel> channels;

  bool has_position() const {
    for (const Channel& c : channels)
      if (!c.rotation) return true;
    return false;
  }
};

// Hands out the words of the hierarchy one after the other: line breaks mean nothing there, except to names.
class Words {
 public:
  explicit Words(TextLines& lines) : lines_(lines) {}
  std::string_view next() {
    for (;;) {
      const std::string_view word = next_word(line_);
      if (!word.empty()) return word;
      if (!lines_.next(line_)) lines_.fail("the file ends inside the hierarchy");
    }
  }
  // What is left of the line: names may hold spaces. An opening brace may stand behind a name.
  std::string_view rest_of_line() {
    std::string_view rest = line_;
    const size_t brace = rest.find('{');
    if (brace != std::string_view::npos) rest = rest.substr(0, brace);
    line_.remove_prefix(rest.size());
    while (!rest.empty() && (rest.front() == ' ' || rest.front() == '\t')) rest.remove_prefix(1);
    while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\t')) rest.remove_suffix(1);
    return rest;
  }
  void expect(std::string_view word) {
    const std::string_view found = next();
    if (!same(found, word)) lines_.fail("expected " + in_quotes(word) + ", found " + in_quotes(found));
  }
  static bool same(std::string_view a, std::string_view b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) {
             return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
           });
  }

 private:
  TextLines& lines_;
  std::string_view line_;
};

Channel channel_of(const TextLines& lines, std::string_view word) {
  const std::string_view kinds[] = {"position", "rotation"};
  for (int kind = 0; kind < 2; ++kind)
    for (int axis = 0; axis < 3; ++axis)
      if (Words::same(word, std::string(1, "XYZ"[axis]) + std::string(kinds[kind]))) return {kind == 1, axis};
  lines.fail("unknown channel " + in_quotes(word));
}

std::vector<Joint> read_hierarchy(TextLines& lines) {
  Words words(lines);
  words.expect("HIERARCHY");
  words.expect("ROOT");
  std::vector<Joint> joints;
  std::vector<int> open;  // the joints whose braces are open
  std::set<std::string> names;
  std::map<std::string, int> again;  // how often a name came once more
  const auto begin_joint = [&](const std::string& bytes) {
    const std::string given = as_utf8(bytes);
    if (given.empty()) lines.fail("a joint has no name");
    std::string name = given;
    while (!names.insert(name).second) name = given + "_" + std::to_string(++again[given] + 1);
    if (joints.size() >= kMostBvhJoints) lines.fail("more than " + std::to_string(kMostBvhJoints) + " joints");
    joints.push_back({std::move(name), open.empty() ? -1 : open.back(), Eigen::Vector3d::Zero(), {}});
    words.expect("{");
    open.push_back(static_cast<int>(joints.size()) - 1);
  };
  begin_joint(std::string(words.rest_of_line()));
  while (!open.empty()) {
    const std::string_view word = words.next();
    Joint& joint = joints[static_cast<size_t>(open.back())];
    if (word == "}") {
      open.pop_back();
    } else if (Words::same(word, "JOINT")) {
      begin_joint(std::string(words.rest_of_line()));
    } else if (Words::same(word, "End")) {
      words.expect("Site");
      words.rest_of_line();  // some writers give end sites a name
      begin_joint(joint.name + "_end");
    } else if (Words::same(word, "OFFSET")) {
      for (int k = 0; k < 3; ++k) joint.offset[k] = lines.real(words.next());
    } else if (Words::same(word, "CHANNELS")) {
      const long count = lines.whole(words.next(), 0, 6);
      if (!joint.channels.empty()) lines.fail("joint " + in_quotes(joint.name) + " has two lists of channels");
      for (long k = 0; k < count; ++k) {
        const Channel channel = channel_of(lines, words.next());
        for (const Channel& c : joint.channels)
          if (c.rotation == channel.rotation && c.axis == channel.axis)
            lines.fail("joint " + in_quotes(joint.name) + " has one channel twice");
        joint.channels.push_back(channel);
      }
    } else {
      lines.fail("expected JOINT, End Site, OFFSET, CHANNELS or '}', found " + in_quotes(word));
    }
  }
  return joints;
}

// The rate that the writer meant: 0.0333 s stands for 30 Hz when 1/30 printed with as many digits is 0.0333.
double rate_of(double seconds, std::string_view printed) {
  const size_t point = printed.find('.');
  const double digits = point == std::string_view::npos ? 0 : static_cast<double>(printed.size() - point - 1);
  const double whole = std::round(1 / seconds);
  return whole > 0 && std::abs(seconds - 1 / whole) <= 0.5001 * std::pow(10.0, -digits) ? whole : 1 / seconds;
}

std::string_view after_key(TextLines& lines, std::string_view key) {
  std::string_view line;
  if (!lines.next_filled(line)) lines.fail("the file ends where " + in_quotes(key) + " is expected");
  for (std::string_view words = key; !words.empty();) {
    const std::string_view expected = next_word(words);
    // The colon may stand apart from its word.
    std::string_view found = next_word(line);
    if (found.size() > expected.size() && Words::same(found.substr(0, expected.size()), expected)) {
      line = std::string_view(found.data() + expected.size(),
                              static_cast<size_t>(line.data() + line.size() - found.data()) - expected.size());
      found = expected;
    }
    if (!Words::same(found, expected)) lines.fail("expected " + in_quotes(key) + ", found " + in_quotes(found));
  }
  std::string_view rest = line;
  std::string_view value = next_word(rest);
  if (value == ":") value = next_word(rest);
  if (!value.empty() && value.front() == ':') value.remove_prefix(1);
  if (value.empty()) lines.fail(in_quotes(key) + " has no number");
  return value;
}

struct BvhMotionHead {
  long frames = 0;
  double rate = 0;  // Hz
};

// MOTION and the two lines behind it.
BvhMotionHead read_motion_head(TextLines& lines, size_t joints, size_t channels) {
  std::string_view line;
  if (!lines.next_filled(line) || !Words::same(line, "MOTION"))
    lines.fail("expected 'MOTION', found " + in_quotes(line));
  BvhMotionHead head;
  head.frames = lines.whole(after_key(lines, "Frames:"), 0, 100'000'000);
  if (head.frames == 0) lines.fail("no frames");
  const std::string_view printed = after_key(lines, "Frame Time:");
  const double seconds = lines.real(printed);
  if (!(seconds >= 0.001 && seconds <= 10))
    lines.fail("frame time " + std::string(printed) + " is not in [0.001, 10] s");
  head.rate = rate_of(seconds, printed);
  // A number and its blank take two bytes: no declared size is believed that the file cannot hold.
  if (static_cast<size_t>(head.frames) * std::max(2 * channels, joints) > lines.bytes_left() + 1)
    lines.fail(std::to_string(head.frames) + " frames of " + std::to_string(channels) +
               " channels are declared, the file is shorter");
  return head;
}

// Joints' places in their parents' frames, (frames, joints) in units of the file; rotations go to `track`.
std::vector<Eigen::Vector3d> read_frames(TextLines& lines, const std::vector<Joint>& joints, long frames,
                                         PoseTrack& track) {
  track.joints = static_cast<int>(joints.size());
  track.local.reserve(static_cast<size_t>(frames) * joints.size());
  std::vector<Eigen::Vector3d> places;
  places.reserve(static_cast<size_t>(frames) * joints.size());
  std::string_view rest;
  for (long t = 0; t < frames; ++t) {
    for (const Joint& joint : joints) {
      Eigen::Vector3d place = joint.offset;
      Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
      for (const Channel& channel : joint.channels) {
        std::string_view word = next_word(rest);
        while (word.empty()) {
          if (!lines.next(rest))
            lines.fail("the file ends in frame " + std::to_string(t + 1) + " of " + std::to_string(frames));
          word = next_word(rest);
        }
        const double value = lines.real(word);
        if (!(std::abs(value) < 1e9)) lines.fail(in_quotes(word) + " is too large");
        if (channel.rotation)
          rotation = rotation * Eigen::AngleAxisd(value * kDegree, Eigen::Vector3d::Unit(channel.axis));
        else
          place[channel.axis] = value;
      }
      track.local.push_back(rotation);
      places.push_back(place);
    }
  }
  if (!next_word(rest).empty() || lines.next_filled(rest))
    lines.fail("numbers go on after the last of " + std::to_string(frames) + " frames");
  return places;
}

// The bones. Of a joint that carries positions it is the median of its places, of a root that does it is zero.
std::vector<Eigen::Vector3d> bone_offsets(const std::vector<Joint>& joints,
                                          const std::vector<Eigen::Vector3d>& places) {
  const size_t count = joints.size(), frames = places.size() / count;
  std::vector<Eigen::Vector3d> offsets;
  for (size_t j = 0; j < count; ++j) {
    Eigen::Vector3d& offset = offsets.emplace_back(joints[j].offset);
    if (!joints[j].has_position()) continue;
    if (j == 0) {
      offset.setZero();
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      std::vector<double> values;
      for (size_t t = 0; t < frames; ++t) values.push_back(places[t * count + j][k]);
      offset[k] = median(std::move(values));
    }
  }
  return offsets;
}

// Places of all joints but the root, in metres, become the clip's translations.
void set_places(Clip& clip, const std::vector<Eigen::Vector3d>& places, double scale) {
  const int64_t joints = clip.skeleton.size(), frames = static_cast<int64_t>(places.size()) / joints;
  torch::Tensor translations = torch::empty({frames, joints, 3});
  float* p = translations.data_ptr<float>();
  for (size_t k = 0; k < places.size(); ++k, p += 3)
    Eigen::Map<Eigen::Vector3f>(p, 3) = (places[k] * scale).cast<float>();
  translations.select(1, 0).copy_(clip.skeleton.offsets[0].expand({frames, 3}));
  set_translations(clip, translations);
}

}  // namespace

SourceMotion parse_bvh(std::string_view text, const std::string& name, std::optional<double> metres_per_unit) {
  if (metres_per_unit && !(*metres_per_unit > 0 && std::isfinite(*metres_per_unit)))
    throw Error(name, "the scale must be a positive number");
  TextLines lines(text, name);
  if (text.empty()) throw Error(name, "is empty");
  const std::vector<Joint> joints = read_hierarchy(lines);
  const size_t count = joints.size();
  SourceMotion out;
  Skeleton& skeleton = out.clip.skeleton;
  skeleton.offsets = torch::zeros({static_cast<int64_t>(count), 3});
  size_t channels = 0;
  for (const Joint& joint : joints) {
    skeleton.names.push_back(joint.name);
    skeleton.parents.push_back(joint.parent);
    channels += joint.channels.size();
  }
  if (channels == 0) throw Error(name, "no joint has channels");

  const BvhMotionHead head = read_motion_head(lines, count, channels);
  out.clip.rate = head.rate;
  PoseTrack track;
  const std::vector<Eigen::Vector3d> places = read_frames(lines, joints, head.frames, track);
  const std::vector<Eigen::Vector3d> offsets = bone_offsets(joints, places);
  auto rows = skeleton.offsets.accessor<float, 2>();
  const auto set_offsets = [&](double scale) {
    for (size_t j = 0; j < count; ++j)
      for (int k = 0; k < 3; ++k) rows[static_cast<int64_t>(j)][k] = static_cast<float>(offsets[j][k] * scale);
  };
  set_offsets(1);
  skeleton.validate(name);
  if (metres_per_unit) {
    out.metres_per_unit = *metres_per_unit;
    out.unit = "units of the given scale";
  } else {
    const LengthUnit unit = guess_length_unit(longest_reach(skeleton, body_joint(skeleton)), name);
    out.metres_per_unit = unit.metres;
    out.unit = unit.name;
    out.notes.push_back("lengths taken for " + unit.name + " from the size of the person");
  }
  const double scale = out.metres_per_unit;
  set_offsets(scale);
  for (size_t t = 0; t < places.size(); t += count) track.trans.push_back((places[t] - offsets[0]) * scale);
  set_pose(out.clip, track);
  if (std::any_of(joints.begin() + 1, joints.end(), [](const Joint& joint) { return joint.has_position(); }))
    set_places(out.clip, places, scale);
  if (joints[0].has_position()) Eigen::Map<Eigen::Vector3d>(out.clip.file.root_offset.data()) = joints[0].offset;
  out.clip.file.format = "bvh";
  out.clip.file.metres_per_unit = scale;
  for (const Joint& joint : joints) {
    std::string& letters = out.clip.file.channels.emplace_back();
    for (const Channel& channel : joint.channels) letters += (channel.rotation ? "XYZ" : "xyz")[channel.axis];
  }
  validate(out.clip, name);
  return out;
}

SourceMotion read_bvh(const std::string& path, std::optional<double> metres_per_unit) {
  return parse_bvh(read_whole_file(path), path, metres_per_unit);
}

namespace {

// Angles (degrees) about axes i, j, k with R = R_i R_j R_k, the nearer of the two solutions to `before`, without jumps
// of a whole circle.
Eigen::Vector3d euler_angles(const Eigen::Quaterniond& q, const std::array<int, 3>& order,
                             const Eigen::Vector3d& before) {
  const Eigen::Matrix3d m = q.normalized().toRotationMatrix();
  const auto [i, j, k] = order;
  const double sign = (j - i + 3) % 3 == 1 ? 1 : -1;  // of the permutation
  const double sine = sign * m(i, k), cosine = std::hypot(m(i, i), m(i, j));
  Eigen::Vector3d first(0, std::atan2(sine, cosine), 0);  // asin loses half of the digits near 90 degrees
  if (cosine > 1e-7) {
    first[0] = std::atan2(-sign * m(j, k), m(k, k));
    first[2] = std::atan2(-sign * m(i, j), m(i, i));
  } else {  // the outer two rotate about one axis: keep the last where it was
    first[2] = before[2] * kDegree;
    first[0] = std::atan2(sign * m(k, j), m(j, j)) - sign * (sine > 0 ? 1 : -1) * first[2];
  }
  first /= kDegree;
  Eigen::Vector3d second(first[0] + 180, 180 - first[1], first[2] + 180);
  for (int angle = 0; angle < 3; ++angle) {
    first[angle] -= 360 * std::round((first[angle] - before[angle]) / 360);
    second[angle] -= 360 * std::round((second[angle] - before[angle]) / 360);
  }
  return (first - before).squaredNorm() <= (second - before).squaredNorm() ? first : second;
}

void append_numbers(std::string& out, const Eigen::Vector3d& v, const char* separator) {
  char text[96];
  const int n = std::snprintf(text, sizeof text, "%.6f %.6f %.6f%s", v[0], v[1], v[2], separator);
  out.append(text, static_cast<size_t>(std::clamp(n, 0, 95)));
}

/// True for the joints that parse_bvh makes of end sites, as long as they do not translate: they are written as such
/// again. @param channels of the file that the skeleton was read from, empty for an end site; without them, what
/// rotates is none
std::vector<bool> end_sites(const Skeleton& skeleton, const Bones& bones, const PoseTrack& track,
                            const std::vector<bool>& translates, const std::vector<std::string>& channels) {
  std::vector<int> children(skeleton.names.size(), 0);
  for (const int parent : bones.parents)
    if (parent >= 0) ++children[static_cast<size_t>(parent)];
  std::vector<bool> out(skeleton.names.size(), false);
  for (size_t j = 1; j < out.size(); ++j) {
    const auto parent = static_cast<size_t>(bones.parents[j]);
    if (children[j] > 0 || children[parent] != 1 || skeleton.names[j] != skeleton.names[parent] + "_end") continue;
    out[j] = !translates[j] && (channels.empty() || channels[j].empty());
    for (int64_t t = 0; channels.empty() && t < track.frames() && out[j]; ++t)
      out[j] = track.at(t, static_cast<int>(j)).vec().norm() < 1e-6;
  }
  return out;
}

/// What stands in the hierarchy, beside the skeleton: how each joint is written.
struct BvhLayout {
  std::vector<bool> ends;             // end sites
  std::vector<std::string> channels;  // as FileConventions::channels, always three rotations in them or none
  double scale = 100;                 // units per metre
  bool as_read = false;               // names may hold blanks, leaves need no end site
  Eigen::Vector3d root_offset = Eigen::Vector3d::Zero();  // metres
};

std::string channel_words(const std::string& letters) {
  std::string out = "CHANNELS " + std::to_string(letters.size());
  for (const char c : letters) {
    const bool rotation = c >= 'X' && c <= 'Z';
    out += std::string(" ") + static_cast<char>(std::toupper(static_cast<unsigned char>(c))) +
           (rotation ? "rotation" : "position");
  }
  return out + "\n";
}

void append_joint(std::string& out, const Skeleton& skeleton, const Bones& bones, const BvhLayout& layout, int joint,
                  int depth) {
  const auto at = static_cast<size_t>(joint);
  const std::string indent(static_cast<size_t>(depth), '\t');
  std::string name;
  for (const char c : skeleton.names[at]) {
    const bool blank = c == ' ' && layout.as_read;
    name += !blank && (static_cast<unsigned char>(c) <= 32 || c == '{' || c == '}' || c == 127) ? '_' : c;
  }
  if (name.empty()) name = "joint" + std::to_string(joint);
  const Eigen::Vector3d offset = joint == 0 ? layout.root_offset : bones.offsets[at];
  out += indent + (joint == 0 ? "ROOT " : "JOINT ") + name + "\n" + indent + "{\n" + indent + "\tOFFSET ";
  append_numbers(out, offset * layout.scale, "\n");
  out += indent + "\t" + channel_words(layout.channels[at]);
  const double length = offset.norm();
  bool ended = !layout.as_read;
  Eigen::Vector3d end = length > 1e-6 ? Eigen::Vector3d(offset * (0.05 / length)) : Eigen::Vector3d(0, 0.05, 0);
  for (int child = joint + 1; child < bones.size(); ++child) {
    const auto c = static_cast<size_t>(child);
    if (bones.parents[c] != joint) continue;
    ended = layout.ends[c];
    if (ended)
      end = bones.offsets[c];
    else
      append_joint(out, skeleton, bones, layout, child, depth + 1);
  }
  if (ended) {
    out += indent + "\tEnd Site\n" + indent + "\t{\n" + indent + "\t\tOFFSET ";
    append_numbers(out, end * layout.scale, "\n");
    out += indent + "\t}\n";
  }
  out += indent + "}\n";
}

// Joints with channels in the order of the hierarchy's text: depth first.
void depth_first(const std::vector<int>& parents, const std::vector<bool>& ends, int joint, std::vector<int>& order) {
  order.push_back(joint);
  for (int child = joint + 1; child < static_cast<int>(parents.size()); ++child)
    if (parents[static_cast<size_t>(child)] == joint && !ends[static_cast<size_t>(child)])
      depth_first(parents, ends, child, order);
}

}  // namespace

void write_bvh(const std::string& path, const Clip& motion, double units_per_metre) {
  validate(motion, path);
  if (!motion.rotations.defined() || !motion.trans.defined())
    throw Error(path, "a BVH file holds rotations, the motion has positions only; fit a body to it first");
  const bool as_read = motion.file.format == "bvh";
  Clip clip = as_read ? restore_trajectory(motion) : motion;
  if (as_read && motion.file.z_up) rotate_z_up(clip);
  const PoseTrack track = pose_track(clip);
  const Bones bones = bones_of(clip.skeleton);
  const auto joints = static_cast<size_t>(track.joints);
  std::vector<bool> translates(joints, false);
  for (size_t k = 0; k < track.places.size(); ++k)
    if (track.places[k] != bones.offsets[k % joints]) translates[k % joints] = true;
  BvhLayout layout;
  // The hierarchy is a file's own where its channels are known: to_be_written asks for units and axes alone.
  const bool channels_known = as_read && motion.file.channels.size() == joints;
  layout.as_read = channels_known;
  layout.scale = as_read ? 1 / motion.file.metres_per_unit : units_per_metre;
  if (as_read) layout.root_offset = Eigen::Map<const Eigen::Vector3d>(motion.file.root_offset.data()) / layout.scale;
  layout.ends = end_sites(clip.skeleton, bones, track, translates,
                          channels_known ? motion.file.channels : std::vector<std::string>());
  for (size_t j = 0; j < joints; ++j) {
    std::string letters = channels_known ? motion.file.channels[j] : "";
    const bool all_rotations = letters.find('X') != std::string::npos && letters.find('Y') != std::string::npos &&
                               letters.find('Z') != std::string::npos;
    const bool all_positions = letters.find('x') != std::string::npos && letters.find('y') != std::string::npos &&
                               letters.find('z') != std::string::npos;
    if (!all_rotations || (!all_positions && letters.size() != 3)) letters = "ZYX";
    if (letters.size() == 3 && (j == 0 || translates[j])) letters.insert(0, "xyz");
    layout.channels.push_back(letters);
  }
  std::vector<int> order;
  depth_first(bones.parents, layout.ends, 0, order);

  std::string text = "HIERARCHY\n";
  append_joint(text, clip.skeleton, bones, layout, 0, 0);
  char head[96];
  std::snprintf(head, sizeof head, "MOTION\nFrames: %lld\nFrame Time: %.9g\n", static_cast<long long>(track.frames()),
                1 / clip.rate);
  text += head;
  std::vector<Eigen::Vector3d> angles(joints, Eigen::Vector3d::Zero());
  for (int64_t t = 0; t < track.frames(); ++t) {
    for (const int joint : order) {
      const auto j = static_cast<size_t>(joint);
      const std::string& letters = layout.channels[j];
      std::array<int, 3> axes{};
      size_t angle = 0;
      for (const char c : letters)
        if (c >= 'X' && c <= 'Z') axes[angle++] = c - 'X';
      angles[j] = euler_angles(track.at(t, joint), axes, angles[j]);
      Eigen::Vector3d place = bones.offsets[j];
      if (!track.places.empty()) place = track.places[static_cast<size_t>(t) * joints + j];
      if (joint == 0) place = track.trans[static_cast<size_t>(t)] + bones.offsets[0];
      angle = 0;
      for (const char c : letters) {
        char number[48];
        const double value =
            c >= 'X' && c <= 'Z' ? angles[j][static_cast<Eigen::Index>(angle++)] : place[c - 'x'] * layout.scale;
        const int n = std::snprintf(number, sizeof number, "%.6f ", value);
        text.append(number, static_cast<size_t>(std::clamp(n, 0, 47)));
      }
    }
    text.back() = '\n';
  }
  write_atomically(path, text);
}

}  // namespace inhabit
