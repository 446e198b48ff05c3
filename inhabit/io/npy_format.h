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
/// allocated. @param pickle set to the bytes of an array of Python objects, where not null. Throws Error(subject, ...).
void read_npy(const ByteSource& source, uint64_t size, const std::string& name, const std::string& subject, Npz& into,
              std::string* pickle = nullptr);

/// What stands before an array's data.
struct NpyHeader {
  std::string descr;           ///< as '<f4'; empty for a structured type
  bool fortran_order = false;  ///< the first index runs fastest
  std::vector<int64_t> shape;  ///< as declared, not yet believed
};

/// Reads the data of an array whose header came in another way (a pickle), as read_npy does.
void read_npy_data(const ByteSource& source, uint64_t size, const NpyHeader& header, const std::string& name,
                   const std::string& subject, Npz& into);

/// Rows [first, first + count) of a .npy file, of which no more is read, called "arr_0"; `count` is cut where the array
/// ends. @param rows set to how many rows the array has. Throws Error(path, ...) as read_npy does, and for an array in
/// Fortran's order.
Npz read_npy_rows(const std::string& path, int64_t first, int64_t count, int64_t* rows = nullptr);

/// The bytes of a .npy file (version 1).
std::string npy_bytes(const torch::Tensor& tensor);
/// The bytes of a .npy file of strings, fixed-width UTF-32 ("<U" and the longest one's length).
std::string npy_bytes(const StringArray& strings);

}  // namespace inhabit
