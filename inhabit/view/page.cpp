#include "inhabit/view/page.h"

#include <zlib.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/math/rotation.h"
#include "inhabit/view/page_template.h"

namespace inhabit {
namespace {

using nlohmann::json;

constexpr int64_t kMaxTriangles = 200'000, kMaxPoints = 60'000, kMaxContactPairs = 24'000;
constexpr double kContactRate = 15;  // maps a second; the page interpolates

torch::Tensor plain(const torch::Tensor& t, torch::ScalarType type = torch::kFloat32) {
  return t.detach().to(torch::kCPU, type).contiguous();
}

/// The arrays of a page, one after the other, each described in the header by place, count, type and dequantisation
/// value = min + scale * stored (per axis where they are lists).
struct Blob {
  std::string bytes;

  template <typename T>
  json add(const std::vector<T>& values, const char* type) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    const json ref = {{"at", bytes.size()}, {"count", values.size()}, {"type", type}};
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return ref;
  }
  json add_floats(const torch::Tensor& t) {
    const torch::Tensor p = plain(t);
    return add(std::vector<float>(p.data_ptr<float>(), p.data_ptr<float>() + p.numel()), "f32");
  }
  /// (..., 3) as 16-bit steps of the bounding box.
  json add_positions(const torch::Tensor& t) {
    const torch::Tensor p = plain(t).reshape({-1, 3});
    if (p.size(0) == 0) return add(std::vector<uint16_t>(), "u16");
    const torch::Tensor low = std::get<0>(p.min(0)), high = std::get<0>(p.max(0));
    const torch::Tensor step = ((high - low) / 65535.0).clamp_min(1e-9);
    const torch::Tensor q = ((p - low) / step).round().clamp(0, 65535).to(torch::kInt32).contiguous();
    json ref = add(std::vector<uint16_t>(q.data_ptr<int>(), q.data_ptr<int>() + q.numel()), "u16");
    for (int a = 0; a < 3; ++a) {
      ref["min"].push_back(low[a].item<float>());
      ref["scale"].push_back(step[a].item<float>());
    }
    return ref;
  }
  /// (T, J, 3) to a millimetre, within 4 km, for what must be small: changes from frame to frame, joints after the
  /// first as seen from it, as (J, 3, T) 24-bit numbers, first their low bytes, then the middle and the high ones.
  json add_motion(const torch::Tensor& joints) {
    constexpr double kUnit = 0.001;
    const int64_t frames = joints.size(0);
    const torch::Tensor root = joints.slice(1, 0, 1);
    const torch::Tensor seen = torch::cat({root, joints.slice(1, 1) - root}, 1).flatten(1).t();
    const torch::Tensor steps = (plain(seen, torch::kFloat64) / kUnit).round().clamp(-4e6, 4e6).to(torch::kInt32);
    const torch::Tensor changes = torch::cat({steps.slice(1, 0, 1), steps.diff(1, 1)}, 1).contiguous();
    const int* at = changes.data_ptr<int>();
    std::vector<uint8_t> planes;
    for (const int shift : {0, 8, 16})
      for (int64_t i = 0; i < changes.numel(); ++i) planes.push_back(static_cast<uint8_t>(at[i] >> shift));
    return {{"ref", add(planes, "u8")}, {"unit", kUnit}, {"frames", frames}};
  }
  /// Numbers in [-1, 1] as signed 16-bit.
  json add_units(const torch::Tensor& t) {
    const torch::Tensor q = (plain(t) * 32767.0).round().clamp(-32767, 32767).to(torch::kInt32).contiguous();
    json ref = add(std::vector<int16_t>(q.data_ptr<int>(), q.data_ptr<int>() + q.numel()), "i16");
    ref["min"] = {0.0};
    ref["scale"] = {1.0 / 32767.0};
    return ref;
  }
  json add_indices(const torch::Tensor& t, int64_t bound) {
    const torch::Tensor p = plain(t, torch::kInt64);
    const int64_t* at = p.data_ptr<int64_t>();
    if (bound <= 65536) return add(std::vector<uint16_t>(at, at + p.numel()), "u16");
    return add(std::vector<uint32_t>(at, at + p.numel()), "u32");
  }
};

void require_finite(const torch::Tensor& t, const std::string& path, const std::string& what) {
  if (t.numel() > 0 && !torch::isfinite(t).all().item<bool>())
    throw Error(path, what + " has a number that is not finite");
}

/// Body meshes of the page; people of one shape share one.
struct Bodies {
  json list = json::array();
  std::vector<std::pair<const BodyModel*, torch::Tensor>> known;

  /// Index of the mesh of `model` shaped by `betas` (may be undefined) with weights on the first `joints` joints only.
  int add(Blob& blob, const BodyModel& model, const torch::Tensor& betas, int joints) {
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
};

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

json describe_track(Blob& blob, const PageTrack& track, int64_t frames, const std::string& path) {
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

json describe_person(Blob& blob, Bodies& bodies, const PagePerson& person, const std::string& path) {
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
  const bool figure = person.role == PagePerson::Role::future || person.role == PagePerson::Role::intention;
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
    out["collides"] = label_spans(person.collides);
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
  return out;
}

/// Vertices in one cell of a grid become one; triangles that collapse go. Cells grow until `target` triangles remain.
Mesh thinned(const Mesh& mesh, int64_t target) {
  const torch::Tensor vertices = plain(mesh.vertices), faces = plain(mesh.faces, torch::kInt64);
  const torch::Tensor low = std::get<0>(vertices.min(0)), extent = std::get<0>(vertices.max(0)) - low;
  double cell = std::max(1e-4, extent.max().item<double>() / 1024);
  for (Mesh out = mesh;; cell *= 1.3) {
    if (out.faces.size(0) <= target) return out;
    const torch::Tensor q = ((vertices - low) / cell).floor().to(torch::kInt64);
    const torch::Tensor key = (q.select(1, 0) * 2048 + q.select(1, 1)) * 2048 + q.select(1, 2);
    const auto [unique, inverse, counts] = at::_unique2(key, true, true, true);
    out.vertices =
        torch::zeros({unique.size(0), 3}).index_add_(0, inverse, vertices) / counts.to(torch::kFloat32).unsqueeze(1);
    const torch::Tensor f = inverse.index({faces.reshape({-1})}).reshape({-1, 3});
    const torch::Tensor a = f.select(1, 0), b = f.select(1, 1), c = f.select(1, 2);
    out.faces = f.index({(a != b) & (b != c) & (a != c)});
  }
}

json describe_scene(Blob& blob, const Scene& scene, const std::string& path) {
  int64_t triangles = 0;
  for (const Mesh& mesh : scene.meshes) triangles += mesh.faces.defined() ? mesh.faces.size(0) : 0;
  json out = {{"meshes", json::array()}};
  for (const Mesh& full : scene.meshes) {
    if (!full.faces.defined() || full.faces.numel() == 0) continue;
    require_finite(full.vertices, path, "mesh " + full.name + " of the scene");
    if (full.faces.min().item<int64_t>() < 0 || full.faces.max().item<int64_t>() >= full.vertices.size(0))
      throw Error(path, "mesh " + full.name + " of the scene names a vertex it does not have");
    const Mesh mesh = triangles > kMaxTriangles ? thinned(full, full.faces.size(0) * kMaxTriangles / triangles) : full;
    out["meshes"].push_back({{"name", mesh.name},
                             {"color", mesh.color},
                             {"vertices", blob.add_positions(mesh.vertices)},
                             {"faces", blob.add_indices(mesh.faces, mesh.vertices.size(0))}});
  }
  if (scene.points.defined() && scene.points.numel() > 0) {
    require_finite(scene.points, path, "the scene's point cloud");
    const int64_t n = scene.points.size(0), stride = (n + kMaxPoints - 1) / kMaxPoints;
    out["points"] = blob.add_positions(scene.points.slice(0, 0, n, stride));
  }
  return out;
}

/// Of the T x J x N values only those (joint, point) pairs are kept whose largest value over time is worth a look, at
/// kContactRate maps a second, 8 bits each, as differences from the map before (which is what compresses).
json describe_contacts(Blob& blob, const PageContacts& contacts, const std::string& path) {
  const torch::Tensor maps = plain(contacts.maps);
  if (maps.dim() != 3 || contacts.points.dim() != 2 || contacts.points.size(1) != 3 ||
      maps.size(2) != contacts.points.size(0) || maps.size(0) == 0)
    throw Error(path, "contact maps (T, J, N) and points (N, 3) do not agree");
  const int64_t frames = maps.size(0), joints = maps.size(1);
  const auto& names = contacts.names.empty() ? standard_joint_names() : contacts.names;
  if (static_cast<int64_t>(names.size()) != joints) throw Error(path, "contact maps have other joints than names");
  if (!(contacts.rate > 0) || !std::isfinite(contacts.rate) || !std::isfinite(contacts.start_seconds))
    throw Error(path, "contact maps need a rate above zero and a finite start time");
  require_finite(maps, path, "a contact map");
  require_finite(contacts.points, path, "a contact map's points");

  const int64_t step = std::max<int64_t>(1, std::llround(contacts.rate / kContactRate));
  const torch::Tensor key_maps = maps.slice(0, 0, frames, step);
  const int64_t keys = key_maps.size(0);
  const torch::Tensor largest = std::get<0>(key_maps.max(0)).contiguous();  // (J, N)
  double threshold = 0.04;
  if ((largest > threshold).sum().item<int64_t>() > kMaxContactPairs)
    threshold = std::get<0>(largest.reshape({-1}).topk(kMaxContactPairs)).min().item<double>();
  std::vector<uint32_t> first{0};
  std::vector<uint8_t> values;
  std::vector<torch::Tensor> chosen;
  for (int64_t j = 0; j < joints; ++j) {
    const torch::Tensor index = torch::nonzero(largest[j] > threshold).squeeze(1);
    const torch::Tensor q = (key_maps.select(1, j).index_select(1, index).clamp(0, 1) * 255).round();
    const torch::Tensor before = torch::cat({torch::zeros({1, index.size(0)}), q.slice(0, 0, keys - 1)});
    const torch::Tensor change = (q - before).transpose(0, 1).to(torch::kInt32).contiguous();  // (points, keys)
    const int* at = change.data_ptr<int>();
    for (int64_t i = 0; i < change.numel(); ++i) values.push_back(static_cast<uint8_t>(at[i]));
    chosen.push_back(index);
    first.push_back(first.back() + static_cast<uint32_t>(index.size(0)));
  }
  return {{"names", names},
          {"start", contacts.start_seconds},
          {"rate", contacts.rate / static_cast<double>(step)},
          {"keys", keys},
          {"points", blob.add_positions(contacts.points)},
          {"first", blob.add(first, "u32")},
          {"index", blob.add_indices(torch::cat(chosen), contacts.points.size(0))},
          {"changes", blob.add(values, "u8")}};
}

json describe_recordings(const PageRecordings& recordings, const std::string& path) {
  if (!(recordings.rate > 0) || !std::isfinite(recordings.rate)) throw Error(path, "recordings need a rate above zero");
  json rows = json::array();
  for (const PageRecordings::Row& row : recordings.rows)
    rows.push_back({{"name", row.name},
                    {"group", row.group},
                    {"frames", row.labels.numel()},
                    {"spans", intention_spans(row.labels, path)},
                    {"marked", row.marked}});
  return {{"rate", recordings.rate}, {"rows", rows}};
}

std::string gzipped(const std::string& bytes) {
  z_stream stream{};
  constexpr int kGzip = 15 + 16;
  constexpr int kLevel = 6;  // with 9 a page of 50 futures takes twice as long for 2.6 % fewer bytes
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kGzip, 9, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
  if (bytes.size() > std::numeric_limits<uInt>::max()) throw Error("the page's data is beyond 4 GiB");
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string base64(const std::string& bytes) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t v = 0;
    for (size_t k = 0; k < 3; ++k) v = v << 8U | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0U);
    for (size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : kDigits[v >> (18 - 6 * k) & 63U];
  }
  return out;
}

std::string escaped_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

/// JSON that cannot end the script element it stands in; bytes that are not UTF-8 become U+FFFD.
std::string script_json(const json& value) {
  std::string out;
  for (const char c : value.dump(-1, ' ', false, json::error_handler_t::replace)) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string page_text(const Page& page, const std::string& path, std::string_view page_template) {
  if (page.people.empty() && (page.scene == nullptr || page.scene->empty())) throw Error(path, "nothing to show");
  Blob blob;
  Bodies bodies;
  json header = {{"note", page.note}, {"people", json::array()}};
  for (const PagePerson& person : page.people) header["people"].push_back(describe_person(blob, bodies, person, path));
  header["bodies"] = bodies.list;
  if (page.scene != nullptr) header["scene"] = describe_scene(blob, *page.scene, path);
  if (page.recordings) header["recordings"] = describe_recordings(*page.recordings, path);
  if (page.contacts) header["contacts"] = describe_contacts(blob, *page.contacts, path);

  const std::string title = escaped_html(page.title.empty() ? "inhabit" : page.title);
  const std::string data = "<script id=\"header\" type=\"application/json\">" + script_json(header) +
                           "</script>\n<script id=\"blob\" type=\"text/plain\">" + base64(gzipped(blob.bytes)) +
                           "</script>";
  // One pass over the template, so that marks inside a title or the data mean nothing.
  std::string out;
  std::string_view rest = page_template;
  static constexpr std::string_view kTitle = "<!--inhabit:title-->", kData = "<!--inhabit:data-->";
  while (!rest.empty()) {
    const size_t at_title = rest.find(kTitle), at_data = rest.find(kData), at = std::min(at_title, at_data);
    out += rest.substr(0, at);
    if (at == std::string_view::npos) break;
    out += at == at_title ? title : data;
    rest.remove_prefix(at + (at == at_title ? kTitle.size() : kData.size()));
  }
  return out;
}

void write_page(const std::string& path, const Page& page) {
  write_atomically(path, page_text(page, path, page_template()));
}

}  // namespace inhabit
