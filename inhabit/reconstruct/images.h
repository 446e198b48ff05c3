#pragma once
#include <torch/types.h>

#include <functional>
#include <string>
#include <vector>

namespace inhabit::reconstruct {

/// Images of some frames of a recording, read when they are asked for.
struct ImageSequence {
  std::string name;                           ///< pattern of the files, for errors
  std::vector<int64_t> frames;                ///< in order: the motion's frame of each
  bool every_frame = false;                   ///< one image that is good for every frame; `frames` is empty
  std::function<torch::Tensor(size_t)> read;  ///< the i-th; throws Error

  /// Whether there are no images at all.
  bool empty() const { return frames.empty() && !every_frame; }
  /// Which image is of a frame, or -1.
  int64_t index_of(int64_t frame) const;
};

/// A numbered file, "depth_000012.npy".
struct NumberedFile {
  std::string path;    ///< as it is opened
  int64_t number = 0;  ///< in its name; -1: an object's one mask for all frames, which has none
};

/// The files of a shell pattern ("depth_*.npy"; several patterns or files count together) by the number in their names:
/// where names have several, the one in which they differ. Throws Error(pattern, ...) where there is none, or two have
/// one number.
std::vector<NumberedFile> numbered_files(const std::vector<std::string>& patterns);

/// Depth maps, .npy (height, width) or (K, height, width) each, several maps of one frame: read gives (K, height,
/// width) float. The file with number `first` is of frame 0, and lower ones do not count. Reading throws Error(path,
/// ...) for another size and for numbers that are not finite.
ImageSequence open_depth(std::vector<NumberedFile> files, int64_t first, int64_t height, int64_t width);

/// Masks, .png (io/png_mask.h): read gives (height, width) bool.
ImageSequence open_masks(std::vector<NumberedFile> files, int64_t first, int64_t height, int64_t width);

}  // namespace inhabit::reconstruct
