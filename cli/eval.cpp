#include <cstdio>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/forecast/evaluate.h"
#include "inhabit/io/atomic_file.h"
#include "models.h"
#include "outputs.h"
#include "verbs.h"

void add_eval(CLI::App& app) {
  struct Options {
    std::vector<std::string> data;
    std::string split = "test", model, json;
    int stride = 30;
  };
  CLI::App* verb = app.add_subcommand("eval", "Measure a system on a data set");
  verb->require_subcommand(1);
  CLI::App* forecast =
      verb->add_subcommand("forecast", "Path and pose error of contact-aware forecasting and its baselines");
  auto o = std::make_shared<Options>();
  forecast->add_option("--data", o->data, "Native data set folders")->required();
  forecast->add_option("--split", o->split, "train, val, test or all")
      ->check(CLI::IsMember({"train", "val", "test", "all"}))
      ->capture_default_str();
  forecast->add_option("--model", o->model, "Model file (default: the one that ships)");
  forecast->add_option("--stride", o->stride, "Frames from one window to the next")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  forecast->add_option("--json", o->json, "Also write the table as JSON");
  forecast->callback([o] {
    if (!o->json.empty()) require_writable(o->json);
    const inhabit::ForecastNetworks model =
        inhabit::load_forecast_networks(o->model.empty() ? shipped_model("forecast-compact.safetensors") : o->model);
    const inhabit::ForecastData data(o->data, o->split, model.config, o->stride);
    if (data.size() == 0)
      throw inhabit::Error(o->data.front(), "has no window of " + std::to_string(model.config.frames()) +
                                                " frames in split " + o->split);
    const inhabit::ForecastTable table = inhabit::evaluate_forecast(model, data);
    if (!o->json.empty()) inhabit::write_atomically(o->json, inhabit::table_json(table).dump(2) + "\n");
    std::printf("%s", inhabit::table_text(table).c_str());
  });
}
