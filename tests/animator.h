#pragma once
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

/// A .bvh as animators have them: a person who walks, on a skeleton of many joints. Lengths in centimetres times
/// `unit`.
struct AnimatorFile {
  int frames = 121;
  double rate = 60;          ///< frames a second
  double begin = 0;          ///< seconds into the walk
  double hips = 90;          ///< how high they are, centimetres
  double unit = 1;           ///< units a centimetre
  bool world_root = false;   ///< joint_Root stands at the origin, every joint has positions, Hips carry the body
  bool world_chain = false;  ///< with it: a joint World, which turns in place, between joint_Root and Hips
  bool stretching = false;   ///< LeftForeArm and RightLeg have positions that change
  bool z_up = false;
  std::string order = "ZXY";  ///< of the rotations

  struct Joint {
    std::string name;
    int parent;
    std::vector<double> offset;
    std::string channels;
    bool end = false;
  };

  std::vector<Joint> joints() const {
    std::vector<Joint> out;
    const std::string positions = "xyz";
    if (world_root) out.push_back({"joint_Root", -1, {0, 0, 0}, positions + order});
    if (world_chain) out.push_back({"World", 0, {2, 5, 1}, positions + order});
    const auto add = [&](const std::string& name, const std::string& parent, std::vector<double> offset) {
      int above = -1;
      for (size_t j = 0; j < out.size(); ++j)
        if (out[j].name == parent) above = static_cast<int>(j);
      const bool end = name.size() > 4 && name.substr(name.size() - 4) == "_end";
      const bool moves = world_root || above < 0 || (stretching && (name == "LeftForeArm" || name == "RightLeg"));
      out.push_back({name, above, std::move(offset), end ? "" : (moves ? positions : "") + order, end});
    };
    add("Hips", world_chain ? "World" : world_root ? "joint_Root" : "", {0, 92, 0});
    add("Spine", "Hips", {0, 10, -1});
    add("Spine1", "Spine", {0, 12, 0});
    add("Spine2", "Spine1", {0, 12, 1});
    add("Spine3", "Spine2", {0, 12, 0});
    add("Neck", "Spine3", {0, 14, 0});
    add("Head", "Neck", {0, 9, 2});
    add("Jaw", "Head", {0, 2, 5});
    add("Jaw_end", "Jaw", {0, -1, 4});
    for (const double side : {1.0, -1.0}) {
      const std::string s = side > 0 ? "Left" : "Right";
      add(s + "Shoulder", "Spine3", {side * 5, 10, 1});
      add(s + "Arm", s + "Shoulder", {side * 12, 0, -1});
      add(s + "ArmTwist", s + "Arm", {side * 14, 0, 0});
      add(s + "ArmTwist_end", s + "ArmTwist", {side * 5, 0, 0});
      add(s + "ForeArm", s + "Arm", {side * 28, 0, 0});
      add(s + "Hand", s + "ForeArm", {side * 26, 0, 0});
      for (const std::string finger : {"Index", "Thumb"}) {
        add(s + "Hand" + finger + "1", s + "Hand", {side * 9, 0, finger == "Index" ? 2.0 : 4.0});
        add(s + "Hand" + finger + "2", s + "Hand" + finger + "1", {side * 4, 0, 0});
        add(s + "Hand" + finger + "2_end", s + "Hand" + finger + "2", {side * 3, 0, 0});
      }
    }
    for (const double side : {1.0, -1.0}) {
      const std::string s = side > 0 ? "Left" : "Right";
      add(s + "UpLeg", "Hips", {side * 9, -4, 0});
      add(s + "Leg", s + "UpLeg", {0, -42, 1});
      add(s + "Foot", s + "Leg", {0, -41, -2});
      add(s + "ToeBase", s + "Foot", {0, -5, 13});
      add(s + "ToeBase_end", s + "ToeBase", {0, 0, 6});
    }
    return out;
  }

  /// Degrees about an axis (0 x, 1 y, 2 z) of a joint at time t seconds.
  static double angle(const std::string& name, int axis, double t) {
    const double swing = std::sin(5 * t), side = name.rfind("Left", 0) == 0 ? 1 : -1;
    const auto is = [&](const char* part) { return name.find(part) != std::string::npos; };
    if (name == "Hips") return axis == 1 ? 15 * std::sin(t) : axis == 0 ? 3 * swing : 2 * swing;
    if (is("Spine")) return axis == 0 ? 4 + 2 * swing : axis == 1 ? -3 * swing : 1.0;
    if (name == "World") return axis == 1 ? 20 * std::sin(t) : 0;
    if (name == "Neck" || name == "Head") return 5 * std::sin(2 * t + axis);
    if (name == "Jaw") return axis == 0 ? 8 + 6 * std::sin(7 * t) : 0;
    if (is("UpLeg")) return axis == 0 ? -10 + 25 * side * swing : axis == 2 ? 3 * side : 0;
    if (is("Leg")) return axis == 0 ? 25 + 20 * side * swing : 0;
    if (is("Foot")) return axis == 0 ? -12 + 6 * side * swing : 2;
    if (is("ToeBase")) return axis == 0 ? 5 * swing : 0;
    if (is("ArmTwist")) return axis == 0 ? 15 * swing : 0;
    if (is("ForeArm")) return axis == 1 ? -side * (30 + 15 * swing) : axis == 0 ? 10 * swing : 0;
    if (is("HandIndex") || is("HandThumb")) return axis == 2 ? -side * (20 + 15 * std::sin(3 * t)) : 4 * swing;
    if (is("Hand")) return 8 * std::sin(2 * t + axis);
    if (is("Arm")) return axis == 2 ? -side * (65 + 5 * swing) : axis == 0 ? 15 * side * swing : 5;
    return is("Shoulder") ? 3 * swing : 0;
  }

  std::string text() const {
    const std::vector<Joint> all = joints();
    std::string out = "HIERARCHY\n";
    append(out, all, 0, 0);
    out += "MOTION\nFrames: " + std::to_string(frames) + "\n";
    char number[64];
    std::snprintf(number, sizeof number, "Frame Time: %.9f\n", 1 / rate);
    out += number;
    for (int f = 0; f < frames; ++f) {
      const double t = begin + f / rate;
      for (const Joint& joint : all)
        for (const char c : joint.channels) {
          const bool rotation = c < 'a';
          double value = rotation ? angle(joint.name, c - 'X', t) : joint.offset[static_cast<size_t>(c - 'x')] * unit;
          if (joint.name == "joint_Root") value = 0;
          if (joint.name == "Hips" && !rotation) {
            const double place[] = {30 * std::sin(t), hips + 2 * std::sin(10 * t), 120 * t - 300};
            value = place[c - 'x'] * unit;
            if (z_up && c == 'y') value = -place[2] * unit;
            if (z_up && c == 'z') value = place[1] * unit;
          }
          if (stretching && !rotation && (joint.name == "LeftForeArm" || joint.name == "RightLeg"))
            value += (c == 'x' ? 3.0 : 1.0) * std::sin(4 * t) * unit;
          if (z_up && joint.name == "Hips" && c == 'X') value += 90;  // needs X first in the order
          std::snprintf(number, sizeof number, "%.6f ", value);
          out += number;
        }
      out += "\n";
    }
    return out;
  }

 private:
  void append(std::string& out, const std::vector<Joint>& all, size_t j, int depth) const {
    const std::string tab(static_cast<size_t>(2 * depth), ' ');
    char offset[128];
    std::snprintf(offset, sizeof offset, "OFFSET %.6f %.6f %.6f\n", all[j].offset[0] * unit, all[j].offset[1] * unit,
                  all[j].offset[2] * unit);
    if (all[j].end) {
      out += tab + "End Site\n" + tab + "{\n" + tab + "  " + offset + tab + "}\n";
      return;
    }
    out += tab + (j == 0 ? "ROOT " : "JOINT ") + all[j].name + "\n" + tab + "{\n" + tab + "  " + offset + tab +
           "  CHANNELS " + std::to_string(all[j].channels.size());
    for (const char c : all[j].channels)
      out += std::string(" ") + (c < 'a' ? c : static_cast<char>(c - 32)) + (c < 'a' ? "rotation" : "position");
    out += "\n";
    for (size_t k = j + 1; k < all.size(); ++k)
      if (all[k].parent == static_cast<int>(j)) append(out, all, k, depth + 1);
    out += tab + "}\n";
  }
};

/// Names, channels and end sites of a .bvh, without its numbers of length.
inline std::string hierarchy_of(const std::string& text) {
  std::istringstream in(text.substr(0, text.find("MOTION")));
  std::string out, word;
  while (in >> word) {
    if (word == "OFFSET")
      for (int k = 0; k < 3; ++k) in >> word;
    else
      out += word + " ";
  }
  return out;
}
