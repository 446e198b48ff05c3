#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <torch/types.h>

// Arrays cross between Python and LibTorch without copies where types and layout allow it. What comes in is a NumPy
// array, anything with __dlpack__ (PyTorch and JAX tensors), or nested lists of numbers; what goes out is a NumPy array
// over the tensor's own memory, which speaks DLPack itself. An undefined tensor is None.

namespace inhabit::python {

/// An argument that becomes float32, contiguous, on the CPU: the caller's own memory where it is so already.
struct Floats : torch::Tensor {
  Floats() = default;
  explicit Floats(const torch::Tensor& t) : torch::Tensor(t) {}
};

/// The same of int64.
struct Longs : torch::Tensor {
  Longs() = default;
  explicit Longs(const torch::Tensor& t) : torch::Tensor(t) {}
};

/// The tensor over an array's memory, or of a copy where the array is read-only, of another byte order or of a type
/// that LibTorch lacks. False where `source` is no array of numbers.
bool tensor_of(pybind11::handle source, bool convert, torch::Tensor& out);

/// A NumPy array over a tensor's memory, which it keeps alive.
pybind11::object array_of(const torch::Tensor& tensor);

}  // namespace inhabit::python

namespace pybind11::detail {

template <>
struct type_caster<torch::Tensor> {
  PYBIND11_TYPE_CASTER(torch::Tensor, const_name("numpy.ndarray"));
  bool load(handle source, bool convert) { return inhabit::python::tensor_of(source, convert, value); }
  static handle cast(const torch::Tensor& tensor, return_value_policy /*policy*/, handle /*parent*/) {
    return inhabit::python::array_of(tensor).release();
  }
};

template <class Array, torch::ScalarType kType>
struct typed_array_caster {
  bool load(handle source, bool convert) {
    torch::Tensor any;
    if (!inhabit::python::tensor_of(source, convert, any)) return false;
    value = any.defined() ? Array(any.to(kType).contiguous()) : Array();
    return true;
  }
  Array value;
};

template <>
struct type_caster<inhabit::python::Floats> {
  PYBIND11_TYPE_CASTER(inhabit::python::Floats, const_name("numpy.ndarray[float32]"));
  bool load(handle source, bool convert) {
    typed_array_caster<inhabit::python::Floats, torch::kFloat32> typed;
    if (!typed.load(source, convert)) return false;
    value = typed.value;
    return true;
  }
};

template <>
struct type_caster<inhabit::python::Longs> {
  PYBIND11_TYPE_CASTER(inhabit::python::Longs, const_name("numpy.ndarray[int64]"));
  bool load(handle source, bool convert) {
    typed_array_caster<inhabit::python::Longs, torch::kInt64> typed;
    if (!typed.load(source, convert)) return false;
    value = typed.value;
    return true;
  }
};

}  // namespace pybind11::detail
