#include <cmath>
#include <limits>

#include "handles.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/motion/usual_skeleton.h"
#include "inhabit/version.h"

namespace inhabit::c {
namespace {

std::string& last_error_text() {
  thread_local std::string text;
  return text;
}

/// A count that a caller gives: what is multiplied with it must stay a size.
int64_t checked_count(int64_t count, const char* name, int64_t least) {
  if (count < least || count > 100'000'000) throw Error(name, "is out of range");
  return count;
}

}  // namespace

void set_last_error(const std::string& text) noexcept {
  try {
    last_error_text() = text;
  } catch (...) {
    last_error_text().clear();  // no memory even for that
  }
}

const char* last_error() noexcept { return last_error_text().c_str(); }

torch::Tensor kept(const torch::Tensor& tensor) {
  const auto type = tensor.is_floating_point() ? torch::kFloat32 : torch::kInt64;
  return tensor.detach().to(torch::kCPU, type).contiguous();
}

inhabit_clip* clip_handle(Clip clip) {
  auto out = std::make_unique<inhabit_clip>();
  for (const auto& [name, tensor] : {std::pair<const char*, const torch::Tensor*>{"joints", &clip.joints},
                                     {"rotations", &clip.rotations},
                                     {"trans", &clip.trans},
                                     {"translations", &clip.translations},
                                     {"betas", &clip.betas},
                                     {"action", &clip.action},
                                     {"contact", &clip.contact},
                                     {"hand_targets", &clip.hand_targets},
                                     {"object_pose", &clip.object_pose},
                                     {"offsets", &clip.skeleton.offsets}})
    if (tensor->defined()) out->arrays[name] = kept(*tensor);
  out->clip = std::move(clip);
  return out.release();
}

void fill_array(const std::map<std::string, torch::Tensor>& arrays, const std::string& name, inhabit_array& out) {
  const auto found = arrays.find(name);
  if (found == arrays.end()) {
    std::string all;
    for (const auto& [known, tensor] : arrays) all += (all.empty() ? "" : ", ") + known;
    throw Error(name.substr(0, 64), "is none of the arrays there are: " + all);
  }
  const torch::Tensor& tensor = found->second;
  out = {};
  out.data = tensor.data_ptr();
  out.type = tensor.is_floating_point() ? INHABIT_FLOAT32 : INHABIT_INT64;
  out.dims = static_cast<int>(tensor.dim());
  for (int64_t d = 0; d < tensor.dim() && d < 8; ++d) out.shape[d] = tensor.size(d);
}

}  // namespace inhabit::c

using namespace inhabit;
using namespace inhabit::c;

const char* inhabit_version(void) { return INHABIT_VERSION; }
const char* inhabit_last_error(void) { return last_error(); }

inhabit_clip* inhabit_clip_read(const char* path) {
  return guarded<>(static_cast<inhabit_clip*>(nullptr), [&] { return clip_handle(read_clip(text_of(path, "path"))); });
}

inhabit_clip* inhabit_clip_from_joints(const float* joints, int64_t frames, const char* const* names, int64_t count,
                                       double rate) {
  return guarded<>(static_cast<inhabit_clip*>(nullptr), [&] {
    needed(joints, "joints");
    checked_count(frames, "frames", 1);
    checked_count(count, "count", 1);
    std::vector<std::string> known = standard_joint_names();
    if (names != nullptr) {
      known.clear();
      for (int64_t j = 0; j < count; ++j) known.push_back(text_of(names[j], "a name"));
    }
    if (count != static_cast<int64_t>(known.size())) throw Error("count", "is not 22, and joints have no names");
    checked_count(frames * count, "frames", 1);
    const UsualSkeleton usual = usual_skeleton(known, {}, "names");
    Clip clip;
    clip.skeleton = usual.skeleton;
    clip.rate = rate;
    const torch::Tensor order = torch::tensor(std::vector<int64_t>(usual.order.begin(), usual.order.end()));
    clip.joints = torch::from_blob(const_cast<float*>(joints), {frames, count, 3}).index_select(1, order);
    validate(clip, "joints");
    return clip_handle(std::move(clip));
  });
}

int inhabit_clip_write(const inhabit_clip* clip, const char* path, const inhabit_scene* scene) {
  return guarded<>(-1, [&] {
    write_clip(text_of(path, "path"), needed(clip, "clip").clip, scene == nullptr ? nullptr : &scene->scene);
    return 0;
  });
}

int64_t inhabit_clip_frames(const inhabit_clip* clip) { return clip == nullptr ? -1 : clip->clip.frames(); }
double inhabit_clip_rate(const inhabit_clip* clip) { return clip == nullptr ? NAN : clip->clip.rate; }
int64_t inhabit_clip_joints(const inhabit_clip* clip) { return clip == nullptr ? -1 : clip->clip.skeleton.size(); }

const char* inhabit_clip_joint_name(const inhabit_clip* clip, int64_t joint) {
  if (clip == nullptr || joint < 0 || joint >= clip->clip.skeleton.size()) return nullptr;
  return clip->clip.skeleton.names[static_cast<size_t>(joint)].c_str();
}

int inhabit_clip_joint_parent(const inhabit_clip* clip, int64_t joint) {
  if (clip == nullptr || joint < 0 || joint >= clip->clip.skeleton.size()) return -2;
  return clip->clip.skeleton.parents[static_cast<size_t>(joint)];
}

int inhabit_clip_array(const inhabit_clip* clip, const char* name, inhabit_array* out) {
  return guarded<>(-1, [&] {
    fill_array(needed(clip, "clip").arrays, text_of(name, "name"), needed(out, "out"));
    return 0;
  });
}

void inhabit_clip_free(inhabit_clip* clip) { delete clip; }

inhabit_scene* inhabit_scene_read(const char* path) {
  return guarded<>(static_cast<inhabit_scene*>(nullptr),
                   [&] { return new inhabit_scene{read_scene_file(text_of(path, "path")).scene}; });
}

inhabit_scene* inhabit_scene_from_mesh(const float* vertices, int64_t count, const int64_t* faces, int64_t triangles) {
  return guarded<>(static_cast<inhabit_scene*>(nullptr), [&] {
    needed(vertices, "vertices");
    checked_count(count, "count", 1);
    checked_count(triangles, "triangles", 0);
    const torch::Tensor points = torch::from_blob(const_cast<float*>(vertices), {count, 3}).clone();
    if (!(points.abs().max().item<float>() < 1e5F)) throw Error("vertices", "are not all within 100 km of the origin");
    Scene scene;
    scene.name = "scene";
    if (triangles == 0) {
      scene.points = points;
      return new inhabit_scene{scene};
    }
    needed(faces, "faces");
    Mesh mesh;
    mesh.name = "scene";
    mesh.vertices = points;
    mesh.faces = torch::from_blob(const_cast<int64_t*>(faces), {triangles, 3}, torch::kInt64).clone();
    if (mesh.faces.min().item<int64_t>() < 0 || mesh.faces.max().item<int64_t>() >= count)
      throw Error("faces", "have a corner that is no vertex");
    scene.meshes.push_back(mesh);
    return new inhabit_scene{scene};
  });
}

void inhabit_scene_free(inhabit_scene* scene) { delete scene; }
