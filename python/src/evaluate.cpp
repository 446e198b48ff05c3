#include "evaluate.h"

#include <map>

#include "inhabit/anticipate/evaluation_folds.h"
#include "inhabit/forecast/evaluate.h"
#include "inhabit/forecast/evaluate_contacts.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/many_files.h"
#include "inhabit/reconstruct/evaluate.h"

namespace inhabit::python {
namespace {

constexpr int64_t kMost = std::numeric_limits<int64_t>::max();

Measured forecast_rows(const Asked& asked, Options& options) {
  const int64_t stride = options.whole("stride", 30, 1, kMost);
  const bool intervals = options.flag("intervals", false);
  options.refuse_others();
  const auto model = asked.network(&forecast::load_networks, "forecast-compact.safetensors");
  const forecast::Data data(asked.data, asked.split, model.config, stride);
  require_any_window(data.windows(), asked.data, asked.split);
  const forecast::Table table = forecast::evaluate(model, data, asked.progress, asked.parts);
  if (table.rows.empty()) return {};
  return {table_json(table, intervals), table_text(table, intervals)};
}

Measured contacts_rows(const Asked& asked, Options& options) {
  const int64_t stride = options.whole("stride", 30, 1, kMost);
  options.refuse_others();
  const auto model = asked.network(&forecast::load_networks, "forecast-compact.safetensors");
  const forecast::Data data(asked.data, asked.split, model.config, stride);
  require_any_window(data.windows(), asked.data, asked.split);
  const forecast::Data dense(asked.data, asked.split, forecast::dense_config(model.config), stride);
  return measured(forecast::evaluate_contacts(model, data, dense, asked.progress, asked.parts), false);
}

Measured anticipate_rows(const Asked& asked, Options& options) {
  if (asked.data.size() != 1) throw Error("data", "is one set of recordings: 'cmu:FOLDER', 'h36m:FOLDER' or FOLDER");
  anticipate::Evaluation how;
  how.samples = options.whole("samples", how.samples, 1, 10000);
  how.windows = options.whole("windows", how.windows, 1, 100000);
  how.seconds = options.number("seconds", how.seconds, 0.4, 30);
  how.seed = seed_of(options);
  how.words = named("words", options.text("words", "poses"), word_kinds_by_name());
  how.progress = asked.progress;
  how.parts = asked.parts;
  options.refuse_others();
  // Recordings that are left out need models that were trained without them; rows that need no training, none.
  std::vector<std::pair<std::string, anticipate::Networks>> models;
  if (!asked.models.empty() || asked.split != "left-out")
    models = asked.networks(&anticipate::load_networks, "anticipate-cmu.safetensors");
  anticipate::Config config;
  set_used(config, asked.settings);
  const anticipate::Table table =
      anticipate::evaluate(anticipate::evaluation_folds(asked.data.front(), asked.split, models, config), how);
  if (!table.whole) return {};
  if (table.actions.empty()) throw asked.nothing("recording long enough");
  return {table_json(table), table_text(table)};
}

Measured reconstruct_rows(const Asked& asked, Options& options) {
  reconstruct::Evaluation how;
  how.rooms = options.whole("rooms", how.rooms, 1, 10000);
  how.seed = seed_of(options);
  how.seconds = options.number("seconds", how.seconds, 1, 600);
  how.render.width = options.whole("width", how.render.width, 32, 4096);
  how.render.height = how.render.width * 3 / 4;
  how.render.errors.maps = options.whole("maps", how.render.errors.maps, 1, 16);
  how.render.errors.noise = options.number("noise", how.render.errors.noise, 0, 1);
  how.render.errors.warp = options.number("warp", how.render.errors.warp, 0, 1);
  how.options.floor_scale = options.flag("floor_scale", true);
  how.objects = options.flag("objects", true);
  how.keep = options.text("keep");
  how.progress = asked.progress;
  how.parts = asked.parts;
  options.refuse_others();
  const auto [file, model] = asked.networks(&inbetween::load_networks, "inbetween-noisy.safetensors").front();
  asked.one_model();
  inbetween::require_noise_aware(model.config, file);
  const auto rooms = reconstruct::evaluate(inbetween::SceneInbetweener(model), how);
  return rooms.empty() ? Measured() : measured(reconstruct::table_of(rooms), false);
}

/// The part that is asked for, kept beside the table.
MeasuredParts parts_of(const ShardArgument& shard, const std::optional<Path>& table, const nlohmann::json& job) {
  if (!shard) return {};
  if (!table) throw Error("shard", "needs json: parts are kept beside the table");
  return {shard_of(shard), table->string(), job.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)};
}

using Rows = Measured (*)(const Asked& asked, Options& options);

Rows rows_of(const std::string& system) {
  static const std::map<std::string, Rows> systems = {{"anticipate", anticipate_rows},  {"contacts", contacts_rows},
                                                      {"detour", detour_rows},          {"forecast", forecast_rows},
                                                      {"inbetween", inbetween_rows},    {"interact", interact_rows},
                                                      {"reconstruct", reconstruct_rows}};
  return named("system", system, systems);
}

py::object evaluate_system(const std::string& system, const PathsArgument& data, const std::string& split,
                           const std::optional<PathsArgument>& model, const py::object& settings, bool text,
                           const ShardArgument& shard, const std::optional<Path>& table, const py::object& progress,
                           const py::kwargs& others) {
  const Rows rows = rows_of(system);
  Options options(system, others);
  Asked asked;
  asked.data = folders_matching(texts_of(data));
  asked.split = split;
  if (model) asked.models = texts_of(*model);
  asked.settings = settings_of(settings);
  asked.text = text;
  asked.progress = progress_of(progress);
  asked.parts = parts_of(shard, table,
                         {{"python", system},
                          {"data", asked.data},
                          {"split", split},
                          {"model", asked.models},
                          {"settings", asked.settings},
                          {"options", options.dump()}});
  const bool own_rooms = system == "detour" || system == "reconstruct";
  const bool other_data = (system == "interact" && options.has("scene")) || options.has("motion");
  if (!asked.data.empty() && own_rooms) throw Error("data", "is of no use: '" + system + "' makes its own rooms");
  if (asked.data.empty() && !own_rooms && !other_data) throw Error("data", "is missing");
  const Measured found = released([&] { return rows(asked, options); });
  say(found.notes);
  if (found.table.is_null()) return py::none();
  if (table) write_atomically(table->string(), found.table.dump(1) + "\n");
  asked.parts.remove();
  return text ? py::str(found.text) : python_of(found.table.dump());
}

}  // namespace

uint64_t seed_of(Options& options) { return static_cast<uint64_t>(options.whole("seed", 1, 0, kMost)); }

Measured measured(const ScoreTable& table, bool intervals) {
  if (table.rows.empty()) return {};
  return {rows_json(table, intervals), text_of(table, intervals)};
}

void add_evaluate(py::module_& m) {
  m.def(
      "evaluate", &evaluate_system, "system"_a, "data"_a = std::vector<Path>(), py::kw_only(), "split"_a = "test",
      "model"_a = py::none(), "settings"_a = py::none(), "text"_a = false, "shard"_a = py::none(),
      "json"_a = py::none(), "progress"_a = py::none(),
      "The table of a system beside its baselines, as `inhabit eval` writes it to --json: lists and dictionaries.\n\n"
      "system: 'forecast', 'contacts', 'anticipate', 'inbetween', 'interact', or 'detour' and 'reconstruct', which "
      "make\n"
      "their own rooms. data: folders of native data sets or patterns; for 'anticipate' one of 'cmu:FOLDER',\n"
      "'h36m:FOLDER', FOLDER. split: 'train', 'val', 'test' or 'all', of 'anticipate' 'left-out' too. model: a model "
      "file\n"
      "instead of the one that ships; several have rows each. settings: how it is used, {'inference.guidance': 0}.\n"
      "text: the table as the command prints it, instead. json: a file that it is written to, too. shard: (I, N) for "
      "part\n"
      "I of N, for several processes: parts are kept beside `json`, and the last of them gives and writes the table; "
      "None\n"
      "before. progress(done, all) is called now and then.\n\n"
      "Further options are those of the command (`inhabit eval SYSTEM --help`):\n"
      "forecast: stride (30 frames from one window to the next), intervals (False: 95 % of the means)\n"
      "contacts: stride\n"
      "anticipate: samples (50 futures of each observation), windows (8 of each action), seconds (30, the longest\n"
      "    horizon), seed, words ('poses', 'dlow' or 'package')\n"
      "inbetween: windows (100 at most), keyframes ('every:60', or a list), joints (those that keys constrain), noise "
      "(0,\n"
      "    degrees and cm), truth (True; False: recordings are noisy themselves), t_star, seeds (1), seed, against "
      "(the\n"
      "    row that differences are taken from), layout (columns of the text: 'methods', 'close', 'recordings', "
      "'keys',\n"
      "    'settings', 'seeds' or 'collisions'), tolerance (0.01 metres) and supported_tolerance (0.04: of skin that "
      "carries\n"
      "    weight), and in place of data: motion (files), scene (a file), up, scale,\n"
      "    input_rate, level, asf, scene_up, scene_scale\n"
      "detour: rooms (50), seeds (10 runs in each), seed, tolerance (0.02 metres)\n"
      "inbetween and detour: row (further rows, 'NAME: KEY=VALUE ...'), steps, sampler, refine (True: interpolations "
      "are\n"
      "    refined, too)\n"
      "interact: runs (120), seconds (16, the length of each), seed, behind (starts behind chairs), draws (of "
      "ContactNet),\n"
      "    and in place of data: scene (files; starts around each of their chairs)\n"
      "reconstruct: rooms (10), seconds (6), seed, width (pixels), maps (depth maps of a frame), noise, warp (parts of "
      "the\n"
      "    depth), floor_scale (True), objects (True), keep (folder for the first room's files)");
}

}  // namespace inhabit::python
