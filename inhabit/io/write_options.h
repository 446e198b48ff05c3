#pragma once
#include <torch/types.h>

#include <optional>
#include <string>

#include "inhabit/io/up_axis.h"
#include "inhabit/motion/clip.h"

namespace inhabit {

/// How a motion is to stand in the file that it is written to. Left alone, as it is.
struct WriteOptions {
  double from = 0;           ///< seconds from its start that are left out
  std::optional<double> to;  ///< seconds from its start after which it ends
  bool loop = false;         ///< it can be repeated (motion/loop.h, half a second)
  double rate = 0;           ///< frames a second; 0: its own
  /// z for .bvh and .npz alone; automatic: as the file that the motion came from has it.
  UpAxis up = UpAxis::automatic;

  /// Whether anything is asked for.
  bool any() const { return from != 0 || to || loop || rate != 0 || up != UpAxis::automatic; }
};

/// Throws Error naming the option for what no motion could be written as into `path`: a +Z axis in a format that is +Y
/// up, times that leave nothing.
void require_written_as(const WriteOptions& options, const std::string& path);

/// The motion as write_clip is to write it into `path`. Throws Error naming the option, in seconds and frames of the
/// motion, where nothing lies between from and to, or Error(path, ...) where the format is +Y up.
Clip to_be_written(const Clip& clip, const WriteOptions& options, const std::string& path);

/// For each frame of to_be_written the frame of the clip nearest to it: (T) int64.
torch::Tensor frames_written(const Clip& clip, const WriteOptions& options);

}  // namespace inhabit
