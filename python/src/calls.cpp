#include "calls.h"

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <mutex>

#include "inhabit/error.h"
#include "inhabit/io/shipped_model.h"

namespace inhabit::python {
namespace {

/// Hands log lines to logging.getLogger("inhabit").
class PythonLog : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (Py_IsInitialized() == 0) return;
    const std::string text(message.payload.data(), message.payload.size());
    const bool warning = message.level >= spdlog::level::warn;
    const py::gil_scoped_acquire gil;
    try {
      py::module_::import("logging").attr("getLogger")("inhabit").attr(warning ? "warning" : "info")("%s", text);
    } catch (py::error_already_set& e) {
      e.discard_as_unraisable("logging");
    }
  }
  void flush_() override {}
};

}  // namespace

void check_signals() {
  using Clock = std::chrono::steady_clock;
  thread_local Clock::time_point asked;
  const Clock::time_point now = Clock::now();
  if (now - asked < std::chrono::milliseconds(100)) return;
  asked = now;
  const py::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

std::shared_ptr<py::object> shared_object(const py::object& object) {
  return {new py::object(object), [](py::object* held) {
            if (Py_IsInitialized() == 0) return;
            const py::gil_scoped_acquire gil;
            delete held;
          }};
}

Progress progress_of(const py::object& callback) {
  if (callback.is_none()) return [](int64_t, int64_t) { check_signals(); };
  return [held = shared_object(callback)](int64_t done, int64_t all) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    (*held)(done, all);
  };
}

py::object python_of(const std::string& json) { return py::module_::import("json").attr("loads")(json); }

std::vector<std::string> settings_of(const py::object& settings) {
  if (settings.is_none()) return {};
  if (!py::isinstance<py::dict>(settings)) {
    try {
      return settings.cast<std::vector<std::string>>();
    } catch (const py::cast_error&) {
      throw Error("settings", "are neither a dictionary nor a list of 'KEY=VALUE'");
    }
  }
  std::vector<std::string> out;
  for (const auto& [key, value] : settings.cast<py::dict>()) {
    std::string text =
        py::isinstance<py::bool_>(value) ? (value.cast<bool>() ? "true" : "false") : py::str(value).cast<std::string>();
    out.push_back(py::str(key).cast<std::string>() + "=" + text);
  }
  return out;
}

void say(const Notes& notes) {
  for (const std::string& note : notes)
    py::module_::import("logging").attr("getLogger")("inhabit").attr("info")("%s", note);
}

void log_to_python() {
  auto logger = std::make_shared<spdlog::logger>("inhabit", std::make_shared<PythonLog>());
  spdlog::set_default_logger(std::move(logger));
}

std::vector<std::string> texts_of(const std::vector<Path>& paths) {
  std::vector<std::string> out;
  out.reserve(paths.size());
  for (const Path& path : paths) out.push_back(path.string());
  return out;
}

std::vector<std::string> texts_of(const PathsArgument& paths) {
  const auto* one = std::get_if<Path>(&paths);
  return one != nullptr ? std::vector<std::string>{one->string()} : texts_of(std::get<std::vector<Path>>(paths));
}

std::string model_file(const std::optional<Path>& given, const std::string& shipped) {
  return inhabit::model_file(given ? given->string() : "", shipped);
}

UpAxis up_axis(const std::optional<std::string>& up) {
  if (!up) return UpAxis::automatic;
  if (*up == "y") return UpAxis::y;
  if (*up == "z") return UpAxis::z;
  throw Error("up", "is '" + *up + "', which is none of y, z");
}

ClipReadOptions reading_of(const std::optional<std::string>& up, std::optional<double> scale,
                           std::optional<double> rate, const std::optional<Path>& asf, bool level) {
  ClipReadOptions out;
  out.up = up_axis(up);
  if (scale && !(*scale > 0 && *scale < 1e12)) throw Error("scale", "is not a number over 0");
  if (rate && !(*rate >= 0.1 && *rate <= 1000)) throw Error("rate", "is not in [0.1, 1000]");
  out.scale = scale.value_or(0);
  out.rate = rate.value_or(0);
  if (asf) out.asf = asf->string();
  out.level = level;
  return out;
}

Shard shard_of(const ShardArgument& given) {
  if (!given) return {};
  if (const auto* text = std::get_if<std::string>(&*given)) return text->empty() ? Shard() : parse_shard(*text);
  const auto& [number, of] = std::get<std::pair<int64_t, int64_t>>(*given);
  return parse_shard(std::to_string(number) + "/" + std::to_string(of));
}

}  // namespace inhabit::python
