#include "inhabit/io/mesh.h"

#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <map>

#include "inhabit/error.h"
#include "inhabit/io/bytes.h"
#include "inhabit/io/obj.h"
#include "inhabit/io/ply.h"
#include "inhabit/io/stl.h"

namespace inhabit {
namespace {

// Polygons are cut here: assimp's own step stops the program on some damaged files.
constexpr unsigned int kSteps = aiProcess_RemoveComponent | aiProcess_JoinIdenticalVertices;
// A file can place one mesh many times: more than this is refused rather than unfolded.
constexpr int64_t kMostVertices = 100'000'000;

void set_up(Assimp::Importer& importer) {
  // Only positions count here; without the rest, corners at one place become one vertex.
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
                                  aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                                  aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS);
}

std::string one_line(std::string text) {
  for (char& c : text) c = std::iscntrl(static_cast<unsigned char>(c)) != 0 ? ' ' : c;
  return text.substr(0, 200);
}

std::array<float, 3> color_of(const aiMaterial& material) {
  const std::array<float, 3> plain = Mesh().color;
  aiString texture;
  if (material.GetTexture(aiTextureType_BASE_COLOR, 0, &texture) == aiReturn_SUCCESS ||
      material.GetTexture(aiTextureType_DIFFUSE, 0, &texture) == aiReturn_SUCCESS) {
    return plain;  // the factor beside a texture is white and says nothing
  }
  aiColor4D color;
  if (material.Get(AI_MATKEY_BASE_COLOR, color) != aiReturn_SUCCESS &&
      material.Get(AI_MATKEY_COLOR_DIFFUSE, color) != aiReturn_SUCCESS) {
    return plain;
  }
  std::array<float, 3> out{color.r, color.g, color.b};
  for (float& channel : out) channel = std::isfinite(channel) ? std::clamp(channel, 0.F, 1.F) : 0.5F;
  return out;
}

Mesh to_mesh(const aiMesh& source, const aiMatrix4x4& to_world, const std::string& subject) {
  Mesh mesh;
  mesh.vertices = torch::empty({static_cast<int64_t>(source.mNumVertices), 3});
  float* out = mesh.vertices.data_ptr<float>();
  for (unsigned int i = 0; i < source.mNumVertices; ++i) {
    const aiVector3D p = to_world * source.mVertices[i];
    for (unsigned int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(p[axis])) {
        throw Error(subject,
                    "vertex " + std::to_string(i) + " of mesh '" + one_line(source.mName.C_Str()) + "' is not finite");
      }
      *out++ = p[axis];
    }
  }
  std::vector<int64_t> faces;
  faces.reserve(3UL * source.mNumFaces);
  const bool mirrored = to_world.Determinant() < 0;
  for (unsigned int i = 0; i < source.mNumFaces; ++i) {
    const aiFace& face = source.mFaces[i];
    for (unsigned int corner = 0; corner < face.mNumIndices; ++corner) {
      if (face.mIndices[corner] >= source.mNumVertices) {
        throw Error(subject, "a face names vertex " + std::to_string(face.mIndices[corner]) + " of " +
                                 std::to_string(source.mNumVertices));
      }
      if (corner < 2) continue;
      const int64_t previous = face.mIndices[corner - 1], last = face.mIndices[corner];
      faces.insert(faces.end(), {face.mIndices[0], mirrored ? last : previous, mirrored ? previous : last});
    }
  }
  mesh.faces = torch::tensor(faces, torch::kInt64).view({-1, 3});
  return mesh;
}

/// Gives meshes without a name that of the file, and a number to all but the first of those with one name.
std::vector<Mesh> numbered(std::vector<Mesh> meshes, const std::string& subject) {
  std::map<std::string, int> times;
  for (Mesh& mesh : meshes) {
    if (mesh.name.empty()) mesh.name = std::filesystem::path(subject).stem().string();
    const int before = times[mesh.name]++;
    if (before > 0) mesh.name += "." + std::to_string(before);
  }
  return meshes;
}

std::vector<Mesh> to_meshes(const aiScene* scene, const char* error, const std::string& subject) {
  if (scene == nullptr || scene->mRootNode == nullptr) throw Error(subject, one_line(error));
  std::vector<Mesh> meshes;
  int64_t vertex_count = 0;
  std::vector<std::pair<const aiNode*, aiMatrix4x4>> open{{scene->mRootNode, scene->mRootNode->mTransformation}};
  while (!open.empty()) {
    const auto [node, to_world] = open.back();
    open.pop_back();
    for (unsigned int i = node->mNumChildren; i > 0; --i) {
      open.emplace_back(node->mChildren[i - 1], to_world * node->mChildren[i - 1]->mTransformation);
    }
    for (unsigned int i = 0; i < node->mNumMeshes; ++i) {
      const aiMesh& source = *scene->mMeshes[node->mMeshes[i]];
      if (source.mNumFaces == 0) continue;
      vertex_count += source.mNumVertices;
      if (vertex_count > kMostVertices) throw Error(subject, "has more than 100 million vertices");
      Mesh mesh = to_mesh(source, to_world, subject);
      if (source.mMaterialIndex < scene->mNumMaterials)
        mesh.color = color_of(*scene->mMaterials[source.mMaterialIndex]);
      mesh.name = one_line(node->mName.length > 0 ? node->mName.C_Str() : source.mName.C_Str());
      if (mesh.faces.size(0) > 0) meshes.push_back(std::move(mesh));
    }
  }
  if (meshes.empty()) throw Error(subject, "holds no faces");
  return numbered(std::move(meshes), subject);
}

}  // namespace

std::vector<Mesh> read_meshes(const std::string& path) {
  const std::string extension = extension_of(path);
  const std::string bytes = read_bytes(path);
  if (bytes.empty()) throw Error(path, "is empty");
  if (extension == "obj") {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    return numbered(parse_obj(bytes, path,
                              [&](const std::string& name) {
                                std::error_code failed;
                                const std::filesystem::path file = folder / name;
                                return std::filesystem::is_regular_file(file, failed) ? read_bytes(file.string())
                                                                                      : std::string();
                              }),
                    path);
  }
  if (extension != "gltf") return parse_meshes(bytes, extension, path);
  Assimp::Importer importer;  // by name, for a .gltf has its buffers in files beside it
  set_up(importer);
  try {
    return to_meshes(importer.ReadFile(path, kSteps), importer.GetErrorString(), path);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& failure) {
    throw Error(path, one_line(failure.what()));
  }
}

std::vector<Mesh> parse_meshes(std::string_view bytes, const std::string& extension, const std::string& subject) {
  if (bytes.empty()) throw Error(subject, "is empty");
  if (extension == "ply") return numbered({parse_ply(bytes, subject)}, subject);
  if (extension == "stl") return numbered({parse_stl(bytes, subject)}, subject);
  if (extension == "off") return numbered({parse_off(bytes, subject)}, subject);
  if (extension == "obj")
    return numbered(parse_obj(bytes, subject, [](const std::string&) { return std::string(); }), subject);
  if (extension != "glb" && extension != "gltf")
    throw Error(subject, "'" + extension + "' is no mesh format; known are obj, ply, glb, gltf, off, stl");
  Assimp::Importer importer;
  set_up(importer);
  try {
    return to_meshes(importer.ReadFileFromMemory(bytes.data(), bytes.size(), kSteps, extension.c_str()),
                     importer.GetErrorString(), subject);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& failure) {
    throw Error(subject, one_line(failure.what()));
  }
}

int64_t drop_degenerate_faces(Mesh& mesh) {
  if (mesh.faces.size(0) == 0) return 0;
  const torch::Tensor vertices = mesh.vertices.to(torch::kFloat64);
  const torch::Tensor corners = vertices.index_select(0, mesh.faces.reshape({-1})).view({-1, 3, 3});
  const torch::Tensor normals =
      torch::cross(corners.select(1, 1) - corners.select(1, 0), corners.select(1, 2) - corners.select(1, 0), 1);
  const double size = (std::get<0>(vertices.max(0)) - std::get<0>(vertices.min(0))).norm().item<double>();
  const torch::Tensor keep = normals.norm(2, 1) > 1e-12 * size * size;
  const int64_t dropped = mesh.faces.size(0) - keep.sum().item<int64_t>();
  if (dropped > 0) mesh.faces = mesh.faces.index({keep});
  return dropped;
}

}  // namespace inhabit
