#include <cstdio>
#include <memory>

#include "inhabit/error.h"
#include "inhabit/inbetween/detour.h"
#include "inhabit/inbetween/evaluate.h"
#include "inhabit/inbetween/evaluation_windows.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/nn/used_settings.h"
#include "inputs.h"
#include "interrupted.h"
#include "outputs.h"
#include "progress.h"
#include "sampler_option.h"
#include "settings.h"
#include "verbs.h"

namespace {

using namespace inhabit;
using inbetween::Layout;

/// The models that are measured, and what is done with them.
struct ModelRows {
  std::vector<std::string> models, settings, rows;
  inbetween::MeasuredModels measured;
};

void add_model_rows(CLI::App& verb, ModelRows& o) {
  verb.add_option("--model", o.models, "Model files, rows each (default: the one that ships)");
  verb.add_option("--steps", o.measured.options.steps, "Evaluations of the denoiser (default: the model's own)")
      ->check(CLI::Range(1, 1000));
  add_sampler(verb, o.measured.options.sampler);
  add_settings(verb, o.settings);
  verb.add_option(
          "--row", o.rows,
          "More rows of the same models with other settings, 'NAME: KEY=VALUE ...', such as "
          "'guidance 0: inference.guidance=0'; detours=searched or detours=straight: how the baseline goes around "
          "obstacles; temperature=1: the course is left to the seed; may be repeated")
      ->check(not_empty);
  verb.add_flag_callback(
      "--no-refine", [&o] { o.measured.refine = false; },
      "Leave away the interpolations after the refinement that ours has");
}

/// Reads the models. Windows are as the last one's configuration has them.
inbetween::Config read_models(ModelRows& o) {
  if (o.models.empty()) o.models.push_back(shipped_model("inbetween-compact.safetensors"));
  for (const std::string& file : o.models) {
    o.measured.networks.emplace_back(file, inbetween::load_networks(model_file(file, "")));
    set_used(o.measured.networks.back().second.config, o.settings);
  }
  for (const std::string& row : o.rows) o.measured.others.push_back(inbetween::other_settings(row));
  return o.measured.networks.back().second.config;
}

struct InbetweenOptions {
  std::vector<std::string> data, motions;
  SceneInput scene;
  ClipReadOptions reading;
  std::string split = "test", json, joints, shard;
  int64_t windows = 100;
  ModelRows rows;
  Layout layout = Layout::methods;
  inbetween::Evaluation evaluation;
};

std::vector<inbetween::Window> windows_of_files(const InbetweenOptions& o, const inbetween::Config& config,
                                                Notes& notes) {
  const Scene scene = read_scene(o.scene, notes);
  std::vector<std::pair<std::string, Clip>> recordings;
  for (const std::string& file : o.motions) recordings.emplace_back(file, read_motion(file, o.reading, notes));
  return inbetween::windows_of_recordings(recordings, scene, config, o.windows);
}

void eval_inbetween(InbetweenOptions& o) {
  if (o.data.empty() == o.motions.empty()) throw Error("eval inbetween", "needs either --data or --motion");
  if (!o.json.empty()) require_writable(o.json);
  if (!o.motions.empty()) o.evaluation.truth = false;
  inbetween::MeasuredModels& models = o.rows.measured;
  if (!o.joints.empty()) models.options.key_groups = inbetween::key_groups(o.joints);
  o.evaluation.key_joints = inbetween::key_joints_of(models.options.key_groups);
  const inbetween::Config config = read_models(o.rows);
  const auto methods = inbetween::evaluation_rows(models, o.evaluation.noise > 0);
  Notes notes;
  const auto windows = o.motions.empty() ? inbetween::windows_of_data(o.data, o.split, config, o.windows)
                                         : windows_of_files(o, config, notes);
  const inbetween::MotionAutoencoder features =
      inbetween::load_motion_autoencoder(shipped_model("motion-features.safetensors"));
  o.evaluation.progress = progress_of("windows filled");
  const inbetween::Table table = inbetween::evaluate(windows, methods, features, o.evaluation);
  if (table.rows.empty()) return say_part(o.evaluation.parts);
  if (!o.json.empty()) write_atomically(o.json, table_json(table).dump(1) + "\n");
  o.evaluation.parts.remove();
  say(notes);
  const Layout layout = layout_for(table, o.layout);
  std::printf("%s", table_text(table, layout).c_str());
  if (!o.evaluation.against.empty()) std::printf("\n%s", table_text(table, layout, /*differences=*/true).c_str());
}

}  // namespace

void add_eval_inbetween(CLI::App& verb) {
  CLI::App* inbetween = verb.add_subcommand(
      "inbetween", "Frechet distance, foot skating, jerk, joint error and collisions of scene-aware in-betweening");
  auto o = std::make_shared<InbetweenOptions>();
  CLI::Option* data = inbetween->add_option("--data", o->data, "Native data set folders");
  inbetween->add_option("--motion", o->motions, "Instead: motion files, such as noisy recordings; implies --no-truth")
      ->excludes(data);
  add_scene(*inbetween, o->scene, " (with --motion; default: a flat floor)");
  add_reading(*inbetween, o->reading, "--motion");
  inbetween->add_option("--split", o->split, "train, val, test or all")
      ->check(CLI::IsMember({"train", "val", "test", "all"}))
      ->capture_default_str();
  add_model_rows(*inbetween, o->rows);
  inbetween
      ->add_option("--keyframes", o->evaluation.keyframes,
                   "every:N, a list, random:P or ends; several are rows of Table 6")
      ->capture_default_str();
  inbetween
      ->add_option("--joints", o->joints,
                   "Joints that the keys between the ends constrain, such as pelvis,left_wrist; MPJE Key is over these "
                   "(default: whole poses)")
      ->check(not_empty);
  inbetween->add_option("--noise", o->evaluation.noise, "Level of noise on the key frames: so many degrees and cm")
      ->check(CLI::Range(0.0, 90.0));
  inbetween->add_flag_callback(
      "--no-truth", [o] { o->evaluation.truth = false; },
      "The recordings are noisy themselves: only what needs no truth is measured (Table 4)");
  inbetween->add_option("--tolerance", o->evaluation.tolerance.other, "Metres that skin may be inside the scene")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  inbetween
      ->add_option("--supported-tolerance", o->evaluation.tolerance.supported,
                   "The same of skin that carries weight: of pelvis, thighs, spine, forearms and hands")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  inbetween->add_option("--windows", o->windows, "Windows at most, spread over the split")
      ->check(whole_over_zero)
      ->capture_default_str();
  inbetween
      ->add_option("--t-star", o->rows.measured.t_star,
                   "T* of noise-aware models, rows each (default: the one of training)")
      ->check(CLI::Range(1, 1000));
  inbetween->add_option("--seeds", o->evaluation.seeds, "Runs with different seeds")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  inbetween->add_option("--seed", o->evaluation.seed, "First seed")->check(whole_number)->capture_default_str();
  inbetween
      ->add_option("--against", o->evaluation.against,
                   "Row that differences are taken from, window by window: a second table")
      ->check(not_empty);
  inbetween
      ->add_option("--layout", o->layout,
                   "Columns: methods (Tables 1, 3), close (2), recordings (4), keys (6), settings (8), seeds (9), "
                   "collisions (with and without tolerance)")
      ->transform(one_of(inbetween::layouts_by_name()))
      ->option_text("NAME");
  inbetween->add_option("--json", o->json, "Also write the table as JSON");
  add_evaluation_shard(*inbetween, o->shard);
  inbetween->callback([o, inbetween] {
    o->data = folders_matching(o->data);
    o->evaluation.parts = measured_parts(*inbetween, o->shard, o->json);
    const GoesOnLater later(kept_of(o->evaluation.parts));
    eval_inbetween(*o);
  });
}

void add_eval_detour(CLI::App& verb) {
  struct Options {
    ModelRows rows;
    int64_t rooms = 50;
    std::string json, shard;
    inbetween::DetourEvaluation evaluation;
  };
  CLI::App* detour = verb.add_subcommand(
      "detour", "In-betweening with furniture in the straight line between the keys: who goes around, whole bodies");
  auto o = std::make_shared<Options>();
  add_model_rows(*detour, o->rows);
  detour->add_option("--rooms", o->rooms, "Rooms, each second one the mirror image of the one before")
      ->check(CLI::Range(2, 10000))
      ->capture_default_str();
  detour->add_option("--seeds", o->evaluation.seeds, "Runs with different seeds in each room")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  detour->add_option("--seed", o->evaluation.seed, "Seed of rooms and runs")
      ->check(whole_number)
      ->capture_default_str();
  detour->add_option("--tolerance", o->evaluation.tolerance, "Metres that skin may be inside what is in the way")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  detour->add_option("--json", o->json, "Also write the table as JSON");
  add_evaluation_shard(*detour, o->shard);
  detour->callback([o, detour] {
    if (!o->json.empty()) require_writable(o->json);
    const MeasuredParts parts = measured_parts(*detour, o->shard, o->json);
    const GoesOnLater later(kept_of(parts));
    o->evaluation.parts = parts;
    const inbetween::Config config = read_models(o->rows);
    const std::vector<inbetween::Method> methods = inbetween::evaluation_rows(o->rows.measured);
    const auto rooms = inbetween::blocked_rooms((o->rooms + 1) / 2, config.frames, config.rate, o->evaluation.seed);
    o->evaluation.progress = progress_of("runs");
    const auto scores = inbetween::evaluate_detour(rooms, methods, o->evaluation);
    if (scores.empty()) return say_part(parts);
    const ScoreTable table = inbetween::score_table(scores, rooms, o->evaluation);
    if (!o->json.empty()) write_atomically(o->json, rows_json(table, true).dump(1) + "\n");
    parts.remove();
    std::printf("%s", text_of(table, true).c_str());
  });
}
