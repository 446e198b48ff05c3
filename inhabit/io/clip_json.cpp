#include "inhabit/io/clip_json.h"

#include <charconv>

#include "inhabit/body/kinematics.h"
#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/json_text.h"

namespace inhabit {
namespace {

using nlohmann::json;
using torch::Tensor;

void append_number(std::string& text, double value, bool as_float) {
  char buffer[40];
  const auto end = as_float ? std::to_chars(buffer, buffer + sizeof(buffer), static_cast<float>(value)).ptr
                            : std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  text.append(buffer, end);
}

/// Nested arrays, one row of the first dimension to a line.
void append_array(std::string& text, const Tensor& t, int depth = 0) {
  if (t.dim() == 0) {
    if (t.is_floating_point())
      append_number(text, t.item<double>(), true);
    else
      text += std::to_string(t.item<int64_t>());
    return;
  }
  text += '[';
  if (t.dim() == 1 && t.scalar_type() == torch::kFloat32) {
    const auto at = t.accessor<float, 1>();
    for (int64_t i = 0; i < t.size(0); ++i) {
      if (i > 0) text += ',';
      append_number(text, at[i], true);
    }
  } else {
    for (int64_t i = 0; i < t.size(0); ++i) {
      if (i > 0) text += depth == 0 && t.dim() > 1 ? ",\n  " : ",";
      append_array(text, t[i], depth + 1);
    }
  }
  text += ']';
}

void collect(const json& value, size_t depth, const std::vector<int64_t>& shape, std::vector<double>& numbers,
             const std::string& where) {
  if (depth == shape.size()) {
    if (!value.is_number()) throw Error(where, "has something else than a number where one is expected");
    numbers.push_back(value.get<double>());
    return;
  }
  if (!value.is_array() || static_cast<int64_t>(value.size()) != shape[depth])
    throw Error(where, "its rows differ in length");
  for (const json& item : value) collect(item, depth + 1, shape, numbers, where);
}

/// A tensor of `dims` dimensions from nested arrays, undefined where `key` is missing.
Tensor array_of(const json& file, const char* key, size_t dims, const std::string& subject) {
  if (!file.contains(key) || file[key].is_null()) return {};
  const std::string where = subject + ": " + key;
  std::vector<int64_t> shape;
  const json* level = &file[key];
  for (size_t d = 0; d < dims; ++d) {
    if (!level->is_array()) throw Error(where, "is not an array of " + std::to_string(dims) + " dimensions");
    shape.push_back(static_cast<int64_t>(level->size()));
    if (level->empty()) {
      shape.resize(dims, 0);
      break;
    }
    level = &(*level)[0];
  }
  std::vector<double> numbers;
  collect(file[key], 0, shape, numbers, where);
  return torch::tensor(numbers, torch::kFloat64).view(shape).to(torch::kFloat32);
}

std::vector<std::string> names_of(const json& file, const char* key, const std::string& subject) {
  std::vector<std::string> names;
  if (!file.contains(key)) return names;
  if (!file[key].is_array()) throw Error(subject + ": " + key, "is not a list of names");
  for (const json& item : file[key]) {
    if (!item.is_string()) throw Error(subject + ": " + key, "is not a list of names");
    names.push_back(item.get<std::string>());
  }
  return names;
}

Skeleton skeleton_of(const json& file, const std::string& subject) {
  if (!file.contains("skeleton") || !file["skeleton"].is_array()) throw Error(subject, "has no skeleton");
  Skeleton skeleton;
  std::vector<float> offsets;
  for (const json& joint : file["skeleton"]) {
    if (!joint.is_object() || !joint.contains("name") || !joint["name"].is_string() || !joint.contains("parent") ||
        !joint["parent"].is_number_integer() || !joint.contains("offset"))
      throw Error(subject, "a joint of the skeleton has no name, parent or offset");
    skeleton.names.push_back(joint["name"].get<std::string>());
    const auto parent = joint["parent"].get<int64_t>();
    if (parent < -1 || parent >= static_cast<int64_t>(file["skeleton"].size()))
      throw Error(subject, "a joint's parent does not exist");
    skeleton.parents.push_back(static_cast<int>(parent));
    const Tensor offset = array_of(joint, "offset", 1, subject);
    if (!offset.defined() || offset.size(0) != 3) throw Error(subject, "a joint's offset is not three numbers");
    for (int k = 0; k < 3; ++k) offsets.push_back(offset[k].item<float>());
  }
  skeleton.offsets = torch::tensor(offsets).view({-1, 3});
  skeleton.validate(subject);
  return skeleton;
}

}  // namespace

std::string clip_json(const Clip& clip, const std::string& subject) {
  validate(clip, subject);
  std::string text = "{\n \"format\": \"inhabit clip\",\n \"version\": 1,\n \"units\": ";
  text += json{{"length", "metre"},
               {"angle", "radian (axis-angle, each joint relative to its parent)"},
               {"rate", "frames a second"},
               {"axes", "right-handed, +Y up, the person faces +Z at rest"},
               {"trans", "root joint = trans + offset of joint 0"},
               {"translations", "in place of the offsets where joints translate"}}
              .dump();
  text += ",\n \"rate\": ";
  append_number(text, clip.rate, false);
  text += ",\n \"frames\": " + std::to_string(clip.frames());
  text += ",\n \"gender\": " + json(clip.gender).dump(-1, ' ', false, json::error_handler_t::replace);
  text += ",\n \"skeleton\": [";
  for (int j = 0; j < clip.skeleton.size(); ++j) {
    text += j == 0 ? "\n  " : ",\n  ";
    text += "{\"name\": " +
            json(clip.skeleton.names[static_cast<size_t>(j)]).dump(-1, ' ', false, json::error_handler_t::replace);
    text += ", \"parent\": " + std::to_string(clip.skeleton.parents[static_cast<size_t>(j)]) + ", \"offset\": ";
    append_array(text, clip.skeleton.offsets[j].to(torch::kFloat32), 1);
    text += "}";
  }
  text += "]";
  auto put = [&](const char* name, const Tensor& t) {
    if (!t.defined()) return;
    text += std::string(",\n \"") + name + "\": ";
    append_array(text, t.detach().to(torch::kCPU).contiguous());
  };
  auto put_names = [&](const char* name, const std::vector<std::string>& names) {
    if (names.empty()) return;
    text += std::string(",\n \"") + name + "\": " + json(names).dump(-1, ' ', false, json::error_handler_t::replace);
  };
  put("betas", clip.betas);
  put("joints", clip.joints);
  put("rotations", clip.rotations);
  put("trans", clip.trans);
  put("translations", clip.translations);
  put_names("action_names", clip.action_names);
  put("action", clip.action);
  put("contact", clip.contact);
  put("hand_targets", clip.hand_targets);
  put_names("object_names", clip.object_names);
  put("object_pose", clip.object_pose);
  return text + "\n}\n";
}

void write_clip_json(const std::string& path, const Clip& clip) { write_atomically(path, clip_json(clip, path)); }

Clip parse_clip_json(std::string_view text, const std::string& subject) {
  const json file = parse_json(text, subject);
  if (!file.is_object() || !file.contains("format") || file["format"] != "inhabit clip")
    throw Error(subject, "is JSON, but not a clip of inhabit (no \"format\": \"inhabit clip\")");
  if (file.value("version", json()) != 1)
    throw Error(subject, "is of a version inhabit does not know (\"version\": 1)");
  Clip clip;
  clip.skeleton = skeleton_of(file, subject);
  if (!file.contains("rate") || !file["rate"].is_number()) throw Error(subject, "has no frame rate");
  clip.rate = file["rate"].get<double>();
  if (file.contains("gender") && file["gender"].is_string()) clip.gender = file["gender"].get<std::string>();
  clip.betas = array_of(file, "betas", 1, subject);
  clip.joints = array_of(file, "joints", 3, subject);
  clip.rotations = array_of(file, "rotations", 3, subject);
  clip.trans = array_of(file, "trans", 2, subject);
  clip.translations = array_of(file, "translations", 3, subject);
  clip.action_names = names_of(file, "action_names", subject);
  clip.action = array_of(file, "action", 1, subject);
  if (clip.action.defined()) clip.action = clip.action.to(torch::kInt64);
  clip.contact = array_of(file, "contact", 2, subject);
  clip.hand_targets = array_of(file, "hand_targets", 3, subject);
  clip.object_names = names_of(file, "object_names", subject);
  clip.object_pose = array_of(file, "object_pose", 3, subject);
  if (!clip.joints.defined()) {
    const int64_t J = clip.skeleton.size();
    if (!clip.rotations.defined() || !clip.trans.defined())
      throw Error(subject, "has neither joints nor both rotations and trans");
    const int64_t T = clip.rotations.size(0);
    if (clip.rotations.sizes() != torch::IntArrayRef({T, J, 3}) || clip.trans.sizes() != torch::IntArrayRef({T, 3}) ||
        T == 0)
      throw Error(subject, "rotations and trans do not fit the skeleton or each other");
    if (clip.translations.defined() && clip.translations.sizes() != torch::IntArrayRef({T, J, 3}))
      throw Error(subject, "translations do not fit the skeleton or the rotations");
    clip.joints = joint_positions(clip.skeleton, clip.rotations, clip.trans, clip.translations);
  }
  validate(clip, subject);
  if (file.contains("frames") && file["frames"] != clip.frames())
    throw Error(subject,
                "holds " + std::to_string(clip.frames()) + " frames, \"frames\" says " + file["frames"].dump());
  return clip;
}

Clip read_clip_json(const std::string& path) { return parse_clip_json(read_whole_file(path, 1ULL << 30), path); }

}  // namespace inhabit
