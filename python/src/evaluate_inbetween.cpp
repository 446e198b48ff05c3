#include "evaluate.h"
#include "inhabit/inbetween/detour.h"
#include "inhabit/inbetween/evaluate.h"
#include "inhabit/inbetween/evaluation_windows.h"
#include "inhabit/inbetween/keyframes.h"
#include "inhabit/io/file_notes.h"
#include "inhabit/io/files.h"
#include "inhabit/io/scene_file.h"
#include "inhabit/io/shipped_model.h"

namespace inhabit::python {
namespace {

using inbetween::Layout;

/// Options of the rows of both evaluations, models not yet among them.
inbetween::MeasuredModels rows_asked(Options& options) {
  inbetween::MeasuredModels out;
  out.options.steps = options.whole("steps", 0, 0, 1000);
  out.options.sampler = named("sampler", options.text("sampler", "dpm"), inbetween::samplers_by_name());
  out.refine = options.flag("refine", true);
  for (const std::string& row : options.texts("row")) out.others.push_back(inbetween::other_settings(row));
  return out;
}

std::optional<std::string> given_text(Options& options, const char* name) {
  const std::string text = options.text(name);
  return text.empty() ? std::nullopt : std::optional(text);
}

std::optional<double> given_number(Options& options, const char* name) {
  const double number = options.number(name, 0, 0, 1e12);
  return number > 0 ? std::optional(number) : std::nullopt;
}

/// Files in place of data.
struct Files {
  std::vector<std::string> motions;
  ClipReadOptions reading;
  std::string scene;
  SceneReadOptions scene_reading;
};

Files files_asked(Options& options) {
  Files out;
  out.motions = options.texts("motion");
  const auto asf = given_text(options, "asf");
  const auto up = given_text(options, "up");
  const auto scale = given_number(options, "scale"), rate = given_number(options, "input_rate");
  out.reading =
      reading_of(up, scale, rate, asf ? std::optional<Path>(*asf) : std::nullopt, options.flag("level", false));
  out.scene = options.text("scene");
  out.scene_reading.up = up_axis(given_text(options, "scene_up"));
  out.scene_reading.scale = given_number(options, "scene_scale");
  return out;
}

std::vector<inbetween::Window> windows_of_files(const Files& files, const inbetween::Config& config, int64_t count,
                                                Notes& notes) {
  Scene scene;
  if (!files.scene.empty()) scene = read_scene_file(files.scene, files.scene_reading).scene;
  std::vector<std::pair<std::string, Clip>> recordings;
  for (const std::string& file : files.motions) {
    Notes own;
    recordings.emplace_back(file, read_clip(file, files.reading, &own));
    add_notes(notes, std::move(own), file);
  }
  return inbetween::windows_of_recordings(recordings, scene, config, count);
}

}  // namespace

Measured inbetween_rows(const Asked& asked, Options& options) {
  const Files files = files_asked(options);
  if (!asked.data.empty() && !files.motions.empty()) throw Error("motion", "is taken in place of data, not beside it");
  inbetween::MeasuredModels models = rows_asked(options);
  models.t_star = options.wholes("t_star", 1, 1000);
  const std::string joints = options.text("joints");
  if (!joints.empty()) models.options.key_groups = inbetween::key_groups(joints);
  const int64_t count = options.whole("windows", 100, 1, std::numeric_limits<int64_t>::max());
  const bool layout_given = options.has("layout");
  const Layout asked_layout = named("layout", options.text("layout", "methods"), inbetween::layouts_by_name());
  if (layout_given && !asked.text) throw Error("layout", "is of the text: ask for it by text=True");
  inbetween::Evaluation how;
  how.keyframes = options.texts("keyframes", how.keyframes);
  how.seeds = options.whole("seeds", how.seeds, 1, 1000);
  how.seed = seed_of(options);
  how.noise = options.number("noise", 0, 0, 90);
  how.key_joints = inbetween::key_joints_of(models.options.key_groups);
  how.tolerance.other = options.number("tolerance", how.tolerance.other, 0, 10);
  how.tolerance.supported = options.number("supported_tolerance", how.tolerance.supported, 0, 10);
  how.truth = options.flag("truth", files.motions.empty()) && files.motions.empty();
  how.against = options.text("against");
  how.progress = asked.progress;
  how.parts = asked.parts;
  options.refuse_others();
  models.networks = asked.networks(&inbetween::load_networks, "inbetween-compact.safetensors");
  const inbetween::Config& config = models.networks.back().second.config;  // windows are as it has them
  const auto methods = inbetween::evaluation_rows(models, how.noise > 0);
  Notes notes;
  const auto windows = files.motions.empty() ? inbetween::windows_of_data(asked.data, asked.split, config, count)
                                             : windows_of_files(files, config, count, notes);
  const auto features = inbetween::load_motion_autoencoder(shipped_model("motion-features.safetensors"));
  const inbetween::Table table = inbetween::evaluate(windows, methods, features, how);
  if (table.rows.empty()) return {};
  const Layout layout = layout_for(table, asked_layout);
  std::string text = table_text(table, layout);
  if (!how.against.empty()) text += "\n" + table_text(table, layout, /*differences=*/true);
  return {table_json(table), text, notes};
}

Measured detour_rows(const Asked& asked, Options& options) {
  inbetween::MeasuredModels models = rows_asked(options);
  const int64_t count = options.whole("rooms", 50, 2, 10000);
  inbetween::DetourEvaluation how;
  how.seeds = options.whole("seeds", how.seeds, 1, 1000);
  how.seed = seed_of(options);
  how.tolerance = options.number("tolerance", how.tolerance, 0, 1);
  how.progress = asked.progress;
  how.parts = asked.parts;
  options.refuse_others();
  models.networks = asked.networks(&inbetween::load_networks, "inbetween-compact.safetensors");
  const inbetween::Config& config = models.networks.back().second.config;
  const auto rooms = inbetween::blocked_rooms((count + 1) / 2, config.frames, config.rate, how.seed);
  const auto scores = inbetween::evaluate_detour(rooms, inbetween::evaluation_rows(models), how);
  return scores.empty() ? Measured() : measured(inbetween::score_table(scores, rooms, how), true);
}

}  // namespace inhabit::python
