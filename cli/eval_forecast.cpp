#include <cstdio>
#include <memory>

#include "inhabit/forecast/evaluate.h"
#include "inhabit/forecast/evaluate_contacts.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/nn/used_settings.h"
#include "inputs.h"
#include "interrupted.h"
#include "outputs.h"
#include "progress.h"
#include "settings.h"
#include "verbs.h"

namespace {

constexpr const char* kIntervalsHelp = "95 % intervals, by bootstrap over windows";

struct ForecastEvaluation {
  std::vector<std::string> data, settings;
  std::string split = "test", model, json, shard;
  int stride = 30;
  bool intervals = false;
};

/// What both verbs are asked for.
std::shared_ptr<ForecastEvaluation> add_options(CLI::App& verb) {
  auto o = std::make_shared<ForecastEvaluation>();
  verb.add_option("--data", o->data, "Native data set folders")->required();
  verb.add_option("--split", o->split, "train, val, test or all")
      ->check(CLI::IsMember({"train", "val", "test", "all"}))
      ->capture_default_str();
  verb.add_option("--model", o->model, "Model file (default: the one that ships)");
  verb.add_option("--stride", o->stride, "Frames from one window to the next")
      ->check(whole_over_zero)
      ->capture_default_str();
  add_settings(verb, o->settings);
  verb.add_option("--json", o->json, "Also write the table as JSON");
  add_evaluation_shard(verb, o->shard);
  return o;
}

inhabit::forecast::Networks model_of(const ForecastEvaluation& o) {
  if (!o.json.empty()) require_writable(o.json);
  inhabit::forecast::Networks model =
      inhabit::forecast::load_networks(inhabit::model_file(o.model, "forecast-compact.safetensors"));
  inhabit::set_used(model.config, o.settings);
  return model;
}

}  // namespace

void add_eval_forecast(CLI::App& verb) {
  CLI::App* forecast =
      verb.add_subcommand("forecast", "Path and pose error of contact-aware forecasting and its baselines");
  const auto o = add_options(*forecast);
  forecast->add_flag("--intervals", o->intervals, kIntervalsHelp);
  forecast->callback([o, forecast] {
    o->data = inhabit::folders_matching(o->data);
    const inhabit::forecast::Networks model = model_of(*o);
    const inhabit::MeasuredParts parts = measured_parts(*forecast, o->shard, o->json);
    const GoesOnLater later(kept_of(parts));
    const inhabit::forecast::Data data(o->data, o->split, model.config, o->stride);
    inhabit::require_any_window(data.windows(), o->data, o->split);
    const inhabit::forecast::Table table = inhabit::forecast::evaluate(model, data, progress_of("windows"), parts);
    if (table.rows.empty()) return say_part(parts);
    if (!o->json.empty()) inhabit::write_atomically(o->json, table_json(table, o->intervals).dump(2) + "\n");
    parts.remove();
    std::printf("%s", table_text(table, o->intervals).c_str());
  });
}

void add_eval_contacts(CLI::App& verb) {
  CLI::App* contacts = verb.add_subcommand(
      "contacts", "Precision and recall of forecast contacts by joint and second, and what L and N cost");
  const auto o = add_options(*contacts);
  contacts->add_flag("--intervals", o->intervals, kIntervalsHelp);
  contacts->callback([o, contacts] {
    o->data = inhabit::folders_matching(o->data);
    const inhabit::forecast::Networks model = model_of(*o);
    const inhabit::MeasuredParts parts = measured_parts(*contacts, o->shard, o->json);
    const GoesOnLater later(kept_of(parts));
    const inhabit::forecast::Data data(o->data, o->split, model.config, o->stride);
    inhabit::require_any_window(data.windows(), o->data, o->split);
    const inhabit::forecast::Data dense(o->data, o->split, inhabit::forecast::dense_config(model.config), o->stride);
    const inhabit::ScoreTable table =
        inhabit::forecast::evaluate_contacts(model, data, dense, progress_of("windows"), parts);
    if (table.rows.empty()) return say_part(parts);
    if (!o->json.empty()) inhabit::write_atomically(o->json, inhabit::rows_json(table, o->intervals).dump(2) + "\n");
    parts.remove();
    std::printf("%s", inhabit::text_of(table, o->intervals).c_str());
  });
}
