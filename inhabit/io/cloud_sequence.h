#pragma once
#include <torch/types.h>

#include <functional>
#include <string>

#include "inhabit/io/npz.h"

namespace inhabit {

/// Point clouds of a recording, one a frame, read when they are asked for.
struct CloudSequence {
  std::string name;                            ///< file or folder, for errors
  int64_t frames = 0;                          ///< clouds there are
  std::function<torch::Tensor(int64_t)> read;  ///< (N, 3) float, metres, +Y up, N > 0, finite; throws Error
};

/// How point clouds are to be understood.
struct CloudReadOptions {
  double scale = 1;   ///< metres per unit
  bool z_up = false;  ///< they are rotated by -90 degrees about x, as the motion that they belong to was
};

/// The clouds in a folder or in one .npz.
/// A folder holds a file a frame (.ply .pcd .xyz .npy .npz, see point_cloud.h; other files do not count), all of one
/// extension, their names alike but for one number that goes up by one from each to the next. A file is read when its
/// frame is asked for.
/// An .npz (or .npy, of the first form) holds `points`, (T, N, 3), or (M, 3) with `counts` (T), whole numbers whose sum
/// is M. It is read whole.
/// Throws Error(path, ...) for a missing or damaged file, a gap in the numbers, a frame without a point, and points
/// that are not finite.
CloudSequence open_clouds(const std::string& path, const CloudReadOptions& options = {});

/// The clouds in the arrays of such a file; `subject` names the source in errors.
CloudSequence clouds_from_npz(const Npz& npz, const std::string& subject, const CloudReadOptions& options = {});

}  // namespace inhabit
