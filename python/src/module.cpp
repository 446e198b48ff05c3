#include <ATen/Parallel.h>
#include <c10/util/Exception.h>

#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/version.h"

namespace {

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

PYBIND11_MODULE(_core, m) {
  using namespace inhabit::python;
  m.doc() = "Human motion in 3D scenes.";
  py::register_exception<inhabit::Error>(m, "Error", PyExc_RuntimeError).doc() =
      "What went wrong, with what, and why: one line that names the file or argument.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const c10::Error& e) {  // its further lines are a stack trace
      PyErr_SetString(PyExc_RuntimeError, first_line(e.what_without_backtrace()).c_str());
    }
  });
  m.attr("__version__") = INHABIT_VERSION;
  log_to_python();
  m.def(
      "set_threads",
      [](int count) {
        if (count < 1) throw inhabit::Error("threads", "are fewer than 1");
        at::set_num_threads(count);
      },
      "count"_a, "Sets how many threads the library computes on.");
  m.def(
      "threads", [] { return at::get_num_threads(); }, "How many threads the library computes on.");
  m.def(
      "shipped_model", [](const std::string& name) { return Path(inhabit::shipped_model(name)); }, "name"_a,
      "Path of a model that ships with inhabit, such as 'forecast-compact.safetensors': in $INHABIT_MODELS, beside "
      "the\n"
      "package, or in share/inhabit/models above it.");
  add_clips(m);
  add_scenes(m);
  add_motion(m);  // Body, which files are read with
  add_files(m);
  add_queries(m);
  add_forecast(m);
  add_anticipate(m);
  add_inbetween(m);
  add_interact(m);
  add_refine(m);
  add_reconstruct(m);
  add_score(m);
  add_data(m);
  add_stream(m);
  add_import(m);
  add_synth(m);
  add_train(m);
  add_evaluate(m);
  add_page(m);
  add_serve(m);
  shorten_type_errors(m);
}
