#include "inhabit/io/pose_line.h"

#include <charconv>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/io/json_text.h"

namespace inhabit {
namespace {

using nlohmann::json;

constexpr size_t kMostJoints = 1000, kLongestName = 64;
constexpr double kFarthest = 1e4;  // metres

[[noreturn]] void refuse(const std::string& reason) { throw Error("line", reason); }

const json* list(const json& line, const char* name, size_t least, size_t most) {
  const auto at = line.find(name);
  if (at == line.end()) return nullptr;
  if (!at->is_array() || at->size() < least || at->size() > most)
    refuse("\"" + std::string(name) + "\" is no list of " + std::to_string(least) + " to " + std::to_string(most));
  return &*at;
}

/// Also a person: no control characters, so that it can be printed.
std::string name_of(const json& value, const char* what) {
  if (value.is_number_integer()) return value.dump();
  if (!value.is_string()) refuse(std::string(what) + " is no name");
  const auto& name = value.get_ref<const std::string&>();
  if (name.empty() || name.size() > kLongestName) refuse(std::string(what) + " is no name of 1 to 64 bytes");
  for (const char c : name)
    if (static_cast<unsigned char>(c) < 32 || c == 127) refuse(std::string(what) + " has a control character");
  return name;
}

JointNames names_of(const json& line) {
  JointNames out;
  for (const json& name : *list(line, "names", 1, kMostJoints)) out.names.push_back(name_of(name, "a joint's name"));
  if (const json* parents = list(line, "parents", 1, kMostJoints)) {
    for (const json& parent : *parents) {
      if (!parent.is_number_integer() || parent < -1 || parent >= static_cast<int64_t>(kMostJoints))
        refuse("a parent is no joint");
      out.parents.push_back(parent.get<int>());
    }
  }
  return out;
}

float coordinate(const json& value) {
  if (value.is_null()) return NAN;
  if (!value.is_number()) refuse("a joint has something else than three numbers");
  const auto x = value.get<double>();
  if (!(std::abs(x) <= kFarthest)) refuse("a joint is over 10 km from the origin");
  return static_cast<float>(x);
}

}  // namespace

StreamLine parse_stream_line(std::string_view text) {
  const json line = parse_json(text, "line");
  if (!line.is_object()) refuse("is no JSON object");
  if (line.contains("names")) return names_of(line);
  PoseLine out;
  const auto time = line.find("time");
  if (time == line.end() || !time->is_number()) refuse("has no \"time\" in seconds");
  out.time = time->get<double>();
  if (const auto person = line.find("person"); person != line.end()) out.person = name_of(*person, "the person");
  const json* joints = list(line, "joints", 1, kMostJoints);
  if (joints == nullptr) refuse("has no \"joints\"");
  out.joints = torch::full({static_cast<int64_t>(joints->size()), 3}, NAN);
  float* to = out.joints.data_ptr<float>();
  for (const json& joint : *joints) {
    if (!joint.is_null()) {
      if (!joint.is_array() || joint.size() != 3) refuse("a joint has something else than three numbers");
      for (size_t k = 0; k < 3; ++k) to[k] = coordinate(joint[k]);
    }
    to += 3;
  }
  return out;
}

void append_places(std::string& text, const torch::Tensor& places) {
  if (places.dim() > 1) {
    text += '[';
    for (int64_t i = 0; i < places.size(0); ++i) {
      if (i > 0) text += ',';
      append_places(text, places[i]);
    }
    text += ']';
    return;
  }
  const torch::Tensor row = places.to(torch::kCPU, torch::kFloat32).contiguous();
  text += '[';
  for (int64_t i = 0; i < row.numel(); ++i) {
    if (i > 0) text += ',';
    const auto value = static_cast<double>(row.data_ptr<float>()[i]);
    if (!std::isfinite(value)) {
      text += "null";
      continue;
    }
    char buffer[64];
    text.append(buffer, std::to_chars(buffer, buffer + sizeof(buffer), std::round(value * 1e4) / 1e4 + 0.0).ptr);
  }
  text += ']';
}

}  // namespace inhabit
