#include "arrays.h"

#include <ATen/DLConvertor.h>

#include <optional>

#include "inhabit/error.h"

namespace py = pybind11;

namespace inhabit::python {
namespace {

std::optional<torch::ScalarType> type_of(char kind, py::ssize_t size) {
  switch (kind) {
    case 'b':
      return torch::kBool;
    case 'f':
      if (size == 2) return torch::kFloat16;
      if (size == 4) return torch::kFloat32;
      if (size == 8) return torch::kFloat64;
      return std::nullopt;
    case 'i':
      if (size == 1) return torch::kInt8;
      if (size == 2) return torch::kInt16;
      if (size == 4) return torch::kInt32;
      if (size == 8) return torch::kInt64;
      return std::nullopt;
    case 'u':
      if (size == 1) return torch::kUInt8;
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

/// Lets go of an object, from any thread; at the interpreter's end there is nothing left to let go of.
void release_object(PyObject* object) {
  if (Py_IsInitialized() == 0) return;
  const py::gil_scoped_acquire gil;
  Py_DECREF(object);
}

bool from_numpy(py::array array, torch::Tensor& out) {
  const char kind = array.dtype().kind();
  if (kind == 'u' && array.itemsize() > 1) array = array.attr("astype")("int64");
  if (kind == 'f' && array.itemsize() > 8) array = array.attr("astype")("float64");
  const std::optional<torch::ScalarType> type = type_of(array.dtype().kind(), array.itemsize());
  if (!type) return false;
  bool as_is = array.writeable() && array.dtype().attr("isnative").cast<bool>();
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis)
    as_is = as_is && array.strides(axis) >= 0 && array.strides(axis) % array.itemsize() == 0;
  if (!as_is) array = array.attr("astype")(array.dtype().attr("newbyteorder")("="), "C");
  std::vector<int64_t> sizes, strides;
  for (py::ssize_t axis = 0; axis < array.ndim(); ++axis) {
    sizes.push_back(array.shape(axis));
    strides.push_back(array.strides(axis) / array.itemsize());
  }
  void* data = array.mutable_data();
  PyObject* held = array.release().ptr();
  out = torch::from_blob(
      data, sizes, strides, [held](void*) { release_object(held); }, torch::TensorOptions(*type));
  return true;
}

/// What another library's tensor says of itself by DLPack.
torch::Tensor from_dlpack(py::handle source) {
  const auto device = source.attr("__dlpack_device__")().cast<py::tuple>();
  const int kind = py::int_(device[0]).cast<int>();
  if (kind != kDLCPU && kind != kDLCUDAHost) throw Error("a tensor", "is not in the CPU's memory: move it there first");
  const py::object capsule = source.attr("__dlpack__")();
  auto* managed = static_cast<DLManagedTensor*>(PyCapsule_GetPointer(capsule.ptr(), "dltensor"));
  if (managed == nullptr) throw py::error_already_set();
  torch::Tensor out = at::fromDLPack(managed);
  PyCapsule_SetName(capsule.ptr(), "used_dltensor");  // from now on the tensor lets go of it
  return out;
}

}  // namespace

bool tensor_of(py::handle source, bool convert, torch::Tensor& out) {
  if (source.is_none()) {
    out = torch::Tensor();
    return true;
  }
  if (py::isinstance<py::array>(source)) return from_numpy(py::reinterpret_borrow<py::array>(source), out);
  if (py::hasattr(source, "__dlpack__")) {
    out = from_dlpack(source);
    return true;
  }
  const bool numbers = py::isinstance<py::list>(source) || py::isinstance<py::tuple>(source) ||
                       py::isinstance<py::float_>(source) || py::isinstance<py::int_>(source) ||
                       py::hasattr(source, "__array__");
  if (!convert || !numbers) return false;
  py::object array = py::module_::import("numpy").attr("array")(source);
  return from_numpy(array.cast<py::array>(), out);
}

py::object array_of(const torch::Tensor& tensor) {
  if (!tensor.defined()) return py::none();
  torch::Tensor shown = tensor.detach().to(torch::kCPU);
  if (shown.scalar_type() == torch::kBFloat16) shown = shown.to(torch::kFloat32);
  const char* type = nullptr;
  switch (shown.scalar_type()) {
    case torch::kBool:
      type = "?";
      break;
    case torch::kUInt8:
      type = "u1";
      break;
    case torch::kInt8:
      type = "i1";
      break;
    case torch::kInt16:
      type = "i2";
      break;
    case torch::kInt32:
      type = "i4";
      break;
    case torch::kInt64:
      type = "i8";
      break;
    case torch::kFloat16:
      type = "f2";
      break;
    case torch::kFloat32:
      type = "f4";
      break;
    case torch::kFloat64:
      type = "f8";
      break;
    default:
      throw Error("a tensor", std::string("of type ") + c10::toString(shown.scalar_type()) + " is none of NumPy's");
  }
  std::vector<py::ssize_t> shape, strides;
  for (int64_t axis = 0; axis < shown.dim(); ++axis) {
    shape.push_back(shown.size(axis));
    strides.push_back(shown.stride(axis) * static_cast<int64_t>(shown.element_size()));
  }
  void* data = shown.data_ptr();
  const py::capsule keeper(new torch::Tensor(std::move(shown)),
                           [](void* kept) { delete static_cast<torch::Tensor*>(kept); });
  return py::array(py::dtype(type), std::move(shape), std::move(strides), data, keeper);
}

}  // namespace inhabit::python
