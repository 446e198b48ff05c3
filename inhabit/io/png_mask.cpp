#include "inhabit/io/png_mask.h"

#include <png.h>

#include <memory>

#include "inhabit/error.h"
#include "inhabit/io/atomic_file.h"

namespace inhabit {
namespace {

constexpr uint64_t kLargestPng = uint64_t{1} << 28;  // bytes

/// libpng's plain interface, freed whatever happens.
struct PngImage {
  png_image image{};
  PngImage() { image.version = PNG_IMAGE_VERSION; }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
  ~PngImage() { png_image_free(&image); }
};

}  // namespace

torch::Tensor parse_mask_png(std::string_view bytes, int64_t height, int64_t width, const std::string& subject) {
  PngImage png;
  if (png_image_begin_read_from_memory(&png.image, bytes.data(), bytes.size()) == 0)
    throw Error(subject, std::string("is no PNG image that can be read: ") + png.image.message);
  if (png.image.width != static_cast<uint64_t>(width) || png.image.height != static_cast<uint64_t>(height))
    throw Error(subject, "is " + std::to_string(png.image.width) + " x " + std::to_string(png.image.height) +
                             " pixels, where the camera has " + std::to_string(width) + " x " + std::to_string(height));
  png.image.format = PNG_FORMAT_RGB;
  torch::Tensor pixels = torch::empty({height, width, 3}, torch::kUInt8);
  const png_color black{0, 0, 0};
  if (png_image_finish_read(&png.image, &black, pixels.data_ptr<uint8_t>(), 0, nullptr) == 0)
    throw Error(subject, std::string("is no PNG image that can be read: ") + png.image.message);
  const torch::Tensor brightest = pixels.amax(2);
  const int highest = brightest.max().item<int>();
  return brightest.ge(std::max(1, (highest + 1) / 2));
}

torch::Tensor read_mask_png(const std::string& path, int64_t height, int64_t width) {
  return parse_mask_png(read_whole_file(path, kLargestPng), height, width, path);
}

void write_mask_png(const std::string& path, const torch::Tensor& mask) {
  const torch::Tensor grey = (mask.to(torch::kUInt8) * 255).contiguous();
  PngImage png;
  png.image.format = PNG_FORMAT_GRAY;
  png.image.height = static_cast<png_uint_32>(grey.size(0));
  png.image.width = static_cast<png_uint_32>(grey.size(1));
  png_alloc_size_t size = 0;
  std::string bytes;
  if (png_image_write_to_memory(&png.image, nullptr, &size, 0, grey.data_ptr<uint8_t>(), 0, nullptr) != 0) {
    bytes.resize(size);
    if (png_image_write_to_memory(&png.image, bytes.data(), &size, 0, grey.data_ptr<uint8_t>(), 0, nullptr) != 0)
      return write_atomically(path, std::string_view(bytes).substr(0, size));
  }
  throw Error(path, std::string("cannot be written: ") + png.image.message);
}

}  // namespace inhabit
