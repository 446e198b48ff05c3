#include "inhabit/io/assimp_scene.h"

#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <cmath>

#include "inhabit/error.h"
#include "inhabit/io/cbor_numbers.h"
#include "inhabit/io/fbx_repair.h"
#include "inhabit/io/in_child.h"
#include "inhabit/io/weld.h"

namespace inhabit {
namespace {

using nlohmann::json;

constexpr size_t kMostNodeCorners = 300'000'000;
constexpr int kDeepestNode = 2000;  // nodes below each other

/// What a child hands over: the triangles below a node.
struct NodeMeshes {
  const aiScene& scene;
  const std::string& subject;
  json out = json::array(), skinned = json::array();
  size_t corners = 0;

  void node(const aiNode& at, const aiMatrix4x4& above, int depth) {
    if (depth > kDeepestNode) throw Error(subject, "its nodes lie too deep below each other");
    const aiMatrix4x4 to_world = above * at.mTransformation;
    for (unsigned m = 0; m < at.mNumMeshes; ++m) mesh(*scene.mMeshes[at.mMeshes[m]], at, to_world);
    for (unsigned k = 0; k < at.mNumChildren; ++k) node(*at.mChildren[k], to_world, depth + 1);
  }

  void mesh(const aiMesh& mesh, const aiNode& at, const aiMatrix4x4& to_world) {
    std::vector<float> vertices;
    std::vector<int64_t> faces;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D p = to_world * mesh.mVertices[v];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        throw Error(subject, "vertex " + std::to_string(v) + " of a mesh is not finite");
      vertices.insert(vertices.end(), {p.x, p.y, p.z});
    }
    const bool mirrored = to_world.Determinant() < 0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // lines and points
      for (const int corner : {0, mirrored ? 2 : 1, mirrored ? 1 : 2}) {
        if (face.mIndices[corner] >= mesh.mNumVertices) throw Error(subject, "a face names a vertex that is not there");
        faces.push_back(face.mIndices[corner]);
      }
    }
    corners += faces.size();
    if (corners > kMostNodeCorners) throw Error(subject, "unfolds to more than 100 million triangles");
    if (faces.empty()) return;
    json one = {{"name", at.mName.length > 0 ? at.mName.C_Str() : mesh.mName.C_Str()},
                {"vertices", bytes_of(vertices)},
                {"faces", bytes_of(faces)}};
    aiColor4D color;
    if (mesh.mMaterialIndex < scene.mNumMaterials &&
        scene.mMaterials[mesh.mMaterialIndex]->GetTextureCount(aiTextureType_DIFFUSE) == 0 &&
        scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_COLOR_DIFFUSE, color) == AI_SUCCESS)
      one["color"] = {color.r, color.g, color.b};
    (mesh.HasBones() ? skinned : out).push_back(std::move(one));
  }
};

/// What an .fbx says of its axes and units: the letter of the axis that is up, and metres of a unit; 0 where it does
/// not.
json fbx_axes(const aiScene& scene) {
  int up = -1, sign = 0;
  float centimetres = 0;
  if (scene.mMetaData != nullptr) {
    scene.mMetaData->Get("UpAxis", up);
    scene.mMetaData->Get("UpAxisSign", sign);
    scene.mMetaData->Get("UnitScaleFactor", centimetres);
  }
  const bool known = sign > 0 && (up == 1 || up == 2);
  return {known ? (up == 1 ? 'y' : 'z') : 0, centimetres > 0 && std::isfinite(centimetres) ? centimetres / 100.0 : 0.0};
}

}  // namespace

std::vector<Mesh> parse_node_meshes(std::string_view bytes, const std::string& extension, const std::string& subject,
                                    MeshAxes* axes) {
  const std::string cbor = in_child(subject, [&] {
    Assimp::Importer importer;
    const std::string fbx = extension == "fbx" ? repaired_fbx(std::string(bytes), subject) : std::string();
    const std::string_view read = fbx.empty() ? bytes : fbx;
    const aiScene* scene = importer.ReadFileFromMemory(
        read.data(), read.size(), aiProcess_Triangulate | aiProcess_ValidateDataStructure, extension.c_str());
    if (scene == nullptr || scene->mRootNode == nullptr)
      throw Error(subject, std::string("cannot be read: ") + importer.GetErrorString());
    NodeMeshes collector{*scene, subject};
    collector.node(*scene->mRootNode, aiMatrix4x4(), 0);
    const std::vector<uint8_t> out = json::to_cbor(
        {{"meshes", collector.out.empty() ? collector.skinned : collector.out}, {"axes", fbx_axes(*scene)}});
    return std::string(out.begin(), out.end());
  });
  std::vector<Mesh> meshes;
  const json all = json::from_cbor(cbor);
  if (axes != nullptr) *axes = {static_cast<char>(all["axes"][0].get<int>()), all["axes"][1].get<double>()};
  for (const json& one : all["meshes"]) {
    Mesh mesh = weld(numbers_of<float>(one["vertices"]), numbers_of<int64_t>(one["faces"]));
    mesh.name = one["name"].get<std::string>();
    if (one.contains("color"))
      for (size_t c = 0; c < 3; ++c)
        if (const auto value = one["color"][c].get<float>(); std::isfinite(value))
          mesh.color[c] = std::clamp(value, 0.0F, 1.0F);
    meshes.push_back(std::move(mesh));
  }
  if (meshes.empty()) throw Error(subject, "holds no faces, and no skeleton in it moves");
  return meshes;
}

}  // namespace inhabit
