#include "inhabit/anticipate/train.h"
#include "calls.h"
#include "inhabit/error.h"
#include "inhabit/forecast/train.h"
#include "inhabit/inbetween/train.h"
#include "inhabit/interact/train.h"
#include "inhabit/io/many_files.h"
#include "inhabit/io/safetensors.h"
#include "inhabit/nn/device.h"
#include "inhabit/train/model_mean.h"

namespace inhabit::python {
namespace {

/// A training of `system`: `use(preset, train)` with the functions of that system.
template <class Use>
auto with_system(const std::string& system, const Use& use) {
  if (system == "forecast") return use(forecast::preset, forecast::train);
  if (system == "anticipate")
    return use(anticipate::preset, [](const TrainRun& run, const anticipate::Config& config) {
      Notes notes;
      const bool done = anticipate::train(run, config, &notes);
      const py::gil_scoped_acquire gil;
      say(notes);
      return done;
    });
  if (system == "inbetween") return use(inbetween::preset, inbetween::train);
  if (system == "interact") return use(interact::preset, interact::train);
  if (system == "features") return use(inbetween::preset, inbetween::train_motion_features);
  throw Error("system", "is '" + system + "', which is none of anticipate, features, forecast, inbetween, interact");
}

py::dict python_report(const TrainReport& report) {
  py::dict out("stage"_a = report.stage, "step"_a = report.step, "steps"_a = report.steps,
               "seconds"_a = report.seconds);
  if (report.losses.empty()) {
    out["validation"] = report.validation;
    out["best"] = report.best;
  } else {
    py::dict losses;
    for (const auto& [name, value] : report.losses) losses[name.c_str()] = value;
    out["losses"] = losses;
  }
  return out;
}

/// @param stopped set where the callback says so
TrainListener listener_of(const py::object& callback, bool& stopped) {
  if (callback.is_none()) return {};
  return [held = shared_object(callback), &stopped](const TrainReport& report) {
    const py::gil_scoped_acquire gil;
    const py::object answer = (*held)(python_report(report));
    stopped = stopped || (py::isinstance<py::bool_>(answer) && !answer.cast<bool>());
    return !stopped;
  };
}

bool train_system(const std::string& system, const PathsArgument& data, const Path& out, const std::string& preset_name,
                  const py::object& settings, const std::vector<std::string>& stages, const std::optional<Path>& start,
                  bool resume, bool half, uint64_t seed, const std::string& device, const py::object& callback,
                  int64_t workers, bool last) {
  if (workers < 1 || workers > 256) throw Error("workers", "must be from 1 to 256");
  TrainRun run;
  run.data = folders_matching(texts_of(data));
  run.out = out.string();
  if (start) run.from = start->string();
  run.stages = stages;
  run.resume = resume;
  run.half = half;
  run.seed = seed;
  run.device = nn::device_named(device);
  run.workers = workers;
  run.last = last;
  bool stopped = false;
  run.listener = listener_of(callback, stopped);
  const std::vector<std::string> fields = settings_of(settings);
  const bool done = with_system(system, [&](const auto& preset, const auto& train) {
    auto config = preset(preset_name);
    set_fields(config, fields);
    const py::gil_scoped_release none;
    return train(run, config);
  });
  if (!done && !stopped) {  // the training's own handler took the signal
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw py::error_already_set();
  }
  return done;
}

}  // namespace

void add_train(py::module_& m) {
  m.def(
      "train", &train_system, "system"_a, "data"_a, "out"_a, py::kw_only(), "preset"_a = "compact",
      "settings"_a = py::none(), "stages"_a = std::vector<std::string>(), "start"_a = py::none(), "resume"_a = false,
      "half"_a = false, "seed"_a = 1, "device"_a = "cpu", "callback"_a = py::none(), "workers"_a = 1, "last"_a = false,
      "Trains a system's networks: 'forecast', 'anticipate', 'inbetween', 'interact' or 'features' "
      "(docs/training.md).\n\n"
      "data: folders of native data sets or patterns, or for 'anticipate' one of 'cmu:FOLDER', 'h36m:FOLDER', FOLDER. "
      "out: the "
      "model\n"
      "file, which holds the best weights by validation so far. settings: {'training.batch': 16}. start: a model file "
      "whose\n"
      "weights training starts from. resume: go on from the checkpoint beside `out`. workers: "
      "threads that make batches ahead. last: end\n"
      "with the weights of the last step, not with the best by validation.\n"
      "callback(report) is called every 20 steps with a dictionary of stage, step, steps, seconds and losses, and "
      "after a\n"
      "validation with validation and best in their place; where it returns False, training stops as with Ctrl-C: the\n"
      "checkpoint is written, and resume goes on from it.\n"
      "Returns whether it was finished; Ctrl-C raises KeyboardInterrupt once the checkpoint is there.");
  m.def(
      "preset",
      [](const std::string& system, const std::string& name, const py::object& settings) {
        const std::vector<std::string> fields = settings_of(settings);
        return with_system(system, [&](const auto& preset, const auto& /*train*/) {
          auto config = preset(name);
          set_fields(config, fields);
          return python_of(to_json(config)).template cast<py::dict>();
        });
      },
      "system"_a, "name"_a = "compact", "settings"_a = py::none(),
      "A system's configuration as a dictionary: preset 'compact', or 'paper' where there is one, with settings "
      "changed.");
  m.def(
      "average_models",
      [](const std::vector<Path>& models, const Path& out, std::vector<double> weights, bool half) {
        if (models.size() < 2 && !half) throw Error("models", "one is no mean: name two or more files, or half");
        const std::vector<std::string> files = texts_of(models);
        if (weights.empty()) weights.assign(files.size(), 1);
        released([&] { write_safetensors(out.string(), mean_of_models(files, weights), half); });
      },
      "models"_a, "out"_a, py::kw_only(), "weights"_a = std::vector<double>(), "half"_a = false,
      "Writes the mean of models of one training. weights: how much each counts; half: in half precision.");
}

}  // namespace inhabit::python
