#pragma once
#include <torch/types.h>

#include <string>
#include <string_view>

namespace inhabit {

/// A mask from a PNG image of any kind, (height, width) bool: pixels of which a channel has at least half of the
/// largest value in the image, so that 0 and 1, 0 and 255 and smooth edges are all understood. What is transparent is
/// black. Throws Error(path, ...) for a file that is missing, no PNG, damaged, truncated, or of another size than
/// `height` by `width`, which is checked before pixels are read.
torch::Tensor read_mask_png(const std::string& path, int64_t height, int64_t width);

/// The same from memory; `subject` names the source in errors.
torch::Tensor parse_mask_png(std::string_view bytes, int64_t height, int64_t width, const std::string& subject);

/// The pixels of a PNG image as (height, width, 3) uint8, red first, at most 2^26 of them. What is transparent is
/// black. Throws Error(path, ...) as read_mask_png does.
torch::Tensor read_png(const std::string& path);

/// Writes pixels (height, width, 3) uint8.
void write_png(const std::string& path, const torch::Tensor& pixels);

/// Writes a mask (height, width) as a grey image, 255 where it is set.
void write_mask_png(const std::string& path, const torch::Tensor& mask);

}  // namespace inhabit
