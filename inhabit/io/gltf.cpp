#include "inhabit/io/gltf.h"

#include <map>
#include <sstream>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/tiny_gltf_config.h"
#include "inhabit/math/rotation.h"

namespace inhabit {
namespace {

using torch::Tensor;

/// A mesh over joints, in the frame of the person's rest pose.
struct SkinnedMesh {
  Tensor vertices;     ///< (V, 3) float
  Tensor faces;        ///< (F, 3) int64
  Tensor normals;      ///< (V, 3), undefined: drawn flat
  Tensor weights;      ///< (V, J)
  Tensor rest_joints;  ///< (J, 3) where the joints are in that frame
};

Tensor vertex_normals(const Tensor& vertices, const Tensor& faces) {
  const Tensor corners = vertices.index_select(0, faces.reshape({-1})).view({-1, 3, 3});
  const Tensor a = corners.select(1, 0);
  const Tensor normal = torch::cross(corners.select(1, 1) - a, corners.select(1, 2) - a, 1);
  Tensor sum = torch::zeros_like(vertices);
  for (int k = 0; k < 3; ++k) sum.index_add_(0, faces.select(1, k), normal);
  const Tensor length = sum.norm(2, {1}, true);
  return torch::where(length > 1e-12, sum / length.clamp_min(1e-12), torch::tensor({0.F, 1.F, 0.F}).expand_as(sum));
}

/// A square spindle along each bone, as animation programs draw skeletons; leaves get a short one.
SkinnedMesh bones_mesh(const Skeleton& skeleton) {
  const Tensor rest = skeleton.rest_joints().contiguous();
  const auto at = rest.accessor<float, 2>();
  std::vector<float> vertices;
  std::vector<int64_t> faces, owners;
  auto add_spindle = [&](int64_t joint, const Eigen::Vector3f& from, const Eigen::Vector3f& to) {
    const Eigen::Vector3f along = to - from;
    const float length = along.norm();
    if (length < 1e-4F) return;
    const Eigen::Vector3f side = along.unitOrthogonal(), other = along.normalized().cross(side);
    const float radius = std::clamp(0.12F * length, 0.006F, 0.03F);
    const Eigen::Vector3f waist = from + 0.2F * along;
    const auto first = static_cast<int64_t>(vertices.size() / 3);
    for (const Eigen::Vector3f& v :
         {from, Eigen::Vector3f(waist + radius * side), Eigen::Vector3f(waist + radius * other),
          Eigen::Vector3f(waist - radius * side), Eigen::Vector3f(waist - radius * other), to}) {
      vertices.insert(vertices.end(), {v.x(), v.y(), v.z()});
      owners.push_back(joint);
    }
    for (int64_t k = 0; k < 4; ++k) {
      const int64_t here = first + 1 + k, next = first + 1 + (k + 1) % 4;
      faces.insert(faces.end(), {first, next, here, here, next, first + 5});
    }
  };
  std::vector<bool> leaf(skeleton.parents.size(), true);
  for (int64_t j = 1; j < skeleton.size(); ++j) {
    const int64_t parent = skeleton.parents[static_cast<size_t>(j)];
    leaf[static_cast<size_t>(parent)] = false;
    add_spindle(parent, {at[parent][0], at[parent][1], at[parent][2]}, {at[j][0], at[j][1], at[j][2]});
  }
  for (int64_t j = 0; j < skeleton.size(); ++j) {
    if (!leaf[static_cast<size_t>(j)]) continue;
    const Eigen::Vector3f from(at[j][0], at[j][1], at[j][2]);
    Eigen::Vector3f along(0, 0.08F, 0);
    if (j > 0) {
      const auto o = skeleton.offsets[j].contiguous();
      const Eigen::Vector3f offset(o[0].item<float>(), o[1].item<float>(), o[2].item<float>());
      if (offset.norm() > 1e-4F) along = 0.06F * offset.normalized();
    }
    add_spindle(j, from, from + along);
  }
  SkinnedMesh mesh;
  mesh.vertices = torch::tensor(vertices).view({-1, 3});
  mesh.faces = torch::tensor(faces, torch::kInt64).view({-1, 3});
  const Tensor owner = torch::tensor(owners, torch::kInt64);
  mesh.weights = torch::zeros({owner.size(0), skeleton.size()});
  mesh.weights.scatter_(1, owner.unsqueeze(1), 1.0);
  mesh.rest_joints = rest;
  return mesh;
}

SkinnedMesh body_mesh(const BodyModel& body, const Tensor& betas) {
  SkinnedMesh mesh;
  mesh.vertices = body.template_vertices;
  mesh.rest_joints = body.joint_template;
  if (betas.defined() && betas.numel() > 0) {
    const int64_t n = std::min(betas.size(0), body.betas());
    const Tensor b = betas.narrow(0, 0, n).to(torch::kFloat32);
    mesh.vertices = mesh.vertices + body.shape_dirs.narrow(2, 0, n).matmul(b);
    mesh.rest_joints = mesh.rest_joints + body.joint_dirs.narrow(2, 0, n).matmul(b);
  }
  mesh.faces = body.faces;
  mesh.normals = vertex_normals(mesh.vertices, mesh.faces);
  mesh.weights = body.skin_weights;
  return mesh;
}

/// Appends to one binary buffer and describes what was appended.
class GltfBuilder {
 public:
  tinygltf::Model model;

  GltfBuilder() {
    model.asset.version = "2.0";
    model.asset.generator = "inhabit";
    model.buffers.emplace_back();
    model.scenes.emplace_back();
    model.defaultScene = 0;
  }

  /// Accessor of a contiguous tensor; `type` is VEC3 and the like, one element per row of the first dimension.
  int accessor(const Tensor& data, int component, int type, int target, bool bounds) {
    auto& bytes = model.buffers[0].data;
    while (bytes.size() % 4 != 0) bytes.push_back(0);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = data.nbytes();
    view.target = target;
    const auto* begin = static_cast<const unsigned char*>(data.data_ptr());
    bytes.insert(bytes.end(), begin, begin + data.nbytes());
    model.bufferViews.push_back(view);
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model.bufferViews.size()) - 1;
    accessor.componentType = component;
    accessor.type = type;
    accessor.count = static_cast<size_t>(data.size(0));
    if (bounds) {
      const Tensor rows = data.reshape({data.size(0), -1}).to(torch::kFloat64);
      const Tensor low = std::get<0>(rows.min(0)), high = std::get<0>(rows.max(0));
      for (int64_t k = 0; k < rows.size(1); ++k) {
        accessor.minValues.push_back(low[k].item<double>());
        accessor.maxValues.push_back(high[k].item<double>());
      }
    }
    model.accessors.push_back(accessor);
    return static_cast<int>(model.accessors.size()) - 1;
  }

  int positions(const Tensor& points) {
    return accessor(points.to(torch::kFloat32).contiguous(), TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3,
                    TINYGLTF_TARGET_ARRAY_BUFFER, true);
  }

  int indices(const Tensor& faces) {
    return accessor(faces.reshape({-1}).to(torch::kInt32).contiguous(), TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                    TINYGLTF_TYPE_SCALAR, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, false);
  }

  int material(const std::array<float, 3>& color) {
    const auto [found, is_new] = materials_.try_emplace(color, static_cast<int>(model.materials.size()));
    if (is_new) {
      tinygltf::Material material;
      material.name = "color_" + std::to_string(found->second);
      const auto part = [&](int k) {
        const double value = color[static_cast<size_t>(k)];
        return std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0.5;
      };
      material.pbrMetallicRoughness.baseColorFactor = {part(0), part(1), part(2), 1.0};
      material.pbrMetallicRoughness.metallicFactor = 0.0;
      material.pbrMetallicRoughness.roughnessFactor = 0.9;
      material.doubleSided = true;  // scans and rooms are open surfaces
      model.materials.push_back(material);
    }
    return found->second;
  }

  int add_node(const tinygltf::Node& node, bool at_root) {
    model.nodes.push_back(node);
    const int index = static_cast<int>(model.nodes.size()) - 1;
    if (at_root) model.scenes[0].nodes.push_back(index);
    return index;
  }

  int add_mesh(const std::string& name, const tinygltf::Primitive& primitive) {
    tinygltf::Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(primitive);
    model.meshes.push_back(mesh);
    return static_cast<int>(model.meshes.size()) - 1;
  }

 private:
  std::map<std::array<float, 3>, int> materials_;
};

void add_scene(GltfBuilder& builder, const Scene& scene, const std::string& subject) {
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.faces.numel() == 0 || mesh.vertices.numel() == 0) continue;
    if (mesh.faces.min().item<int64_t>() < 0 || mesh.faces.max().item<int64_t>() >= mesh.vertices.size(0))
      throw Error(subject, "mesh " + mesh.name + " has a face with a vertex that does not exist");
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.attributes["POSITION"] = builder.positions(mesh.vertices);
    primitive.indices = builder.indices(mesh.faces);
    primitive.material = builder.material(mesh.color);
    tinygltf::Node node;
    node.name = mesh.name;
    node.mesh = builder.add_mesh(mesh.name, primitive);
    builder.add_node(node, true);
  }
  if (scene.points.defined() && scene.points.size(0) > 0) {
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_POINTS;
    primitive.attributes["POSITION"] = builder.positions(scene.points);
    primitive.material = builder.material({0.45F, 0.45F, 0.45F});
    tinygltf::Node node;
    node.name = "points";
    node.mesh = builder.add_mesh("points", primitive);
    builder.add_node(node, true);
  }
}

/// Unit quaternions (T, 4) as x y z w, each on the same side as the one before, so that curves of single numbers are
/// smooth too.
Tensor quaternion_track(const Tensor& axis_angle) {
  Tensor q = matrix_to_quaternion(axis_angle_to_matrix(axis_angle.to(torch::kFloat64)));
  q = torch::cat({q.narrow(1, 1, 3), q.narrow(1, 0, 1)}, 1);
  q = (q / q.norm(2, {1}, true)).contiguous();
  auto at = q.accessor<double, 2>();
  for (int64_t t = 1; t < q.size(0); ++t) {
    double dot = 0;
    for (int k = 0; k < 4; ++k) dot += at[t][k] * at[t - 1][k];
    if (dot < 0)
      for (int k = 0; k < 4; ++k) at[t][k] = -at[t][k];
  }
  return q.to(torch::kFloat32);
}

/// The four largest weights of each vertex, which is what glTF's readers must support; joints without weight are 0.
void add_weights(GltfBuilder& builder, const Tensor& weights, tinygltf::Primitive& primitive) {
  const int64_t n = std::min<int64_t>(4, weights.size(1));
  const auto [value, index] = weights.to(torch::kFloat32).topk(n, 1);
  Tensor four = torch::zeros({weights.size(0), 4}), joints = torch::zeros({weights.size(0), 4}, torch::kInt16);
  four.narrow(1, 0, n).copy_(value.clamp_min(0));
  four /= four.sum(1, true).clamp_min(1e-9);
  joints.narrow(1, 0, n).copy_(index);
  joints.masked_fill_(four.eq(0), 0);
  primitive.attributes["JOINTS_0"] = builder.accessor(joints.contiguous(), TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                                                      TINYGLTF_TYPE_VEC4, TINYGLTF_TARGET_ARRAY_BUFFER, false);
  primitive.attributes["WEIGHTS_0"] = builder.accessor(four.contiguous(), TINYGLTF_COMPONENT_TYPE_FLOAT,
                                                       TINYGLTF_TYPE_VEC4, TINYGLTF_TARGET_ARRAY_BUFFER, false);
}

/// The tree of a person's joints: nodes, and what moves them.
struct JointNodes {
  std::vector<int> nodes;
  std::vector<Tensor> rotations;  ///< (T, 4) of each joint, x y z w
  Tensor root;                    ///< (T, 3)
  Tensor moves;                   ///< (J) bool: joints that translate within the body
};

/// Nodes of the joints stand at the first frame, so that programs without animation show a pose of the clip.
JointNodes add_joints(GltfBuilder& builder, const Clip& clip, const std::string& name) {
  const Skeleton& skeleton = clip.skeleton;
  const int64_t J = skeleton.size();
  const Tensor offsets = skeleton.offsets.to(torch::kFloat32).contiguous();
  const Tensor places = clip.translations;
  JointNodes out;
  out.root = (clip.trans + skeleton.offsets[0]).to(torch::kFloat32).contiguous();
  out.moves = places.defined() ? places.ne(offsets).any(2).any(0) : torch::zeros({J}, torch::kBool);
  for (int64_t j = 0; j < J; ++j) {
    out.rotations.push_back(quaternion_track(clip.rotations.select(1, j)));
    tinygltf::Node node;
    node.name = skeleton.names[static_cast<size_t>(j)];
    Tensor place = j == 0 ? out.root[0] : offsets[j];
    if (j > 0 && out.moves[j].item<bool>()) place = places[0][j];
    for (int k = 0; k < 3; ++k) node.translation.push_back(place[k].item<float>());
    for (int k = 0; k < 4; ++k) node.rotation.push_back(out.rotations.back()[0][k].item<float>());
    out.nodes.push_back(builder.add_node(node, false));
    if (j == 0) continue;
    const int parent = out.nodes[static_cast<size_t>(skeleton.parents[static_cast<size_t>(j)])];
    builder.model.nodes[static_cast<size_t>(parent)].children.push_back(out.nodes.back());
  }
  tinygltf::Node armature;
  armature.name = name;
  armature.children = {out.nodes[0]};
  builder.add_node(armature, true);
  return out;
}

void add_skin(GltfBuilder& builder, const SkinnedMesh& mesh, const std::vector<int>& joints, const GltfPerson& person) {
  Tensor inverse_bind = torch::eye(4).repeat({static_cast<int64_t>(joints.size()), 1, 1});
  inverse_bind.select(1, 3).narrow(1, 0, 3).copy_(-mesh.rest_joints);  // column-major: the fourth row is the shift
  tinygltf::Skin skin;
  skin.name = person.name;
  skin.joints = joints;
  skin.skeleton = joints[0];
  skin.inverseBindMatrices =
      builder.accessor(inverse_bind.contiguous(), TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_MAT4, 0, false);
  builder.model.skins.push_back(skin);

  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] = builder.positions(mesh.vertices);
  if (mesh.normals.defined())
    primitive.attributes["NORMAL"] = builder.accessor(mesh.normals.contiguous(), TINYGLTF_COMPONENT_TYPE_FLOAT,
                                                      TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER, false);
  add_weights(builder, mesh.weights, primitive);
  primitive.indices = builder.indices(mesh.faces);
  primitive.material = builder.material(person.color);
  tinygltf::Node node;
  node.name = person.name + "_skin";
  node.mesh = builder.add_mesh(person.name, primitive);
  node.skin = static_cast<int>(builder.model.skins.size()) - 1;
  builder.add_node(node, true);  // a skinned mesh takes its place from the joints alone
}

/// All people move in one animation.
void add_animation(GltfBuilder& builder, const Clip& clip, const JointNodes& joints) {
  if (builder.model.animations.empty()) {
    builder.model.animations.emplace_back();
    builder.model.animations[0].name = "motion";
  }
  tinygltf::Animation& animation = builder.model.animations[0];
  const Tensor times = (torch::arange(clip.frames(), torch::kFloat64) / clip.rate).to(torch::kFloat32);
  const int input = builder.accessor(times, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_SCALAR, 0, true);
  auto add_track = [&](int node, const char* path, const Tensor& values, int type) {
    tinygltf::AnimationSampler sampler;
    sampler.input = input;
    sampler.output = builder.accessor(values.contiguous(), TINYGLTF_COMPONENT_TYPE_FLOAT, type, 0, false);
    sampler.interpolation = "LINEAR";
    animation.samplers.push_back(sampler);
    tinygltf::AnimationChannel channel;
    channel.sampler = static_cast<int>(animation.samplers.size()) - 1;
    channel.target_node = node;
    channel.target_path = path;
    animation.channels.push_back(channel);
  };
  add_track(joints.nodes[0], "translation", joints.root, TINYGLTF_TYPE_VEC3);
  for (int64_t j = 1; j < clip.skeleton.size(); ++j)
    if (joints.moves[j].item<bool>())
      add_track(joints.nodes[static_cast<size_t>(j)], "translation", clip.translations.select(1, j).to(torch::kFloat32),
                TINYGLTF_TYPE_VEC3);
  for (size_t j = 0; j < joints.nodes.size(); ++j)
    add_track(joints.nodes[j], "rotation", joints.rotations[j], TINYGLTF_TYPE_VEC4);
}

void add_person(GltfBuilder& builder, const GltfPerson& person, const std::string& subject) {
  const Clip& clip = *person.clip;
  if (!clip.rotations.defined() || !clip.trans.defined())
    throw Error(subject, "the motion has positions only; glTF needs joint rotations (fit a body to it first)");
  validate(clip, subject);
  const int64_t J = clip.skeleton.size();
  if (J > 32767) throw Error(subject, "a skeleton of " + std::to_string(J) + " joints is too large for glTF");
  const bool skinned = person.body != nullptr && person.body->template_vertices.defined() &&
                       person.body->skeleton.parents == clip.skeleton.parents;
  const SkinnedMesh mesh = skinned ? body_mesh(*person.body, clip.betas) : bones_mesh(clip.skeleton);
  const JointNodes joints = add_joints(builder, clip, person.name);
  if (mesh.faces.numel() > 0) add_skin(builder, mesh, joints.nodes, person);
  add_animation(builder, clip, joints);
}

}  // namespace

std::string glb_bytes(const std::vector<GltfPerson>& people, const Scene* scene, const std::string& subject) {
  const torch::NoGradGuard no_gradient;
  GltfBuilder builder;
  for (const GltfPerson& person : people) add_person(builder, person, subject);
  if (scene != nullptr) add_scene(builder, *scene, subject);
  if (builder.model.nodes.empty()) throw Error(subject, "there is nothing to write: no person, no mesh, no point");
  std::ostringstream stream;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&builder.model, stream, false, true))
    throw Error(subject, "the glTF file cannot be made");
  return std::move(stream).str();
}

void write_glb(const std::string& path, const std::vector<GltfPerson>& people, const Scene* scene) {
  write_atomically(path, glb_bytes(people, scene, path));
}

}  // namespace inhabit
