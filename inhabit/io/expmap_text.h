#pragma once
#include <torch/types.h>

#include <string>
#include <string_view>

#include "inhabit/io/source_motion.h"

namespace inhabit {

// The exponential-map text of the motion-prediction literature: one frame a line, numbers separated by commas (or
// blanks). Column 0-2 is the root's translation, then one exponential map a joint, whose sign is opposite to ours: the
// joint's local rotation is exp(-w).
//   CMU (117 columns): 38 joints, 120 Hz, lengths of the files in ASF units of 0.0564444 m, +Y up, the rest pose faces
//     +Z. The root's columns are absolute. Most files open with one row that is no motion but the rest pose. The data
//     set's skeleton has no bone between Spine1 and Neck (ASF's thorax), so its torso is 0.12 m shorter than the
//     person's.
//   Human3.6M (99 columns): 32 joints, 50 Hz, millimetres. The root's columns are the step from the row before, seen
//     from the root's frame then, so that every file starts at the origin facing +Z, +Y up.

/// Whose skeleton: CMU's of 38 joints or Human3.6M's of 32.
enum class ExpmapSkeleton { cmu, h36m };

/// The data set's skeleton in metres (38 or 32 joints, names of the data sets' own tools).
const Skeleton& expmap_skeleton(ExpmapSkeleton kind);

/// Joint positions (..., J, 3) as the data sets' published loaders give them, for the literature's protocols: the
/// root's six columns are ignored (root at the origin, not rotated), lengths in the data set's own unit: CMU 1/70 ASF
/// unit (x 0.0564444 / 70 = metres), Human3.6M millimetres. Differentiable.
/// @param channels (..., 117) or (..., 99). Throws Error for another size.
torch::Tensor expmap_joint_positions(ExpmapSkeleton kind, const torch::Tensor& channels);

/// All rows of a file as they stand: (T, 117) or (T, 99).
/// Throws Error for anything else, for numbers that are not finite, and for an empty file.
torch::Tensor read_expmap_channels(const std::string& path);
/// As read_expmap_channels, from a file's text.
/// @param name names it in errors
torch::Tensor parse_expmap_channels(std::string_view text, const std::string& name);

/// The motion in metres with its root. A first row at rest (no joint rotated) in a longer CMU file is left out.
/// The notes say so. Joint 0's rest position is the origin, so trans is the root's path.
SourceMotion expmap_motion(const torch::Tensor& channels, const std::string& name);
/// The motion of a file: expmap_motion of read_expmap_channels.
SourceMotion read_expmap_text(const std::string& path);

}  // namespace inhabit
