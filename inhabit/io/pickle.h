#pragma once
#include <torch/types.h>

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "inhabit/io/npz.h"

namespace inhabit {

/// A value of a Python pickle.
struct PickleValue {
  /// Python types, and what is met while reading only.
  enum class Kind {
    none,
    boolean,
    whole,  ///< Python's int
    real,   ///< float
    text,   ///< str: UTF-8; of Python 2 its bytes
    bytes,  ///< bytes, bytearray
    list,   ///< also an array of objects, its items in order
    tuple,
    set,
    dict,
    array,    ///< NumPy array of numbers
    texts,    ///< NumPy array of text
    name,     ///< while reading: a global that is allowed
    dtype,    ///< while reading: NumPy's type of items
    storage,  ///< while reading: the numbers that PyTorch's tensors are views of
    pending   ///< while reading: an array without its data
  };
  Kind kind = Kind::none;                 ///< which of the members below counts
  bool boolean = false;                   ///< of a boolean
  int64_t whole = 0;                      ///< of an int
  double real = 0;                        ///< of a float
  std::string text;                       ///< of text and bytes
  std::vector<const PickleValue*> items;  ///< of lists, tuples and sets; of a dict key, value, key, value...
  torch::Tensor array;                    ///< on the CPU, as Npz::tensors
  StringArray texts;                      ///< of a NumPy array of text

  /// The value of a dict's text key; null where there is none, or where this is no dict.
  const PickleValue* find(std::string_view key) const;
};

/// A pickle as read: values are valid as long as it, or a copy of it, lives.
struct Pickle {
  std::string subject;                              ///< the file, for errors
  std::shared_ptr<std::deque<PickleValue>> values;  ///< all of them; the others point into it
  const PickleValue* root = nullptr;                ///< what was pickled

  /// The value of a dict's key, which must be there. Throws Error(subject, ...) saying what is.
  const PickleValue& at(const PickleValue& dict, std::string_view key) const;
  /// A NumPy array, number or list of numbers as float32. Throws Error(subject, ...) naming `what` for anything else.
  torch::Tensor numbers(const PickleValue& value, const std::string& what) const;
  /// at(), and numbers() of it.
  torch::Tensor numbers_at(const PickleValue& dict, const std::string& key) const;
  /// One number of a dict. Throws Error(subject, ...) for more than one and what is not finite.
  double number_at(const PickleValue& dict, const std::string& key) const;
  /// Throws Error(subject, ...) unless it is a text.
  const std::string& text(const PickleValue& value, const std::string& what) const;
};

/// Reads a Python pickle, protocols 0 to 5, also of Python 2: None, numbers, text, bytes, lists, tuples, sets, dicts,
/// NumPy arrays and NumPy numbers, PyTorch's tensors. Nothing is ever executed. Any other class or function is refused
/// by its name, and so are values that contain themselves, whole numbers beyond 64 bits, and what lies deeper than 100
/// values. Throws Error(path, ...). No declared size is believed before it is checked against the file's.
Pickle read_pickle(const std::string& path);

/// The same from memory; `subject` names the source in errors.
Pickle parse_pickle(std::string_view bytes, const std::string& subject);

/// An array of objects in an .npz, such as a dict that was saved with np.savez: its value, or a list of several.
Pickle read_npz_objects(const std::string& path, const std::string& name);

}  // namespace inhabit
