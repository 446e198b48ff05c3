#pragma once
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "arrays.h"
#include "inhabit/data/shard.h"
#include "inhabit/interruption.h"
#include "inhabit/io/read_options.h"
#include "inhabit/progress.h"

namespace inhabit::python {

namespace py = pybind11;
using namespace py::literals;
using Path = std::filesystem::path;   ///< str or os.PathLike
using Point = std::array<double, 3>;  ///< (x, y, z)

/// Throws what Python's Ctrl-C (or another signal's handler) raises, where one came. Asks ten times a second at most.
void check_signals();

/// Long work without the GIL. Ctrl-C ends it at its next interruption point, or, where it has none, as soon as it is
/// done.
template <class Work>
auto released(Work&& work) {
  const py::gil_scoped_release none;
  const Interruptible here(check_signals);
  return work();
}

/// A Python function, or None, as what library code calls from any thread, without the GIL. What it raises ends the
/// work, and so does Ctrl-C.
Progress progress_of(const py::object& callback);

/// A Python object that is copied and let go of in any thread, without the GIL.
std::shared_ptr<py::object> shared_object(const py::object& object);

/// Dictionaries, lists and numbers of JSON.
py::object python_of(const std::string& json);

/// "training.batch=16" of {"training.batch": 16}, or a list of such texts as it is.
std::vector<std::string> settings_of(const py::object& settings);

/// Lines that the library would print for people go to Python's logger "inhabit".
void say(const Notes& notes);
void log_to_python();

/// Paths as the library takes them.
std::vector<std::string> texts_of(const std::vector<Path>& paths);
/// A path or several.
using PathsArgument = std::variant<Path, std::vector<Path>>;
std::vector<std::string> texts_of(const PathsArgument& paths);

/// A given model's file, of those that ship by its name too, or `shipped`.
std::string model_file(const std::optional<Path>& given, const std::string& shipped);

/// "up", "scale", "rate", "asf" and "level" of Python as reading options.
ClipReadOptions reading_of(const std::optional<std::string>& up, std::optional<double> scale,
                           std::optional<double> rate, const std::optional<Path>& asf, bool level = false);
UpAxis up_axis(const std::optional<std::string>& up);

/// Part I of N: (I, N), "I/N", or None for all of it.
using ShardArgument = std::optional<std::variant<std::string, std::pair<int64_t, int64_t>>>;
Shard shard_of(const ShardArgument& given);

/// Has functions of the module, and of its classes, say of wrong arguments in one line what they take and were given.
void shorten_type_errors(const py::module_& m);

// Each adds its part of the module.
void add_clips(py::module_& m);
void add_scenes(py::module_& m);
void add_files(py::module_& m);
void add_queries(py::module_& m);
void add_motion(py::module_& m);
void add_forecast(py::module_& m);
void add_anticipate(py::module_& m);
void add_inbetween(py::module_& m);
void add_interact(py::module_& m);
void add_refine(py::module_& m);
void add_reconstruct(py::module_& m);
void add_score(py::module_& m);
void add_data(py::module_& m);
void add_synth(py::module_& m);
void add_train(py::module_& m);
void add_evaluate(py::module_& m);
void add_page(py::module_& m);
void add_stream(py::module_& m);
void add_serve(py::module_& m);
void add_import(py::module_& m);

}  // namespace inhabit::python
