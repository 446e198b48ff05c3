#pragma once
#include <torch/types.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace inhabit {

/// An array of text ('U' or 'S' in NumPy), row after row; an empty shape is a single string.
struct StringArray {
  std::vector<int64_t> shape;       ///< empty: a single string
  std::vector<std::string> values;  ///< UTF-8
};

/// What a NumPy archive holds.
struct Npz {
  /// Numbers, on the CPU, in C order, in the type stored: float16/32/64, int8/16/32/64, uint8 and bool. uint16 becomes
  /// int32; uint32 and uint64 become int64.
  std::map<std::string, torch::Tensor> tensors;
  std::map<std::string, StringArray> strings;  ///< text, by name
  /// Entries that cannot be had, and why: object arrays (pickles), structured and complex types, files that are no
  /// arrays.
  std::map<std::string, std::string> skipped;

  /// Whether there are numbers of this name.
  bool has(const std::string& name) const { return tensors.count(name) != 0; }
  /// The tensor called `name`; throws Error(subject, ...) that says what is there instead.
  const torch::Tensor& at(const std::string& name, const std::string& subject) const;
};

/// Reads a .npz archive (stored or deflated, also zip64), or a single .npy array, which is then called "arr_0".
/// @param only names to read, the others are left compressed; empty means all.
/// Throws Error(path, ...) for a file that is missing, no NumPy file, truncated, damaged or that declares more data
/// than it can hold. No declared size is believed before it is checked against the file's.
Npz read_npz(const std::string& path, const std::vector<std::string>& only = {});

/// The same from memory; `subject` names the source in errors.
Npz parse_npz(std::string_view bytes, const std::string& subject, const std::vector<std::string>& only = {});

/// The pickle of an array of Python objects in an .npz archive or .npy file (there "arr_0"), unread (pickle.h).
/// Throws Error(path, ...) as read_npz does, and where `name` is not there or holds none.
std::string npz_pickle(const std::string& path, const std::string& name);

/// Writes .npz (deflated) that NumPy reads. The same content gives the same bytes. Tensors of any strides or device.
void write_npz(const std::string& path, const Npz& content);

/// The bytes that write_npz would write.
std::string npz_bytes(const Npz& content);

/// One array as .npy. Throws Error(path, ...) like write_npz.
void write_npy(const std::string& path, const torch::Tensor& tensor);

}  // namespace inhabit
