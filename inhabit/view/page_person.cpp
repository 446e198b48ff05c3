#include <algorithm>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/math/rotation.h"
#include "inhabit/view/page_parts.h"

namespace inhabit {

using nlohmann::json;

int PageBodies::add(PageBlob& blob, const BodyModel& model, const torch::Tensor& betas, int joints) {
  const torch::Tensor key = betas.defined() ? plain(betas) : torch::zeros({0});
  for (size_t i = 0; i < known.size(); ++i) {
    if (known[i].first == &model && list[i]["joints"] == joints && torch::equal(known[i].second, key))
      return static_cast<int>(i);
  }
  torch::Tensor vertices = plain(model.template_vertices), rest = plain(model.joint_template);
  if (key.numel() > 0) {
    vertices = vertices + torch::matmul(plain(model.shape_dirs).slice(2, 0, key.size(0)), key);
    rest = rest + torch::matmul(plain(model.joint_dirs).slice(2, 0, key.size(0)), key);
  }
  // Joints the clip does not have (fingers, face) move with their nearest ancestor that it has.
  torch::Tensor weights = plain(model.skin_weights).clone();
  for (int j = model.joints() - 1; j >= joints; --j) {
    weights.select(1, model.skeleton.parents[static_cast<size_t>(j)]).add_(weights.select(1, j));
  }
  weights = weights.slice(1, 0, joints);
  auto [top, index] = weights.topk(std::min<int64_t>(4, joints), 1);
  top = top / top.sum(1, true).clamp_min(1e-9);
  const torch::Tensor w = (top * 255).round().to(torch::kUInt8).contiguous();
  const torch::Tensor k = index.to(torch::kUInt8).contiguous();
  const auto bytes = [](const torch::Tensor& t) {
    return std::vector<uint8_t>(t.data_ptr<uint8_t>(), t.data_ptr<uint8_t>() + t.numel());
  };
  list.push_back({{"joints", joints},
                  {"vertices", blob.add_positions(vertices)},
                  {"faces", blob.add_indices(model.faces, vertices.size(0))},
                  {"weights", blob.add(bytes(w), "u8")},
                  {"bones", blob.add(bytes(k), "u8")},
                  {"influences", w.size(1)},
                  {"rest", blob.add_floats(rest.slice(0, 0, joints))}});
  known.emplace_back(&model, key);
  return static_cast<int>(known.size()) - 1;
}

namespace {

bool has_standard_joints(const Skeleton& skeleton) {
  const auto& standard = standard_joint_names();
  return skeleton.size() >= kStandardJoints && std::equal(standard.begin(), standard.end(), skeleton.names.begin()) &&
         std::equal(standard_parents().begin(), standard_parents().end(), skeleton.parents.begin());
}

/// The clip's betas where they are of this model, that is, where they explain the clip's own skeleton; the mean shape
/// (whose bones the page stretches to the clip's) otherwise.
torch::Tensor betas_of_model(const Clip& clip, const BodyModel& model) {
  if (!clip.betas.defined() || clip.betas.dim() != 1 || clip.betas.size(0) > model.betas()) return {};
  const int64_t joints = std::min(clip.skeleton.size(), model.joints());
  const torch::Tensor offsets = plain(shaped_skeleton(model, clip.betas).offsets).slice(0, 1, joints);
  const torch::Tensor difference = (offsets - plain(clip.skeleton.offsets).slice(0, 1, joints)).abs().max();
  return difference.item<float>() < 0.01F ? clip.betas : torch::Tensor();
}

json describe_track(PageBlob& blob, const PageTrack& track, int64_t frames, const std::string& path) {
  json out = {{"name", track.name}};
  const torch::Tensor& row = track.values.defined() ? track.values : track.labels;
  if (!row.defined() || row.dim() != 1 || row.size(0) != frames)
    throw Error(path, "track " + track.name + " and frames differ in number");
  if (track.values.defined()) {
    require_finite(track.values, path, "track " + track.name);
    const torch::Tensor q = (plain(track.values).clamp(0, 1) * 255).round().to(torch::kUInt8).contiguous();
    out["values"] = blob.add(std::vector<uint8_t>(q.data_ptr<uint8_t>(), q.data_ptr<uint8_t>() + q.numel()), "u8");
    return out;
  }
  if (track.labels.numel() > 0 && track.labels.max().item<int64_t>() >= static_cast<int64_t>(track.names.size()))
    throw Error(path, "track " + track.name + " has a label without a name");
  out["names"] = track.names;
  out["spans"] = label_spans(track.labels);
  return out;
}

/// Objects of the scene that move in the clip; who stands still needs no word.
json moving_objects(PageBlob& blob, const Clip& clip) {
  json out = json::array();
  for (size_t o = 0; o < clip.object_names.size(); ++o) {
    const torch::Tensor pose = plain(clip.object_pose.select(1, static_cast<int64_t>(o)));  // (T, 6)
    if ((pose - pose[0]).abs().max().item<float>() < 1e-5F) continue;
    const torch::Tensor rotations = matrix_to_quaternion(axis_angle_to_matrix(pose.slice(1, 3, 6)));
    out.push_back({{"name", clip.object_names[o]},
                   {"places", blob.add_positions(pose.slice(1, 0, 3))},
                   {"rotations", blob.add_units(rotations)}});
  }
  return out;
}

}  // namespace

/// Stretches of one label: [first frame, label].
json label_spans(const torch::Tensor& labels) {
  json spans = json::array();
  const torch::Tensor p = plain(labels, torch::kInt64);
  const int64_t* at = p.data_ptr<int64_t>();
  for (int64_t f = 0; f < p.numel(); ++f)
    if (spans.empty() || spans.back()[1] != at[f]) spans.push_back({f, at[f]});
  return spans;
}

json intention_spans(const torch::Tensor& labels, const std::string& path) {
  if (labels.dim() != 1 || labels.numel() == 0 || labels.min().item<int64_t>() < 0)
    throw Error(path, "intention labels must be one for each frame, from 0 on");
  return label_spans(labels);
}

json describe_person(PageBlob& blob, PageBodies& bodies, const PagePerson& person, const std::string& path) {
  const Clip& clip = person.clip;
  validate(clip, path);
  if (!std::isfinite(person.start_seconds)) throw Error(path, "a start time is not finite");
  static const char* const kRoles[] = {"motion", "past", "truth", "prediction", "future", "intention", "filled"};
  json out = {{"name", person.name},
              {"role", kRoles[static_cast<int>(person.role)]},
              {"start", person.start_seconds},
              {"rate", clip.rate},
              {"frames", clip.frames()},
              {"names", clip.skeleton.names},
              {"parents", clip.skeleton.parents}};
  const bool figure =
      person.joints_alone || person.role == PagePerson::Role::future || person.role == PagePerson::Role::intention;
  if (figure)
    out["motion"] = blob.add_motion(clip.joints);
  else
    out["joints"] = blob.add_positions(clip.joints);
  const BodyModel& model = person.body != nullptr ? *person.body : builtin_body();
  if (!figure && clip.rotations.defined() && clip.trans.defined() && has_standard_joints(clip.skeleton) &&
      model.template_vertices.defined()) {
    const int joints = std::min(model.joints(), clip.skeleton.size());
    out["body"] = bodies.add(blob, model, betas_of_model(clip, model), joints);
    const torch::Tensor rotations = plain(clip.rotations).slice(1, 0, joints);
    out["rotations"] = blob.add_units(matrix_to_quaternion(axis_angle_to_matrix(rotations)));
    out["trans"] = blob.add_positions(clip.trans);
    out["offsets"] = blob.add_floats(clip.skeleton.offsets.slice(0, 0, joints));
  }
  if (clip.action.defined()) {
    out["actions"] = {{"names", clip.action_names}, {"spans", label_spans(clip.action)}};
  }
  if (person.labels.defined()) {
    if (person.labels.numel() != clip.frames()) throw Error(path, "intention labels and frames differ in number");
    out["intentions"] = intention_spans(person.labels, path);
  }
  if (!person.keys.empty()) {
    for (const int64_t key : person.keys)
      if (key < 0 || key >= clip.frames()) throw Error(path, "a key frame is outside its clip");
    out["keys"] = person.keys;
    if (person.given) {
      if (person.given->frames() != static_cast<int64_t>(person.keys.size()))
        throw Error(path, "key frames and given poses differ in number");
      PagePerson given;
      given.clip = *person.given;
      given.body = person.body;
      out["given"] = describe_person(blob, bodies, given, path);
      for (const int64_t joint : person.given_joints)
        if (joint < 0 || joint >= person.given->skeleton.size()) throw Error(path, "a given joint does not exist");
      if (!person.given_joints.empty()) out["given"]["only"] = person.given_joints;
    }
  }
  if (person.collides.defined()) {
    if (person.collides.numel() != clip.frames()) throw Error(path, "collisions and frames differ in number");
    json spans = label_spans(person.collides);
    size_t stretch = 0;
    for (json& span : spans)
      if (span[1] != 0 && stretch < person.collides_with.size()) span.push_back(person.collides_with[stretch++]);
    out["collides"] = std::move(spans);
  }
  for (const PageTrack& track : person.tracks)
    out["tracks"].push_back(describe_track(blob, track, clip.frames(), path));
  if (clip.hand_targets.defined()) {
    const torch::Tensor hands = plain(clip.hand_targets);
    const torch::Tensor on = (hands.select(2, 3) > 0.5).to(torch::kUInt8).contiguous();
    if (on.any().item<bool>()) {
      // A place is only meant where the flag is set: keep others out of the quantisation's bounding box.
      const torch::Tensor place = torch::where(on.unsqueeze(2).to(torch::kBool), hands.slice(2, 0, 3),
                                               plain(clip.root_path()).unsqueeze(1).expand({-1, 2, 3}));
      out["hands"] = {
          {"places", blob.add_positions(place)},
          {"on", blob.add(std::vector<uint8_t>(on.data_ptr<uint8_t>(), on.data_ptr<uint8_t>() + on.numel()), "u8")}};
    }
  }
  if (json objects = moving_objects(blob, clip); !objects.empty()) out["objects"] = std::move(objects);
  return out;
}

}  // namespace inhabit
