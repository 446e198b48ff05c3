#pragma once
#include <array>
#include <string>
#include <vector>

#include "inhabit/body/body_model.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

/// One person in a glTF file.
struct GltfPerson {
  const Clip* clip = nullptr;  ///< with rotations and trans
  /// The skin: one whose joints are the clip's, shaped by clip.betas. Null, or a body with other joints: each bone is
  /// drawn as a thin solid, so that any skeleton shows.
  const BodyModel* body = nullptr;
  std::string name = "person";                      ///< of the node that holds the person
  std::array<float, 3> color{0.24F, 0.43F, 0.72F};  ///< linear RGB
};

/// A binary glTF 2.0 (.glb): each person a skinned mesh over a hierarchy of joint nodes, animated by rotation tracks
/// and translations of the root and of joints that translate (one animation, "motion"); the scene's meshes with names
/// and colours; its points as points. Metres, +Y up, as glTF has it: Blender, Unreal and three.js read it as it is.
/// Faces without normals are drawn flat. Throws Error(subject, ...) where a clip has positions only, or where there is
/// nothing to write.
std::string glb_bytes(const std::vector<GltfPerson>& people, const Scene* scene, const std::string& subject);

/// The same into a file. Throws Error(path, ...).
void write_glb(const std::string& path, const std::vector<GltfPerson>& people, const Scene* scene = nullptr);

}  // namespace inhabit
