#include "calls.h"
#include "inhabit/forecast/contact_forecaster.h"

namespace inhabit::python {

using forecast::ContactForecaster;
using forecast::Hypothesis;
using ForecastResult = forecast::Result;

void add_forecast(py::module_& m) {
  py::class_<Hypothesis>(m, "ForecastHypothesis",
                         "One of the ways in which the person may go on. World coordinates, metres.")
      .def_readonly("clip", &Hypothesis::prediction, "As ForecastResult.clip.")
      .def_readonly("on_source", &Hypothesis::on_source, "As ForecastResult.on_source.")
      .def_readonly("joints", &Hypothesis::joints, "(T, 22, 3) float32, metres: the joints as the network says.")
      .def_readonly("probability", &Hypothesis::probability, "By the model, among all that it has.");

  py::class_<ForecastResult>(m, "ForecastResult", "What Forecaster.run returns. World coordinates, metres.")
      .def_readonly("past", &ForecastResult::past, "The second that was observed, a Clip on the standard skeleton.")
      .def_readonly("clip", &ForecastResult::prediction,
                    "The prediction, a Clip on the standard skeleton: joints (T, 22, 3), two seconds at 30 Hz.")
      .def_readonly("on_source", &ForecastResult::on_source,
                    "The prediction on the clip's own skeleton, at its rate; empty where standard=True.")
      .def_readonly("hypotheses", &ForecastResult::hypotheses,
                    "Ways to go on, ForecastHypothesis each, likeliest first, where `samples` is over 1.")
      .def_readonly("truth", &ForecastResult::truth, "As many of the T frames as the clip has, a Clip, or None.")
      .def_readonly("scene", &ForecastResult::scene, "What was looked at: the scene given, or an assumed flat floor.")
      .def_readonly("floor_assumed", &ForecastResult::floor_assumed, "Whether a flat floor was assumed.")
      .def_property_readonly(
          "joints", [](const ForecastResult& r) { return r.forecast.joints; },
          "(T, 22, 3) float32, metres: the joints as the network says, feet not cleaned.")
      .def_property_readonly(
          "points", [](const ForecastResult& r) { return r.forecast.points; },
          "(N, 3) float32, metres: the scene points that were looked at.")
      .def_property_readonly(
          "contact_maps", [](const ForecastResult& r) { return r.forecast.contact_maps(); },
          "(P + T, 22, N) float32 predicted contact maps (Eq. 6), 1 where a joint touches a point; made at each "
          "access.")
      .def_property_readonly(
          "contact_points", [](const ForecastResult& r) { return r.forecast.contact_points; },
          "(T, 22, 4) float32: x y z metres, then whether the joint is in contact.");

  py::class_<ContactForecaster, std::shared_ptr<ContactForecaster>>(
      m, "Forecaster",
      "Contact-aware motion forecasting: the second that was observed and a room in, the next two\n"
      "seconds out. Safe to use from several threads.")
      .def(py::init([](const std::optional<Path>& model) {
             const std::string file = model_file(model, "forecast-compact.safetensors");
             return released([&] { return std::make_shared<ContactForecaster>(ContactForecaster::load(file)); });
           }),
           "model"_a = py::none(), "model: a model file; left out, the one that ships.")
      .def_property_readonly(
          "config", [](const ContactForecaster& f) { return python_of(to_json(f.config())).cast<py::dict>(); },
          "The model's configuration.")
      .def(
          "run",
          [](const ContactForecaster& forecaster, const Clip& clip, const std::optional<Scene>& scene,
             std::optional<int64_t> start, int64_t points, uint64_t seed, int64_t samples, bool refine, bool standard,
             const std::string& name) {
            forecast::Options options{start.value_or(-1), points, seed, refine, name, standard};
            options.samples = samples;
            return released([&, clip] { return forecaster.run(clip, scene.value_or(Scene()), options); });
          },
          "clip"_a, "scene"_a = py::none(), py::kw_only(), "start"_a = py::none(), "points"_a = 0, "seed"_a = 1,
          "samples"_a = 1, "refine"_a = true, "standard"_a = false, "name"_a = "motion",
          "Observes the second before frame `start` of a clip (left out, or -1: its end) on any skeleton that maps to "
          "the "
          "standard\n"
          "one, at any rate, and predicts what comes.\n\n"
          "scene: left out, a flat floor under the feet is assumed. points: scene points looked at, 0 as the model "
          "was\n"
          "trained; seed draws them. samples: over 1, so many ways to go on as well. refine: feet stand, nobody is "
          "inside the scene. standard: on_source is not "
          "wanted. name: "
          "what\n"
          "errors call the clip.");
}

}  // namespace inhabit::python
