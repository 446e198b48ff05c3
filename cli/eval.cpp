#include <cstdio>
#include <memory>

#include "inhabit/anticipate/evaluate.h"
#include "inhabit/error.h"
#include "inhabit/forecast/evaluate.h"
#include "inhabit/io/atomic_file.h"
#include "models.h"
#include "outputs.h"
#include "verbs.h"

namespace {

void add_eval_forecast(CLI::App& verb) {
  struct Options {
    std::vector<std::string> data;
    std::string split = "test", model, json;
    int stride = 30;
  };
  CLI::App* forecast =
      verb.add_subcommand("forecast", "Path and pose error of contact-aware forecasting and its baselines");
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

void add_eval_anticipate(CLI::App& verb) {
  struct Options {
    std::string data, split = "test", model, json;
    inhabit::AnticipateEvaluation evaluation;
  };
  CLI::App* anticipate = verb.add_subcommand(
      "anticipate",
      "NDMS, NPSS, joint error and diversity of intention-driven anticipation and of what it is compared with");
  auto o = std::make_shared<Options>();
  anticipate->add_option("--data", o->data, "cmu:FOLDER, h36m:FOLDER or a native data set folder")->required();
  anticipate->add_option("--split", o->split, "train, val or test")
      ->check(CLI::IsMember({"train", "val", "test"}))
      ->capture_default_str();
  anticipate->add_option("--model", o->model, "Model file (default: the one that ships)");
  anticipate->add_option("--samples", o->evaluation.samples, "Futures of each observation")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  anticipate->add_option("--windows", o->evaluation.windows, "Observations of each action")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  anticipate->add_option("--seconds", o->evaluation.seconds, "Longest horizon")
      ->check(positive_number)
      ->check(CLI::Range(0.4, 30.0))
      ->capture_default_str();
  anticipate->add_option("--seed", o->evaluation.seed, "Seed of the futures")->capture_default_str();
  anticipate->add_option("--json", o->json, "Also write the table as JSON");
  anticipate->callback([o] {
    using namespace inhabit;
    if (!o->json.empty()) require_writable(o->json);
    const AnticipateNetworks networks =
        load_anticipate_networks(o->model.empty() ? shipped_model("anticipate-cmu.safetensors") : o->model);
    Notes notes;
    const auto sequences =
        anticipate_sequences(read_motion_set(o->data, networks.config.rate, &notes), o->split, networks.skeleton);
    const AnticipateTable table = evaluate_anticipate(networks, sequences, o->evaluation);
    if (table.actions.empty()) throw Error(o->data, "has no recording long enough in split " + o->split);
    if (!o->json.empty()) write_atomically(o->json, table_json(table).dump(1) + "\n");
    for (const std::string& note : notes) std::printf("%s\n", note.c_str());
    std::printf("%s", table_text(table).c_str());
  });
}

}  // namespace

void add_eval(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("eval", "Measure a system on a data set");
  verb->require_subcommand(1);
  add_eval_forecast(*verb);
  add_eval_anticipate(*verb);
}
