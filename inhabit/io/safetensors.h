#pragma once
#include <torch/types.h>

#include <map>
#include <string>

namespace inhabit {

/// What a .safetensors file holds: named tensors and a map of strings (a model's config travels there as JSON).
struct SafeTensors {
  std::map<std::string, torch::Tensor> tensors;  ///< by name, on the CPU
  std::map<std::string, std::string> metadata;   ///< "__metadata__" of the header
};

/// Reads a whole file. Element types F64, F32, F16, BF16, I64, I32, I16, I8, U8 and BOOL keep their type.
/// Throws Error naming the file where the header is malformed, or a tensor's place lies outside the file, overlaps
/// another or disagrees with its shape. Nothing is allocated before sizes are checked against the file's size.
SafeTensors read_safetensors(const std::string& path);

/// Only the metadata: reads the header, no tensor.
std::map<std::string, std::string> read_safetensors_metadata(const std::string& path);

/// Writes to a temporary beside `path` and renames it.
/// @param half store float32 and float64 tensors as F16 (half the size, three significant digits).
void write_safetensors(const std::string& path, const SafeTensors& content, bool half = false);

}  // namespace inhabit
