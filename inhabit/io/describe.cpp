#include "inhabit/io/describe.h"

#include <filesystem>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/extension.h"
#include "inhabit/io/files.h"
#include "inhabit/io/json_text.h"
#include "inhabit/io/npz.h"
#include "inhabit/io/point_cloud.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/smpl_model.h"
#include "inhabit/motion/landmarks.h"
#include "inhabit/motion/level.h"

namespace inhabit {
namespace {

using Json = nlohmann::ordered_json;
using torch::Tensor;

/// Three decimals: a millimetre, a millisecond.
double rounded(double value) { return std::round(value * 1000) / 1000; }

Json numbers(const Tensor& t) {
  Json list = Json::array();
  for (int64_t i = 0; i < t.size(0); ++i) list.push_back(rounded(t[i].item<double>()));
  return list;
}

/// Whether a skeleton rests folded: nearer from head to ankles along `up` than its legs, trunk and neck are long.
bool rests_folded(const Tensor& rest, const Landmarks& marks, int64_t up) {
  const auto length = [&](int a, int b) { return (rest[a] - rest[b]).norm().item<double>(); };
  double straight = length(marks.head, marks.thorax) + length(marks.thorax, marks.pelvis);
  for (const size_t side : {0, 1})
    straight += (length(marks.hip[side], marks.knee[side]) + length(marks.knee[side], marks.ankle[side])) / 2;
  const Tensor reach = rest[marks.head] - (rest[marks.ankle[0]] + rest[marks.ankle[1]]) / 2;
  return std::abs(reach[up].item<double>()) < 0.85 * straight;
}

/// Metres from the lowest joint to the highest one, arms aside, where the person stands straightest: 95 % of the frames
/// have less.
double straightest_height(const Clip& clip, const Landmarks& marks) {
  std::vector<int64_t> kept;
  std::vector<bool> arm(static_cast<size_t>(clip.skeleton.size()), false);
  for (int64_t j = 0; j < clip.skeleton.size(); ++j) {
    const int parent = clip.skeleton.parents[static_cast<size_t>(j)];
    arm[static_cast<size_t>(j)] =
        j == marks.shoulder[0] || j == marks.shoulder[1] || (parent >= 0 && arm[static_cast<size_t>(parent)]);
    if (!arm[static_cast<size_t>(j)]) kept.push_back(j);
  }
  const Tensor heights = clip.joints.select(2, 1).index_select(1, torch::tensor(kept));
  return torch::quantile(std::get<0>(heights.max(1)) - std::get<0>(heights.min(1)), 0.95).item<double>();
}

/// Metres from the lowest joint to the highest one of a person who stands as the skeleton rests. Some rest lying: up is
/// the axis on which the head is farthest from between the ankles; +Y where that cannot be told. Of those that rest
/// folded the frames tell.
double rest_height(const Clip& clip) {
  const Tensor rest = clip.skeleton.rest_joints();
  int64_t up = 1;
  try {
    const Landmarks marks = find_landmarks(clip.skeleton, "skeleton");
    up = (rest[marks.head] - (rest[marks.ankle[0]] + rest[marks.ankle[1]]) / 2).abs().argmax().item<int64_t>();
    if (rests_folded(rest, marks, up)) return straightest_height(clip, marks);
  } catch (const Error&) {
  }
  const Tensor along = rest.select(1, up);
  return (along.max() - along.min()).item<double>();
}

Json describe_motion(const std::string& path, const ClipReadOptions& options) {
  Notes notes;
  const std::vector<Clip> clips = read_clips(path, options, &notes);
  const Clip& clip = clips.front();
  const Tensor flat = clip.joints.reshape({-1, 3});
  Json out;
  out["kind"] = "motion";
  if (clips.size() > 1) {
    out["motions"] = clips.size();
    notes.insert(notes.begin(), "all but the number of motions is of the first");
  }
  out["frames"] = clip.frames();
  out["rate"] = clip.rate;
  out["seconds"] = rounded(clip.seconds());
  const bool standard = clip.skeleton.names == standard_joint_names();
  out["joints"] = clip.skeleton.size();
  out["skeleton"] = standard ? Json("standard (SMPL's first 22 joints)") : Json(clip.skeleton.names);
  out["rest_height"] = rounded(rest_height(clip));
  out["box"] = {{"lower", numbers(std::get<0>(flat.min(0)))}, {"upper", numbers(std::get<0>(flat.max(0)))}};
  if (clip.frames() > 1) {
    const Tensor path_steps = clip.root_path().slice(0, 1) - clip.root_path().slice(0, 0, -1);
    const double travelled =
        torch::stack({path_steps.select(1, 0), path_steps.select(1, 2)}, 1).norm(2, {1}).sum().item<double>();
    out["travelled"] = rounded(travelled);
    out["mean_speed"] = rounded(travelled / (clip.seconds() - 1 / clip.rate));
  }
  if (const FloorSlope slope = floor_slope(clip); slope.stances >= FloorSlope::kLeastStances)
    out["floor_slope"] = {{"degrees", rounded(slope.degrees)},
                          {"uncertainty", rounded(slope.uncertainty)},
                          {"feet_off_plane", rounded(slope.off_plane)},
                          {"feet_off_level", rounded(slope.off_level)}};
  out["rotations"] = clip.rotations.defined() && clip.trans.defined();
  if (clip.translations.defined()) {
    const Tensor moves = clip.translations.ne(clip.skeleton.offsets).any(2).any(0);
    Json names = Json::array();
    for (int64_t j = 0; j < moves.size(0); ++j)
      if (moves[j].item<bool>()) names.push_back(clip.skeleton.names[static_cast<size_t>(j)]);
    out["joints_that_translate"] = names;
  }
  out["gender"] = clip.gender;
  if (clip.betas.defined()) out["betas"] = numbers(clip.betas);
  if (!clip.source_body.empty()) out["source_body"] = clip.source_body;
  if (clip.source_betas.defined()) out["source_betas"] = numbers(clip.source_betas);
  if (clip.action.defined()) {
    Json actions;
    for (size_t a = 0; a < clip.action_names.size(); ++a) {
      const auto frames = clip.action.eq(static_cast<int64_t>(a)).sum().item<int64_t>();
      if (frames > 0) actions[clip.action_names[a]] = frames;
    }
    out["actions"] = actions;
  }
  if (clip.contact.defined()) {
    Json contacts;
    const Tensor fraction = clip.contact.mean(0);
    for (int64_t j = 0; j < fraction.size(0); ++j)
      if (fraction[j].item<double>() > 0)
        contacts[clip.skeleton.names[static_cast<size_t>(j)]] = rounded(fraction[j].item<double>());
    out["contact_fraction"] = contacts;
  }
  if (clip.hand_targets.defined())
    out["hand_target_frames"] = clip.hand_targets.select(2, 3).gt(0.5).any(1).sum().item<int64_t>();
  if (!clip.object_names.empty()) out["objects"] = clip.object_names;
  if (!notes.empty()) out["notes"] = notes;
  return out;
}

Json describe_scene(const std::string& path, const ClipReadOptions& given) {
  SceneReadOptions options;
  options.up = given.up;
  if (given.scale > 0) options.scale = given.scale;
  const SceneFile file = read_scene_file(path, options);
  const SceneReport& report = file.report;
  Json out;
  out["kind"] = "scene";
  out["summary"] = describe(report);
  out["up"] = std::string(1, report.up) + (report.up_detected ? " (detected)" : "");
  out["metres_per_unit"] = report.scale;
  out["unit_detected"] = report.scale_detected;
  out["meshes"] = report.meshes;
  out["vertices"] = report.vertices;
  out["triangles"] = report.triangles;
  out["degenerate_faces"] = report.degenerate;
  out["points"] = report.points;
  Json lower, upper, names = Json::array();
  for (size_t k = 0; k < 3; ++k) {
    lower.push_back(rounded(report.lower[k]));
    upper.push_back(rounded(report.upper[k]));
  }
  out["box"] = {{"lower", lower}, {"upper", upper}};
  for (const Mesh& mesh : file.scene.meshes) names.push_back(mesh.name);
  if (!names.empty()) out["mesh_names"] = names;
  return out;
}

Json describe_weights(const std::string& path) {
  const SafeTensors file = read_safetensors(path);
  Json out;
  out["kind"] = "weights";
  int64_t parameters = 0;
  std::map<std::string, int64_t> parts;
  for (const auto& [name, tensor] : file.tensors) {
    parameters += tensor.numel();
    parts[name.substr(0, name.find('.'))] += tensor.numel();
  }
  out["tensors"] = file.tensors.size();
  out["parameters"] = parameters;
  for (const auto& [name, count] : parts) out["parts"][name] = count;
  for (const auto& [name, value] : file.metadata) {
    const Json parsed = Json::parse(value, nullptr, false);  // a config travels as JSON
    out["metadata"][name] = parsed.is_discarded() ? Json(value) : parsed;
  }
  return out;
}

Json describe_body(const std::string& path) {
  const BodyModel body = read_smpl_model(path);
  const Tensor y = body.template_vertices.select(1, 1);
  Json out;
  out["kind"] = "body model";
  out["name"] = body.name;
  out["joints"] = body.joints();
  out["vertices"] = body.template_vertices.size(0);
  out["triangles"] = body.faces.size(0);
  out["shape_parameters"] = body.betas();
  out["pose_blend_shapes"] = body.pose_dirs.defined();
  out["stature"] = rounded((y.max() - y.min()).item<double>());
  return out;
}

Json describe_arrays(const Npz& npz) {
  Json out;
  out["kind"] = "arrays";
  for (const auto& [name, tensor] : npz.tensors) out["arrays"][name] = tensor.sizes().vec();
  for (const auto& [name, strings] : npz.strings) out["arrays"][name] = strings.shape;
  for (const auto& [name, reason] : npz.skipped) out["skipped"][name] = reason;
  return out;
}

/// Everything short in dataset.json as it stands; long lists by their length.
Json describe_data_set(const std::string& path) {
  const Json file = parse_json<Json>(read_whole_file(path, 1ULL << 28), path);
  if (!file.is_object()) throw Error(path, "is no index of a data set");
  Json out;
  out["kind"] = "data set";
  for (const auto& [key, value] : file.items()) {
    if (value.is_array() && value.size() > 8) {
      out[key] = std::to_string(value.size()) + " entries";
    } else if (value.is_object() && value.dump().size() > 300) {
      for (const auto& [inner, content] : value.items())
        out[key][inner] =
            content.is_array() && content.size() > 8 ? Json(std::to_string(content.size()) + " entries") : content;
    } else {
      out[key] = value;
    }
  }
  return out;
}

}  // namespace

nlohmann::ordered_json describe_file(const std::string& path, const ClipReadOptions& options) {
  const torch::NoGradGuard no_gradient;
  Json out;
  out["file"] = path;
  const std::filesystem::path place(path);
  if (std::filesystem::is_directory(place)) {
    const std::string inside = (place / "dataset.json").string();
    if (!std::filesystem::exists(inside)) throw Error(path, "is a folder without a dataset.json");
    out.update(describe_data_set(inside));
    return out;
  }
  if (!std::filesystem::exists(place)) throw Error(path, "there is no such file");
  const std::string extension = extension_of(path);
  if (place.filename() == "dataset.json")
    out.update(describe_data_set(path));
  else if (extension == "safetensors")
    out.update(describe_weights(path));
  else if (extension == "npz") {
    const Npz npz = read_npz(path);
    if (holds_smpl_model(npz))
      out.update(describe_body(path));
    else if (is_clip_file(path))
      out.update(describe_motion(path, options));
    else if (holds_points(npz))
      out.update(describe_scene(path, options));
    else
      out.update(describe_arrays(npz));
  } else if (is_clip_file(path))
    out.update(describe_motion(path, options));
  else if (is_scene_extension(extension))
    out.update(describe_scene(path, options));
  else if (extension == "asf")
    throw Error(path, "is a skeleton without motion; name the .amc beside it");
  else
    throw Error(path, "is of a kind inhabit does not know");
  return out;
}

}  // namespace inhabit
