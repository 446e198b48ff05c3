#include "inhabit/io/gltf_scene.h"

#include <cstring>

#include "inhabit/error.h"
#include "inhabit/io/tiny_gltf_config.h"
#include "inhabit/io/weld.h"

namespace inhabit {
namespace {

// A file can place one mesh many times: more than this is refused rather than unfolded.
constexpr size_t kMostCorners = 300'000'000;

std::string one_line(std::string text) {
  for (char& c : text) c = std::iscntrl(static_cast<unsigned char>(c)) != 0 ? ' ' : c;
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text.substr(0, 200);
}

/// Where an accessor's elements lie. All of them are inside the buffer.
struct Elements {
  const unsigned char* first = nullptr;
  size_t count = 0, stride = 0;
  int component = 0;
  bool normalized = false;
};

template <typename Item>
const Item& item(const std::vector<Item>& items, int index, const char* what, const std::string& subject) {
  if (index < 0 || static_cast<size_t>(index) >= items.size()) {
    throw Error(subject, std::string("names a ") + what + " that is not there");
  }
  return items[static_cast<size_t>(index)];
}

Elements elements_of(const tinygltf::Model& model, int index, int type, const std::string& subject) {
  const tinygltf::Accessor& accessor = item(model.accessors, index, "accessor", subject);
  if (accessor.type != type) throw Error(subject, "an accessor has the wrong type");
  if (accessor.sparse.isSparse) throw Error(subject, "has a sparse accessor, which is not understood");
  const tinygltf::BufferView& view = item(model.bufferViews, accessor.bufferView, "buffer view", subject);
  if (view.extensions.count("EXT_meshopt_compression") != 0) throw Error(subject, "is compressed (meshopt)");
  const tinygltf::Buffer& buffer = item(model.buffers, view.buffer, "buffer", subject);
  const int component = tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType));
  if (component < 1 || component > 4) throw Error(subject, "an accessor has an unknown component type");
  const size_t element = static_cast<size_t>(component) * (type == TINYGLTF_TYPE_VEC3 ? 3 : 1);
  Elements out;
  out.count = accessor.count;
  out.stride = view.byteStride != 0 ? view.byteStride : element;
  out.component = accessor.componentType;
  out.normalized = accessor.normalized;
  const size_t size = buffer.data.size();
  const bool fits = view.byteOffset <= size && view.byteLength <= size - view.byteOffset &&
                    accessor.byteOffset <= view.byteLength && element <= view.byteLength - accessor.byteOffset &&
                    out.stride >= element &&
                    (out.count == 0 || out.count - 1 <= (view.byteLength - accessor.byteOffset - element) / out.stride);
  if (!fits) throw Error(subject, "an accessor reaches past the end of its buffer");
  out.first = buffer.data.data() + view.byteOffset + accessor.byteOffset;
  return out;
}

/// A component as a number; normalised integers (KHR_mesh_quantization) become fractions.
double component_at(const Elements& elements, const unsigned char* at) {
  const auto as = [&](auto value) {
    std::memcpy(&value, at, sizeof(value));
    if constexpr (std::is_integral_v<decltype(value)>) {
      const double most = std::numeric_limits<decltype(value)>::max();
      return elements.normalized ? std::max(static_cast<double>(value) / most, -1.0) : static_cast<double>(value);
    } else {
      return static_cast<double>(value);
    }
  };
  switch (elements.component) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return as(int8_t());
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return as(uint8_t());
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return as(int16_t());
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return as(uint16_t());
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return as(uint32_t());
    case TINYGLTF_COMPONENT_TYPE_INT:
      return as(int32_t());
    default:
      return as(float());
  }
}

size_t component_size(const Elements& elements) {
  return static_cast<size_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(elements.component)));
}

Eigen::Affine3d transform_of(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) return Eigen::Affine3d(Eigen::Map<const Eigen::Matrix4d>(node.matrix.data()));
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  if (node.translation.size() == 3)
    out.translate(Eigen::Vector3d(node.translation[0], node.translation[1], node.translation[2]));
  if (node.rotation.size() == 4) {
    out.rotate(Eigen::Quaterniond(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]).normalized());
  }
  if (node.scale.size() == 3) out.scale(Eigen::Vector3d(node.scale[0], node.scale[1], node.scale[2]));
  return out;
}

std::array<float, 3> color_of(const tinygltf::Model& model, int material) {
  std::array<float, 3> out = Mesh().color;
  if (material < 0 || static_cast<size_t>(material) >= model.materials.size()) return out;
  const tinygltf::PbrMetallicRoughness& pbr = model.materials[static_cast<size_t>(material)].pbrMetallicRoughness;
  // The factor beside a texture is white and says nothing.
  if (pbr.baseColorTexture.index >= 0 || pbr.baseColorFactor.size() < 3) return out;
  for (size_t c = 0; c < 3; ++c) {
    if (std::isfinite(pbr.baseColorFactor[c]))
      out[c] = static_cast<float>(std::clamp(pbr.baseColorFactor[c], 0.0, 1.0));
  }
  return out;
}

std::vector<int64_t> corner_indices(const tinygltf::Model& model, const tinygltf::Primitive& primitive, size_t vertices,
                                    const std::string& subject) {
  std::vector<int64_t> corners;
  if (primitive.indices < 0) {
    corners.resize(vertices);
    for (size_t i = 0; i < vertices; ++i) corners[i] = static_cast<int64_t>(i);
    return corners;
  }
  const Elements elements = elements_of(model, primitive.indices, TINYGLTF_TYPE_SCALAR, subject);
  if (elements.component == TINYGLTF_COMPONENT_TYPE_FLOAT) throw Error(subject, "its indices are no whole numbers");
  corners.reserve(elements.count);
  for (size_t i = 0; i < elements.count; ++i) {
    const double index = component_at(elements, elements.first + i * elements.stride);
    if (index < 0 || index >= static_cast<double>(vertices)) {
      throw Error(subject, "a face names vertex " + std::to_string(static_cast<int64_t>(index)) + " of " +
                               std::to_string(vertices));
    }
    corners.push_back(static_cast<int64_t>(index));
  }
  return corners;
}

/// Three indices a triangle, from a list, strip or fan; turned the other way round when `mirrored`.
std::vector<int64_t> triangles_of(const std::vector<int64_t>& corners, int mode, bool mirrored) {
  std::vector<int64_t> out;
  const auto add = [&](int64_t a, int64_t b, int64_t c) {
    out.insert(out.end(), {a, mirrored ? c : b, mirrored ? b : c});
  };
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    for (size_t i = 2; i < corners.size(); i += 3) add(corners[i - 2], corners[i - 1], corners[i]);
  } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (size_t i = 2; i < corners.size(); ++i) {
      const size_t odd = i % 2;
      add(corners[i - 2], corners[i - 1 + odd], corners[i - odd]);
    }
  } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
    for (size_t i = 2; i < corners.size(); ++i) add(corners[0], corners[i - 1], corners[i]);
  }
  return out;
}

Mesh to_mesh(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const Eigen::Affine3d& to_world,
             const std::string& subject) {
  if (primitive.extensions.count("KHR_draco_mesh_compression") != 0) throw Error(subject, "is compressed (Draco)");
  const auto attribute = primitive.attributes.find("POSITION");
  if (attribute == primitive.attributes.end()) return {};
  const Elements positions = elements_of(model, attribute->second, TINYGLTF_TYPE_VEC3, subject);
  std::vector<float> vertices;
  vertices.reserve(3 * positions.count);
  for (size_t i = 0; i < positions.count; ++i) {
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = component_at(
          positions, positions.first + i * positions.stride + static_cast<size_t>(axis) * component_size(positions));
    }
    const Eigen::Vector3f world = (to_world * p).cast<float>();
    if (!world.allFinite()) throw Error(subject, "vertex " + std::to_string(i) + " of a mesh is not finite");
    vertices.insert(vertices.end(), world.data(), world.data() + 3);
  }
  if (primitive.mode == TINYGLTF_MODE_POINTS) {
    Mesh points;
    points.vertices = torch::tensor(vertices).view({-1, 3});
    points.faces = torch::empty({0, 3}, torch::kInt64);
    return points;
  }
  const std::vector<int64_t> corners = corner_indices(model, primitive, positions.count, subject);
  const bool mirrored = to_world.linear().determinant() < 0;
  return weld(vertices, triangles_of(corners, primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode, mirrored));
}

tinygltf::Model load(std::string_view bytes, const std::string& subject, const std::string& folder) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int,
                           void*) { return true; },
                        nullptr);
  if (folder.empty()) {
    tinygltf::FsCallbacks none{};
    none.FileExists = [](const std::string&, void*) { return false; };
    none.ExpandFilePath = [](const std::string& path, void*) { return path; };
    none.ReadWholeFile = [](std::vector<unsigned char>*, std::string*, const std::string&, void*) { return false; };
    none.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
      return false;
    };
    loader.SetFsCallbacks(none);
  }
  tinygltf::Model model;
  std::string error, warning;
  if (bytes.size() > UINT32_MAX) throw Error(subject, "larger than 4 GiB");
  const auto size = static_cast<unsigned int>(bytes.size());
  const bool binary = bytes.substr(0, 4) == "glTF";
  const bool good =
      binary ? loader.LoadBinaryFromMemory(&model, &error, &warning,
                                           reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
             : loader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, folder);
  if (!good) {
    // The JSON library's own words, of which the first bracket names its class of exception.
    if (error.rfind("[json.exception", 0) == 0) error = "is no glTF file:" + error.substr(error.find(']') + 1);
    throw Error(subject, error.empty() ? "is no glTF file" : one_line(error));
  }
  return model;
}

}  // namespace

std::vector<Mesh> parse_gltf(std::string_view bytes, const std::string& subject, const std::string& folder) {
  const tinygltf::Model model = load(bytes, subject, folder);
  std::vector<std::pair<int, Eigen::Affine3d>> open;
  const auto place = [&](const std::vector<int>& nodes, const Eigen::Affine3d& at) {
    for (size_t i = nodes.size(); i > 0; --i) open.emplace_back(nodes[i - 1], at);
  };
  if (!model.scenes.empty()) {
    const int scene = std::max(model.defaultScene, 0);
    place(item(model.scenes, scene, "scene", subject).nodes, Eigen::Affine3d::Identity());
  } else {
    std::vector<bool> child(model.nodes.size(), false);
    for (const tinygltf::Node& node : model.nodes) {
      for (const int c : node.children) {
        if (c >= 0 && static_cast<size_t>(c) < child.size()) child[static_cast<size_t>(c)] = true;
      }
    }
    std::vector<int> roots;
    for (size_t i = 0; i < child.size(); ++i) {
      if (!child[i]) roots.push_back(static_cast<int>(i));
    }
    place(roots, Eigen::Affine3d::Identity());
  }
  std::vector<bool> seen(model.nodes.size(), false);
  std::vector<Mesh> meshes, skinned;
  size_t corners = 0;
  while (!open.empty()) {
    const auto [index, at] = open.back();
    open.pop_back();
    const tinygltf::Node& node = item(model.nodes, index, "node", subject);
    if (seen[static_cast<size_t>(index)]) throw Error(subject, "its nodes form no tree");
    seen[static_cast<size_t>(index)] = true;
    const Eigen::Affine3d to_world = at * transform_of(node);
    place(node.children, to_world);
    if (node.mesh < 0) continue;
    const tinygltf::Mesh& source = item(model.meshes, node.mesh, "mesh", subject);
    for (const tinygltf::Primitive& primitive : source.primitives) {
      Mesh mesh = to_mesh(model, primitive, to_world, subject);
      const bool points = primitive.mode == TINYGLTF_MODE_POINTS && mesh.vertices.defined();
      if (points ? mesh.vertices.size(0) == 0 : !mesh.faces.defined() || mesh.faces.size(0) == 0) continue;
      corners += static_cast<size_t>(points ? mesh.vertices.numel() : mesh.faces.numel());
      if (corners > kMostCorners) throw Error(subject, "unfolds to more than 100 million triangles or points");
      mesh.name = one_line(node.name.empty() ? source.name : node.name);
      mesh.color = color_of(model, primitive.material);
      (node.skin < 0 ? meshes : skinned).push_back(std::move(mesh));
    }
  }
  if (meshes.empty()) meshes = std::move(skinned);
  if (meshes.empty()) throw Error(subject, "holds neither faces nor points");
  return meshes;
}

}  // namespace inhabit
