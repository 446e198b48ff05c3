#include <mutex>

#include "calls.h"
#include "inhabit/anticipate/anticipate_stream.h"
#include "inhabit/forecast/forecast_stream.h"

namespace inhabit::python {
namespace {

/// A stream that Python's threads may share: the library's may not be shared, and no GIL is held while it works.
template <class Stream>
struct Shared {
  Stream stream;
  std::mutex mutex = {};

  void push(const std::string& person, double time, const Floats& joints) {
    released([&] {
      const std::lock_guard<std::mutex> lock(mutex);
      stream.push(person, time, joints);
    });
  }
  bool due(const std::string& person) {
    return released([&] {
      const std::lock_guard<std::mutex> lock(mutex);
      return stream.due(person);
    });
  }
  auto take() {
    return released([&] {
      const std::lock_guard<std::mutex> lock(mutex);
      return stream.take();
    });
  }
};

using ForecastStream = Shared<forecast::ForecastStream>;
using AnticipateStream = Shared<anticipate::AnticipateStream>;

PoseStreamOptions poses_of(const std::vector<std::string>& names, const std::vector<int>& parents,
                           std::optional<double> rate, double longest_gap, int people, double forget) {
  PoseStreamOptions out{names, parents};
  out.rate = rate.value_or(std::numeric_limits<double>::infinity());
  out.longest_gap = longest_gap;
  out.people = people;
  out.forget = forget;
  return out;
}

constexpr const char* kPush =
    "A pose of somebody: time in seconds, joints (J, 3) in metres, +Y up, in the order of the names. Poses may be "
    "missing,\n"
    "and joints of them (rows of NaN).";
constexpr const char* kPoses =
    "\n\nnames: of the joints that are pushed (left out: the standard 22); parents: of these, -1 for the root (left "
    "out: "
    "told\n"
    "by the names); rate: results a second of each person, None: one for every pose; longest_gap: seconds without a "
    "pose\n"
    "after which a person begins anew; people: at most at once; forget: seconds after which somebody makes room.";

template <class Result>
void add_result(py::module_& m, const char* name, const char* what, const char* result) {
  py::class_<Result>(m, name, what)
      .def_readonly("person", &Result::person, "As push() called them.")
      .def_readonly("time", &Result::time, "Seconds, of the last pose; frame k is (k + 1) / rate later.")
      .def_property_readonly(
          "result", [](const Result& r) { return r.error.empty() ? std::optional(r.result) : std::nullopt; }, result)
      .def_property_readonly(
          "error",
          [](const Result& r) -> std::optional<std::string> {
            return r.error.empty() ? std::nullopt : std::optional(r.error);
          },
          "Why there is none, one line; None where there is one.")
      .def_property_readonly(
          "doubt",
          [](const Result& r) -> std::optional<std::string> {
            return r.doubt.empty() ? std::nullopt : std::optional(r.doubt);
          },
          "Of the first result of a person: why their poses cannot be a person's (another unit, another axis up); else "
          "None.");
}

template <class Stream>
void add_methods(py::class_<Stream>& stream, const char* take) {
  stream.def("push", &Stream::push, "person"_a, "time"_a, "joints"_a, kPush)
      .def("due", &Stream::due, "person"_a, "Whether take() would have something of this person.")
      .def("take", &Stream::take, take);
}

}  // namespace

void add_stream(py::module_& m) {
  add_result<forecast::StreamResult>(
      m, "StreamForecast", "What ForecastStream.take returns, of one person.",
      "A ForecastResult whose joints are (T, 22, 3) in metres, or None. Unless the stream refines, it has no clips: "
      "feet are as the network has them.");
  static const std::string forecast_doc = std::string("Forecasts of people whose joints come in one pose at a time.") +
                                          kPoses +
                                          "\npoints, seed: as Forecaster.run has them. refine: feet stand, nobody "
                                          "is inside the scene, and results have clips; ten times as slow.";
  py::class_<ForecastStream> forecasts(m, "ForecastStream", forecast_doc.c_str());
  forecasts.def(
      py::init([](const std::shared_ptr<forecast::ContactForecaster>& forecaster, const std::optional<Scene>& scene,
                  const std::vector<std::string>& names, const std::vector<int>& parents, std::optional<double> rate,
                  double longest_gap, int people, double forget, int64_t points, uint64_t seed, bool refine) {
        forecast::StreamOptions options;
        options.poses = poses_of(names, parents, rate, longest_gap, people, forget);
        options.forecast.points = points;
        options.forecast.seed = seed;
        options.forecast.joints_alone = !refine;
        return std::unique_ptr<ForecastStream>(
            new ForecastStream{forecast::ForecastStream(forecaster, scene.value_or(Scene()), options)});
      }),
      py::arg("forecaster").none(false), "scene"_a = py::none(), py::kw_only(), "names"_a = std::vector<std::string>(),
      "parents"_a = std::vector<int>(), "rate"_a = 10.0, "longest_gap"_a = 0.5, "people"_a = 100, "forget"_a = 10.0,
      "points"_a = 0, "seed"_a = 1, "refine"_a = false);
  add_methods(forecasts, "The forecasts that are due since the last call, by person: a list of StreamForecast.");

  add_result<anticipate::StreamResult>(m, "StreamFutures", "What AnticipateStream.take returns, of one person.",
                                       "Futures, or None.");
  static const std::string anticipate_doc = std::string("Futures of people whose joints come in one pose at a time.") +
                                            kPoses + "\nsamples, seconds, seed: as Anticipator.run has them.";
  py::class_<AnticipateStream> futures(m, "AnticipateStream", anticipate_doc.c_str());
  futures.def(
      py::init([](const std::shared_ptr<anticipate::IntentionAnticipator>& anticipator,
                  const std::vector<std::string>& names, const std::vector<int>& parents, std::optional<double> rate,
                  double longest_gap, int people, double forget, int64_t samples, double seconds, uint64_t seed) {
        anticipate::StreamOptions options;
        options.poses = poses_of(names, parents, rate, longest_gap, people, forget);
        options.anticipate.samples = samples;
        options.anticipate.seconds = seconds;
        options.anticipate.seed = seed;
        return std::unique_ptr<AnticipateStream>(
            new AnticipateStream{anticipate::AnticipateStream(anticipator, options)});
      }),
      py::arg("anticipator").none(false), py::kw_only(), "names"_a = std::vector<std::string>(),
      "parents"_a = std::vector<int>(), "rate"_a = 2.0, "longest_gap"_a = 0.5, "people"_a = 100, "forget"_a = 10.0,
      "samples"_a = 5, "seconds"_a = 2.0, "seed"_a = 1);
  add_methods(futures, "The futures that are due since the last call, by person: a list of StreamFutures.");
}

}  // namespace inhabit::python
