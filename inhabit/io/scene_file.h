#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "inhabit/io/up_axis.h"
#include "inhabit/scene/scene.h"

namespace inhabit {

/// How a scene file is to be understood. Left alone, both are detected (see read_scene_file).
struct SceneReadOptions {
  UpAxis up = UpAxis::automatic;  ///< axis of the file that points up
  std::optional<double> scale;    ///< metres per unit of the file, over 0: 0.01 for centimetres
};

/// What was found in a scene file.
struct SceneReport {
  char up = 'y';                 ///< axis of the file that points up
  bool up_detected = false;      ///< found by looking at the scene, neither defined by the format nor given
  double scale = 1.0;            ///< metres per unit of the file
  bool scale_detected = false;   ///< guessed from the scene's size, neither defined by the format nor given
  int64_t meshes = 0;            ///< objects
  int64_t vertices = 0;          ///< of all meshes
  int64_t triangles = 0;         ///< of all meshes, larger faces cut up
  int64_t degenerate = 0;        ///< faces without area, left out
  int64_t points = 0;            ///< of the cloud
  std::array<float, 3> lower{};  ///< corner of the bounding box after conversion, metres
  std::array<float, 3> upper{};  ///< the opposite one
};

/// A scene as read, and what was found out on the way.
struct SceneFile {
  Scene scene;         ///< metres, +Y up
  SceneReport report;  ///< of the file
};

/// A scene from a mesh (.obj .ply .glb .gltf .fbx .dae .off .stl) or point cloud (.ply without faces, .glb of points,
/// .pcd .xyz .npz .npy), in metres with +Y up. glTF is in metres with +Y up by definition; an .fbx
/// says which axis is up, and its unit, which is believed where the scene comes out 0.2 to 300 m long. Elsewhere the up
/// axis (y or z) is the one with a floor: a flat layer across the whole scene at its lower end, and most surface square
/// to it. Where neither axis is clearly better, or where it is no room but a piece of furniture (under 2 m along both),
/// it is +Y for .obj and +Z for the others. The unit is the metre where the scene is then at most 30 m high and 300 m
/// long. Else it is the larger of centimetre and millimetre in which the scene is at most 8 m high and 60 m long, and
/// the metre where neither fits. Feet and inches must be told. A z-up scene is rotated by -90 degrees about x. Throws
/// Error(path, ...) for a file that cannot be read as a scene.
SceneFile read_scene_file(const std::string& path, const SceneReadOptions& options = {});

/// The same from memory; `extension` ("glb") tells the format, files it refers to are not read.
SceneFile parse_scene(std::string_view bytes, const std::string& extension, const std::string& subject,
                      const SceneReadOptions& options = {});

/// True for the extensions ("glb") that read_scene_file knows.
bool is_scene_extension(const std::string& extension);

/// One line for people: "12 meshes, 3402 triangles, 4.20 x 2.50 x 6.10 m; up axis z (detected), unit cm (given)".
std::string describe(const SceneReport& report);

}  // namespace inhabit
