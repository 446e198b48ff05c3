#pragma once
#include <string>
#include <vector>

#include "inhabit/io/read_options.h"
#include "inhabit/reconstruct/reconstruct.h"

namespace inhabit::reconstruct {

/// The files that `inhabit reconstruct` is given (docs/reconstruction.md).
struct InputFiles {
  std::string motion, camera;
  std::vector<std::string> depth, masks;  ///< patterns of numbered files, or the files
  std::string objects, object_masks;      ///< folders; empty: no objects
};

/// Opens them. The motion and the camera are read and checked, and what files there are of images and objects; images
/// are read when they are asked for. Throws Error naming the file that is missing, damaged or does not fit.
Inputs open_inputs(const InputFiles& files, const ClipReadOptions& reading, Notes* notes);

}  // namespace inhabit::reconstruct
