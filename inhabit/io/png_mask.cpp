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

void begin(PngImage& png, std::string_view bytes, const std::string& subject) {
  if (png_image_begin_read_from_memory(&png.image, bytes.data(), bytes.size()) == 0)
    throw Error(subject, std::string("is no PNG image that can be read: ") + png.image.message);
}

/// (height, width, 3) uint8.
torch::Tensor pixels_of(PngImage& png, const std::string& subject) {
  png.image.format = PNG_FORMAT_RGB;
  torch::Tensor pixels = torch::empty({png.image.height, png.image.width, 3}, torch::kUInt8);
  const png_color black{0, 0, 0};
  if (png_image_finish_read(&png.image, &black, pixels.data_ptr<uint8_t>(), 0, nullptr) == 0)
    throw Error(subject, std::string("is no PNG image that can be read: ") + png.image.message);
  return pixels;
}

void write_pixels(const std::string& path, const torch::Tensor& given, png_uint_32 format) {
  const torch::Tensor pixels = given.to(torch::kUInt8).contiguous();
  PngImage png;
  png.image.format = format;
  png.image.height = static_cast<png_uint_32>(pixels.size(0));
  png.image.width = static_cast<png_uint_32>(pixels.size(1));
  png_alloc_size_t size = 0;
  std::string bytes;
  if (png_image_write_to_memory(&png.image, nullptr, &size, 0, pixels.data_ptr<uint8_t>(), 0, nullptr) != 0) {
    bytes.resize(size);
    if (png_image_write_to_memory(&png.image, bytes.data(), &size, 0, pixels.data_ptr<uint8_t>(), 0, nullptr) != 0)
      return write_atomically(path, std::string_view(bytes).substr(0, size));
  }
  throw Error(path, std::string("cannot be written: ") + png.image.message);
}

}  // namespace

torch::Tensor parse_mask_png(std::string_view bytes, int64_t height, int64_t width, const std::string& subject) {
  PngImage png;
  begin(png, bytes, subject);
  if (png.image.width != static_cast<uint64_t>(width) || png.image.height != static_cast<uint64_t>(height))
    throw Error(subject, "is " + std::to_string(png.image.width) + " x " + std::to_string(png.image.height) +
                             " pixels, where the camera has " + std::to_string(width) + " x " + std::to_string(height));
  const torch::Tensor pixels = pixels_of(png, subject);
  const torch::Tensor brightest = pixels.amax(2);
  const int highest = brightest.max().item<int>();
  return brightest.ge(std::max(1, (highest + 1) / 2));
}

torch::Tensor read_mask_png(const std::string& path, int64_t height, int64_t width) {
  return parse_mask_png(read_whole_file(path, kLargestPng), height, width, path);
}

torch::Tensor read_png(const std::string& path) {
  constexpr uint64_t kMostPixels = uint64_t{1} << 26;
  const std::string bytes = read_whole_file(path, kLargestPng);
  PngImage png;
  begin(png, bytes, path);
  if (uint64_t{png.image.width} * png.image.height > kMostPixels) throw Error(path, "has more than 2^26 pixels");
  return pixels_of(png, path);
}

void write_png(const std::string& path, const torch::Tensor& pixels) { write_pixels(path, pixels, PNG_FORMAT_RGB); }

void write_mask_png(const std::string& path, const torch::Tensor& mask) {
  write_pixels(path, mask.to(torch::kUInt8) * 255, PNG_FORMAT_GRAY);
}

}  // namespace inhabit
