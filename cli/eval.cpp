#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>

#include "inhabit/anticipate/evaluate.h"
#include "inhabit/anticipate/evaluation_folds.h"
#include "inhabit/error.h"
#include "inhabit/interact/evaluate_contacts.h"
#include "inhabit/interact/evaluate_starts.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/nn/used_settings.h"
#include "inputs.h"
#include "interrupted.h"
#include "outputs.h"
#include "progress.h"
#include "settings.h"
#include "verbs.h"
#include "word_kind.h"

namespace {

struct AnticipateOptions {
  std::string data, split = "test", json, shard;
  std::vector<std::string> models, settings;
  inhabit::anticipate::Evaluation evaluation;
};

std::vector<inhabit::anticipate::Fold> folds_of(const AnticipateOptions& o, inhabit::Notes& notes) {
  using namespace inhabit;
  std::vector<std::string> files = o.models;
  if (files.empty() && o.split != "left-out") files = {shipped_model("anticipate-cmu.safetensors")};
  std::vector<std::pair<std::string, anticipate::Networks>> models;
  for (const std::string& file : files) {
    models.emplace_back(file, anticipate::load_networks(model_file(file, "")));
    inhabit::set_used(models.back().second.config, o.settings);
  }
  anticipate::Config config;  // of rows without a model
  inhabit::set_used(config, o.settings);
  return anticipate::evaluation_folds(o.data, o.split, models, config, &notes);
}

void add_eval_anticipate(CLI::App& verb) {
  CLI::App* anticipate = verb.add_subcommand(
      "anticipate",
      "NDMS, NPSS, joint error and diversity of intention-driven anticipation and of what it is compared with");
  auto o = std::make_shared<AnticipateOptions>();
  anticipate->add_option("--data", o->data, "cmu:FOLDER, h36m:FOLDER or a native data set folder")->required();
  anticipate
      ->add_option("--split", o->split,
                   "train, val, test, or left-out: each recording but those of test, of models that were trained "
                   "without it (training.folds); without --model the rows that need no training")
      ->check(CLI::IsMember({"train", "val", "test", "left-out"}))
      ->capture_default_str();
  anticipate->add_option("--model", o->models,
                         "Model file (default: the one that ships); of left-out recordings one for each fold");
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
  anticipate->add_option("--seed", o->evaluation.seed, "Seed of the futures")
      ->check(whole_number)
      ->capture_default_str();
  add_word_kind(*anticipate, o->evaluation.words);
  add_settings(*anticipate, o->settings);
  anticipate->add_option("--json", o->json, "Also write the table as JSON");
  add_evaluation_shard(*anticipate, o->shard);
  anticipate->callback([o, anticipate] {
    using namespace inhabit;
    const std::vector<std::string> folders = folders_matching({o->data});
    if (folders.size() > 1)
      throw Error(o->data, "matches " + std::to_string(folders.size()) + " folders, one is needed");
    o->data = folders.front();
    if (!o->json.empty()) require_writable(o->json);
    const MeasuredParts parts = measured_parts(*anticipate, o->shard, o->json);
    const GoesOnLater later(kept_of(parts));
    Notes notes;
    const std::vector<anticipate::Fold> folds = folds_of(*o, notes);
    o->evaluation.progress = progress_of("rows of observations");
    o->evaluation.parts = parts;
    const anticipate::Table table = anticipate::evaluate(folds, o->evaluation);
    if (!table.whole) return say_part(parts);
    if (table.actions.empty()) throw Error(o->data, "has no recording long enough in split " + o->split);
    if (!o->json.empty()) write_atomically(o->json, table_json(table).dump(1) + "\n");
    parts.remove();
    say(notes);
    std::printf("%s", table_text(table).c_str());
  });
}

struct InteractOptions {
  std::vector<std::string> data, scenes, settings, models;
  std::string split = "test", json, shard;
  int64_t runs = 120, behind = 0, draws = 0;
  double seconds = 16;
  uint64_t seed = 1;
};
using InteractFiles = std::vector<std::pair<std::string, inhabit::interact::Networks>>;

/// Starts all around each chair of scenes; no rows where other parts are still to come.
inhabit::ScoreTable starts_in_scenes(const InteractOptions& o, const InteractFiles& files,
                                     const inhabit::MeasuredParts& parts) {
  using namespace inhabit;
  const auto methods = interact::methods_of(files, o.seconds, {{.raw = true}, {}});
  std::vector<interact::StartSet> sets;
  for (const std::string& file : o.scenes)
    for (interact::StartSet& set : interact::around_chairs(read_scene_file(file).scene, file, o.runs, o.seed))
      sets.push_back(std::move(set));
  return interact::score_table(interact::evaluate_starts(sets, methods, o.seed, progress_of("runs"), parts));
}

/// Starts behind the chairs of a data set, with and without a route planned.
inhabit::ScoreTable starts_behind(const InteractOptions& o, const InteractFiles& files,
                                  const std::vector<inhabit::interact::Trial>& trials,
                                  const inhabit::MeasuredParts& parts) {
  using namespace inhabit;
  const auto methods = interact::methods_of(files, o.seconds, {{.raw = true, .straight = true}, {.raw = true}});
  return interact::score_table(interact::evaluate_starts(
      {{"behind", interact::behind_chairs(trials, o.behind, o.seed)}}, methods, o.seed, progress_of("runs"), parts));
}

void add_eval_interact(CLI::App& verb) {
  CLI::App* interact = verb.add_subcommand(
      "interact", "How near hands come to their contacts, who sits, and how the motion moves, beside the recordings");
  auto o = std::make_shared<InteractOptions>();
  CLI::Option* data = interact->add_option("--data", o->data, "Native data set folders");
  CLI::Option* scenes =
      interact
          ->add_option("--scene", o->scenes,
                       "Instead: scene files; who sits down on each chair in them, from starts all around it")
          ->excludes(data);
  interact->add_option("--split", o->split, "train, val, test or all")
      ->check(CLI::IsMember({"train", "val", "test", "all"}))
      ->capture_default_str();
  interact->add_option(
      "--model", o->models,
      "Model files, each with rows of its own: our networks and baselines (default: the one that ships)");
  interact->add_option("--runs", o->runs, "Starts at most, spread over the split; with --scene for each chair")
      ->check(whole_over_zero)
      ->capture_default_str();
  CLI::Option* behind =
      interact->add_option("--behind", o->behind, "Instead: this many starts behind the chairs; who walks around them")
          ->check(whole_over_zero)
          ->excludes(scenes);
  interact
      ->add_option("--draws", o->draws,
                   "Instead: how far contacts are apart that ContactNet of one model draws on each chair, this many, "
                   "beside the data's")
      ->check(whole_over_zero)
      ->excludes(scenes)
      ->excludes(behind);
  interact->add_option("--seconds", o->seconds, "Length of each run")->check(positive_number)->capture_default_str();
  interact->add_option("--seed", o->seed, "Seed")->check(whole_number)->capture_default_str();
  add_settings(*interact, o->settings);
  interact->add_option("--json", o->json, "Also write the table as JSON");
  add_evaluation_shard(*interact, o->shard);
  interact->callback([o, interact] {
    using namespace inhabit;
    o->data = folders_matching(o->data);
    if (o->data.empty() && o->scenes.empty()) throw Error("eval interact", "needs --data or --scene");
    if (o->draws > 0 && o->models.size() > 1) throw Error("eval interact", "--draws takes one model");
    if (o->draws > 0 && !o->shard.empty()) throw Error("--draws", "takes seconds and has no parts: leave out --shard");
    if (!o->json.empty()) require_writable(o->json);
    const MeasuredParts parts = measured_parts(*interact, o->shard, o->json);
    const GoesOnLater later(kept_of(parts));
    if (o->models.empty()) o->models = {shipped_model("interact-compact.safetensors")};
    InteractFiles files;
    for (const std::string& model : o->models) {
      files.emplace_back(model, interact::load_networks(model_file(model, "")));
      inhabit::set_used(files.back().second.config, o->settings);
    }
    const auto write_table = [&](const ScoreTable& table) {
      if (table.rows.empty()) return say_part(parts);
      if (!o->json.empty()) write_atomically(o->json, rows_json(table, true).dump(1) + "\n");
      parts.remove();
      std::printf("%s", text_of(table, true).c_str());
    };
    if (!o->scenes.empty()) return write_table(starts_in_scenes(*o, files, parts));
    // Contacts are few on each chair: all of the split are taken.
    const int64_t count = o->draws > 0 ? std::numeric_limits<int64_t>::max() : o->runs;
    const std::vector<interact::Trial> trials = interact::trials_of(o->data, o->split, count, o->seconds);
    if (trials.empty()) throw Error(o->data.front(), "has no clip in split " + o->split + " in which somebody sits");
    if (o->behind > 0) return write_table(starts_behind(*o, files, trials, parts));
    if (o->draws > 0)
      return write_table(interact::score_table(
          interact::evaluate_contacts(trials, interact::ChairInteractor(files.front().second), o->draws, o->seed)));
    const interact::Table table = interact::evaluate(
        trials, interact::methods_of(files, o->seconds, {{.raw = true}, {}}), o->seed, progress_of("runs"), parts);
    if (table.rows.empty()) return say_part(parts);
    if (!o->json.empty()) write_atomically(o->json, table_json(table).dump(1) + "\n");
    parts.remove();
    std::printf("%s", table_text(table).c_str());
  });
}

}  // namespace

void add_eval(CLI::App& app) {
  CLI::App* verb = app.add_subcommand("eval", "Measure a system on a data set");
  verb->require_subcommand(1);
  add_eval_forecast(*verb);
  add_eval_contacts(*verb);
  add_eval_anticipate(*verb);
  add_eval_inbetween(*verb);
  add_eval_detour(*verb);
  add_eval_interact(*verb);
  add_eval_reconstruct(*verb);
}
