#pragma once
#include <map>
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/io/write_options.h"
#include "inhabit/motion/clip.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

/// A motion from any file inhabit reads, told by the extension: .bvh, .amc (with the .asf beside it), .txt (exponential
/// maps of CMU and Human3.6M), .fbx, .dae, .glb and .gltf (assimp_motion.h: the first of their motions), .npz and .npy
/// (clip_npz.h), .json (clip_json.h). The skeleton is the file's own.
/// @param notes what was detected or assumed is added to it.
/// Throws Error(path, ...) for a missing or damaged file and for an extension inhabit does not know.
Clip read_clip(const std::string& path, const ClipReadOptions& options = {}, Notes* notes = nullptr);

/// Every motion of a file: the one that read_clip gives, or the samples of an .npz of futures (write_clips_npz), or the
/// people and animations of an .fbx, .dae, .glb or .gltf.
std::vector<Clip> read_clips(const std::string& path, const ClipReadOptions& options = {}, Notes* notes = nullptr);

/// The motions of a file that can be treated as one: all samples of an .npz, which share a skeleton and a length; of
/// other files the first motion alone, as others may be of other skeletons and lengths.
std::vector<Clip> read_samples(const std::string& path, const ClipReadOptions& options = {}, Notes* notes = nullptr);

/// True where read_clip would try the file: known extension, and for .npz, .npy, .fbx, .dae, .glb and .gltf
/// that it holds motion (reads it to see).
bool is_clip_file(const std::string& path);

/// Writes a motion as its extension says: .npz, .json, .bvh or .glb. BVH and glTF need joint rotations: a clip of
/// positions alone is fitted first (retarget). A .glb shows the built-in body where the skeleton is the standard one,
/// else the bones, and `scene` with it; the other formats hold no scene. Throws Error(path, ...) where the file cannot
/// be written or its extension is no motion format.
void write_clip(const std::string& path, const Clip& clip, const Scene* scene = nullptr);

/// The files that write_clips makes of so many motions (and nothing more) at `path`.
std::vector<std::string> clip_files(const std::string& path, size_t motions);

/// Writes motions of one skeleton and length, cut and resampled as `writing` says: several, or with `more`, into one
/// .npz (write_clips_npz), into other formats one file each, NAME_000.bvh and so on; one motion as write_clip does.
/// @param more arrays of an .npz with a row a motion and a column a frame
void write_clips(const std::string& path, const std::vector<Clip>& clips, const WriteOptions& writing = {},
                 const std::map<std::string, torch::Tensor>& more = {}, const Scene* scene = nullptr);

/// Writes a scene as .glb (meshes with names and colours, points) or .ply (one mesh, or the points).
void write_scene(const std::string& path, const Scene& scene);

}  // namespace inhabit
