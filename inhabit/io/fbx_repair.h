#pragma once
#include <string>

namespace inhabit {

/// An .fbx file, binary or text, changed where assimp 5.2 reads the format's word otherwise than its makers mean it, as
/// files of MotionBuilder and Unity's standard assets show:
/// - pre- and post-rotation and the order of a joint whose RotationSpaceForLimitOnly is set belong to its limits alone;
/// - the order SphericXYZ rotates as XYZ does;
/// - a post-rotation is undone after the rotation, not done again;
/// - keys outside a take's LocalStart to LocalStop are there as well, as Blender has them.
/// What cannot be followed stays as it is, for assimp to refuse. Throws Error(subject, ...) for versions before 7.0 and
/// an empty file.
std::string repaired_fbx(std::string bytes, const std::string& subject);

}  // namespace inhabit
