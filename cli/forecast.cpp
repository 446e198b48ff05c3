#include "inhabit/forecast/forecast_page.h"

#include <filesystem>
#include <memory>

#include "inhabit/io/files.h"
#include "inhabit/io/shipped_model.h"
#include "inputs.h"
#include "outputs.h"
#include "verbs.h"

namespace {

struct ForecastArguments {
  std::string motion, model;
  inhabit::ClipReadOptions reading;
  SceneInput scene;
  std::vector<std::string> outputs;
  inhabit::WriteOptions writing;
  inhabit::forecast::Options forecast;
};

}  // namespace

void add_forecast(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("forecast", "Predict the next two seconds of a person's motion in a scene");
  auto o = std::make_shared<ForecastArguments>();
  verb->add_option("motion", o->motion, "Motion file")->required();
  add_reading(*verb, o->reading);
  add_scene(*verb, o->scene, " (without one, a flat floor is assumed)");
  verb->add_option("--start", o->forecast.start,
                   "First frame to predict, in the file's frames; the second before it is observed (default: the end)")
      ->check(whole_number);
  verb->add_option("--model", o->model, "Model file (default: the one that ships)");
  verb->add_option("--points", o->forecast.points, "Scene points to look at (default: as the model was trained)")
      ->check(CLI::Range(16, 60000));
  verb->add_option("--samples", o->forecast.samples,
                   "How many ways to go on, likeliest first, in place of the one forecast; the model that ships has 5")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--seed", o->forecast.seed, "Seed of the points")->check(whole_number)->capture_default_str();
  verb->add_flag_callback(
      "--no-refine", [o] { o->forecast.refine = false; }, "Leave the motion as the network makes it");
  verb->add_flag("--standard", o->forecast.standard,
                 "Write the standard 22 joints at 30 Hz, not the file's skeleton and rate");
  add_writing(*verb, o->writing);
  add_outputs(*verb, o->outputs,
              "Output files: .npz .bvh .glb .json hold the prediction (of several samples .npz all, the others a file "
              "each), .html is a page (default: forecast.html)");
  verb->callback([o] {
    using namespace inhabit;
    require_motion_outputs(o->outputs, "forecast.html", "a forecast");
    require_motion_written(o->writing, o->outputs);
    o->forecast.standard |= pages_alone(o->outputs);
    Notes notes;
    const Clip clip = read_motion(o->motion, o->reading, notes);
    const Scene scene = read_scene(o->scene, notes);
    const auto forecaster = forecast::ContactForecaster::load(model_file(o->model, "forecast-compact.safetensors"));
    o->forecast.name = o->motion;
    const forecast::Result r = forecaster.run(clip, scene, o->forecast);
    if (r.floor_assumed) notes.emplace_back("no scene given: a flat floor under the feet is assumed");
    say(notes);
    write_outputs(
        o->outputs,
        [&] {
          return forecast::forecast_page(r, "Forecast of " + std::filesystem::path(o->motion).filename().string());
        },
        [&](const std::string& out) {
          std::vector<Clip> motions;
          const auto add = [&](const Clip& standard, const Clip& source) {
            motions.push_back(o->forecast.standard ? standard : source);
          };
          if (r.hypotheses.empty()) add(r.prediction, r.on_source);
          for (const forecast::Hypothesis& one : r.hypotheses) add(one.prediction, one.on_source);
          write_clips(out, motions, o->writing, {}, &r.scene);
          return motions.size();
        });
  });
}
