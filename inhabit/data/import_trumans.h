#pragma once
#include <string>
#include <vector>

#include "inhabit/data/import_set.h"

namespace inhabit {

/// Rows of TRUMANS' arrays: a stretch of one motion segment in one scene without a frame that is marked as bad.
struct TrumansPiece {
  std::string segment;  ///< name of the recording in seg_name.npy
  int64_t scene = 0;    ///< in scene_list.npy
  int64_t first = 0;    ///< row of the arrays
  int64_t count = 0;    ///< rows
};

/// Pieces of two seconds or more, in order. Throws Error(file, ...).
std::vector<TrumansPiece> trumans_pieces(const std::string& folder);

/// An object of a piece: where it is in each frame, world, +Y up.
struct TrumansObject {
  std::string name;       ///< of its mesh, as object_flag.npy has it
  torch::Tensor pose;     ///< (T, 6) metres, axis-angle
  torch::Tensor at_most;  ///< (4, 4) where it is in the middle of the longest time that it stays
};

/// The objects of rows [first, first + count) by object_flag.npy and object_mat.npy; none where these are missing.
std::vector<TrumansObject> trumans_objects(const std::string& folder, int64_t first, int64_t count);

}  // namespace inhabit
