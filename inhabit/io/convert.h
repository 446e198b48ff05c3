#pragma once
#include <optional>
#include <string>

#include "inhabit/io/read_options.h"

namespace inhabit {

/// How a file becomes one of another format.
struct ConvertOptions {
  ClipReadOptions reading;  ///< of the input, `up` and `scale` of a scene too
  UpAxis up = UpAxis::y;    ///< of the output; z for .bvh and .npz of motion
  double rate = 0;          ///< frames a second of the output; 0: as they are
  bool retarget = false;    ///< onto the standard 22 joints
  std::string scene;        ///< file of a scene that a .glb holds beside the motion; empty: none
  std::string body;         ///< SMPL, SMPL-H or SMPL-X model file (.npz) for motions of that family
};

/// Writes a motion or a scene in another format, told by the extensions (files.h, scene_file.h).
/// @param notes what was detected or assumed is added to it. Returns one line for people that says what was written.
/// Throws Error naming the file that cannot be read or written, or that the options do not go with.
std::string convert_file(const std::string& in, const std::string& out, const ConvertOptions& options,
                         Notes* notes = nullptr);

}  // namespace inhabit
