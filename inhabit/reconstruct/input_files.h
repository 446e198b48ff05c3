#pragma once
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/reconstruct/reconstruct.h"

namespace inhabit::reconstruct {

/// The files that `inhabit reconstruct` is given (docs/reconstruction.md).
struct InputFiles {
  std::string motion;              ///< path of the person's estimated motion, any format of clips that is read
  std::string camera;              ///< path of a camera file (read_camera)
  std::vector<std::string> depth;  ///< patterns of numbered .npy files, or the files (open_depth)
  std::vector<std::string> masks;  ///< patterns of numbered .png files, or the files: where the person is
  std::string objects;             ///< folder of meshes, each named as its object; empty: no objects
  std::string object_masks;        ///< folder of NAME.png or NAME_NUMBER.png; empty as `objects` is
};

/// Opens them. The motion and the camera are read and checked, and what files there are of images and objects; images
/// are read when they are asked for. Throws Error naming the file that is missing, damaged or does not fit.
Inputs open_inputs(const InputFiles& files, const ClipReadOptions& reading, Notes* notes);

}  // namespace inhabit::reconstruct
