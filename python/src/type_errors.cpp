#include <sstream>
#include <utility>

#include "calls.h"

namespace inhabit::python {
namespace {

/// What pybind11 calls all of its functions by.
PyCFunctionWithKeywords dispatcher = nullptr;

std::string type_name(py::handle value) {
  const std::string name = Py_TYPE(value.ptr())->tp_name;
  return name.rfind("inhabit._core.", 0) == 0 ? "inhabit." + name.substr(14) : name;
}

/// "read_clip(path: os.PathLike, *, up: Optional[str] = None) was given (int, up: str)", from pybind11's message, which
/// is a line of each signature ("    1. (path: ...) -> Clip") between one that names the function and what was given.
std::string in_one_line(const std::string& message, const py::handle& given, const py::handle& named) {
  std::string out, name = message.substr(0, message.find("()"));
  std::istringstream lines(message.substr(message.find('\n') + 1));
  for (std::string line; std::getline(lines, line) && line.rfind("    ", 0) == 0;) {
    std::string takes = line.substr(line.find(". ") + 2);
    takes = takes.substr(0, takes.rfind(") -> ") + 1);  // of constructors all: rfind() + 1 is npos + 1
    if (takes.empty()) takes = line.substr(line.find(". ") + 2);
    out += (out.empty() ? "" : " or ") + (takes.front() == '(' ? name + takes : takes);
  }
  for (size_t at; (at = out.find("inhabit._core.")) != std::string::npos;) out.replace(at, 14, "inhabit.");
  std::string got;
  bool itself = message.find("(): incompatible constructor") != std::string::npos;  // comes first
  for (const py::handle value : given)
    if (!std::exchange(itself, false)) got += (got.empty() ? "" : ", ") + type_name(value);
  if (named)
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(named))
      got += (got.empty() ? "" : ", ") + py::str(key).cast<std::string>() + ": " + type_name(value);
  return out + " was given (" + got + ")";
}

PyObject* call(PyObject* self, PyObject* given, PyObject* named) {
  PyObject* out = dispatcher(self, given, named);
  if (out != nullptr || PyErr_ExceptionMatches(PyExc_TypeError) == 0) return out;
  py::error_already_set error;  // takes it
  const std::string message = py::str(error.value()).cast<std::string>();
  if (message.find("(): incompatible ") == std::string::npos || message.find('\n') == std::string::npos)
    error.restore();
  else
    PyErr_SetString(PyExc_TypeError, in_one_line(message, given, named).c_str());
  return nullptr;
}

void shorten(const py::handle& member);

void shorten_all(const py::handle& members) {
  for (const py::handle member : members.attr("values")()) shorten(member);
}

void shorten(const py::handle& member) {
  PyObject* function = member.ptr();
  if (PyType_Check(function) != 0) return shorten_all(member.attr("__dict__"));
  if (py::isinstance(member, reinterpret_cast<PyObject*>(&PyProperty_Type))) {
    for (const char* accessor : {"fget", "fset"}) shorten(member.attr(accessor));
    return;
  }
  if (PyInstanceMethod_Check(function) != 0) function = PyInstanceMethod_GET_FUNCTION(function);
  if (PyCFunction_Check(function) == 0 || PyCapsule_CheckExact(PyCFunction_GET_SELF(function)) == 0) return;
  PyMethodDef& method = *reinterpret_cast<PyCFunctionObject*>(function)->m_ml;  // pybind11 made it for this function
  const auto own = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&call));
  if (method.ml_meth == own) return;
  dispatcher = reinterpret_cast<PyCFunctionWithKeywords>(reinterpret_cast<void (*)()>(method.ml_meth));
  method.ml_meth = own;
}

}  // namespace

void shorten_type_errors(const py::module_& m) { shorten_all(m.attr("__dict__")); }

}  // namespace inhabit::python
