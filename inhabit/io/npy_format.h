#pragma once
#include <torch/types.h>

#include <functional>
#include <string>
#include <vector>

#include "inhabit/io/npz.h"

namespace inhabit {

/// Reads up to `size` bytes into `to`; returns how many there were.
using ByteSource = std::function<uint64_t(char* to, uint64_t size)>;

/// Reads one array in NumPy's .npy format (versions 1 to 3) and files it under `name` in `into`.
/// @param size bytes that the source claims to have: the array's declared size is checked against it before anything is
/// allocated. Throws Error(subject, ...).
void read_npy(const ByteSource& source, uint64_t size, const std::string& name, const std::string& subject, Npz& into);

/// The bytes of a .npy file (version 1).
std::string npy_bytes(const torch::Tensor& tensor);
std::string npy_bytes(const StringArray& strings);

}  // namespace inhabit
