#include "inhabit/forecast/evaluate.h"

#include <functional>
#include <map>

#include "calls.h"
#include "inhabit/anticipate/evaluation_folds.h"
#include "inhabit/data/measured_parts.h"
#include "inhabit/error.h"
#include "inhabit/forecast/evaluate_contacts.h"
#include "inhabit/inbetween/detour.h"
#include "inhabit/inbetween/evaluate.h"
#include "inhabit/inbetween/evaluation_windows.h"
#include "inhabit/interact/evaluate.h"
#include "inhabit/io/atomic_file.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/nn/used_settings.h"
#include "inhabit/reconstruct/evaluate.h"

namespace inhabit::python {
namespace {

using Texts = std::vector<std::string>;

/// What `evaluate` of every system is asked for.
struct Asked {
  Texts data;
  std::string split;
  std::optional<Path> model;
  Texts settings;
  int64_t windows, seeds, stride;
  uint64_t seed;
  Progress progress;
  MeasuredParts parts;

  template <class Networks>
  Networks networks(Networks (*load)(const std::string&), const std::string& shipped) const {
    Networks out = load(model_file(model, shipped));
    set_used(out.config, settings);
    return out;
  }
  Error nothing(const std::string& what) const {
    return Error(data.empty() ? "data" : data.front(), "has no " + what + " in split " + split);
  }
};

/// A table as text; empty where other parts are still to come.
template <class Table, class ToJson>
std::string rows_text(const Table& table, const ToJson& json) {
  return table.rows.empty() ? std::string() : json(table).dump();
}

std::string forecast_rows(const Asked& asked) {
  const auto model = asked.networks(&forecast::load_networks, "forecast-compact.safetensors");
  const forecast::Data data(asked.data, asked.split, model.config, asked.stride);
  require_any_window(data.windows(), asked.data, asked.split);
  return rows_text(forecast::evaluate(model, data, asked.progress, asked.parts),
                   [](const forecast::Table& t) { return table_json(t); });
}

std::string anticipate_rows(const Asked& asked, int64_t samples, double seconds) {
  if (asked.data.size() != 1) throw Error("data", "is one set of recordings: 'cmu:FOLDER', 'h36m:FOLDER' or FOLDER");
  const auto model = asked.networks(&anticipate::load_networks, "anticipate-cmu.safetensors");
  anticipate::Evaluation how;
  how.samples = samples;
  how.seconds = seconds;
  how.seed = asked.seed;
  if (asked.windows > 0) how.windows = asked.windows;
  how.progress = asked.progress;
  how.parts = asked.parts;
  const anticipate::Table table = anticipate::evaluate(
      anticipate::evaluation_folds(asked.data.front(), asked.split,
                                   {{model_file(asked.model, "anticipate-cmu.safetensors"), model}}),
      how);
  if (!table.whole) return {};
  if (table.actions.empty()) throw asked.nothing("recording long enough");
  return table_json(table).dump();
}

std::string inbetween_rows(const Asked& asked, const Texts& keyframes, double noise, bool refine) {
  const auto model = asked.networks(&inbetween::load_networks, "inbetween-compact.safetensors");
  const auto windows =
      inbetween::windows_of_data(asked.data, asked.split, model.config, asked.windows > 0 ? asked.windows : 100);
  const auto methods = inbetween::evaluation_rows({.networks = {{"", model}}, .refine = refine}, noise > 0);
  inbetween::Evaluation how;
  how.keyframes = keyframes;
  how.seeds = asked.seeds;
  how.seed = asked.seed;
  how.noise = noise;
  how.progress = asked.progress;
  how.parts = asked.parts;
  const auto features = inbetween::load_motion_autoencoder(shipped_model("motion-features.safetensors"));
  return rows_text(inbetween::evaluate(windows, methods, features, how),
                   [](const inbetween::Table& t) { return table_json(t); });
}

std::string interact_rows(const Asked& asked, double seconds) {
  const auto model = asked.networks(&interact::load_networks, "interact-compact.safetensors");
  const auto trials = interact::trials_of(asked.data, asked.split, asked.windows > 0 ? asked.windows : 120, seconds);
  if (trials.empty()) throw asked.nothing("clip in which somebody sits");
  const auto methods = interact::methods_of({{"", model}}, seconds, {{.raw = true}, {}});
  return rows_text(interact::evaluate(trials, methods, asked.seed, asked.progress, asked.parts),
                   [](const interact::Table& t) { return table_json(t); });
}

std::string contacts_rows(const Asked& asked) {
  const auto model = asked.networks(&forecast::load_networks, "forecast-compact.safetensors");
  const forecast::Data data(asked.data, asked.split, model.config, asked.stride);
  require_any_window(data.windows(), asked.data, asked.split);
  const forecast::Data dense(asked.data, asked.split, forecast::dense_config(model.config), asked.stride);
  return rows_text(forecast::evaluate_contacts(model, data, dense, asked.progress, asked.parts),
                   [](const ScoreTable& t) { return rows_json(t); });
}

std::string detour_rows(const Asked& asked, bool refine) {
  const auto model = asked.networks(&inbetween::load_networks, "inbetween-compact.safetensors");
  const auto methods = inbetween::evaluation_rows({.networks = {{"", model}}, .refine = refine});
  inbetween::DetourEvaluation how;
  how.seeds = asked.seeds;
  how.seed = asked.seed;
  how.progress = asked.progress;
  how.parts = asked.parts;
  const auto rooms = inbetween::blocked_rooms(((asked.windows > 0 ? asked.windows : 50) + 1) / 2, model.config.frames,
                                              model.config.rate, asked.seed);
  const auto scores = inbetween::evaluate_detour(rooms, methods, how);
  return scores.empty() ? std::string() : rows_json(inbetween::score_table(scores, rooms, how), true).dump();
}

std::string reconstruct_rows(const Asked& asked, double seconds) {
  const inbetween::SceneInbetweener inbetweener(
      asked.networks(&inbetween::load_networks, "inbetween-noisy.safetensors"));
  reconstruct::Evaluation how;
  if (asked.windows > 0) how.rooms = asked.windows;
  how.seed = asked.seed;
  how.seconds = seconds;
  how.progress = asked.progress;
  how.parts = asked.parts;
  const auto rooms = reconstruct::evaluate(inbetweener, how);
  return rooms.empty() ? std::string() : rows_json(reconstruct::table_of(rooms)).dump();
}

/// The part that is asked for, kept beside the table.
MeasuredParts parts_of(const ShardArgument& shard, const std::optional<Path>& table, const nlohmann::json& job) {
  if (!shard) return {};
  if (!table) throw Error("shard", "needs json: parts are kept beside the table");
  return {shard_of(shard), table->string(), job.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)};
}

py::object evaluate_system(const std::string& system, const std::variant<std::string, Texts>& data,
                           const std::string& split, const std::optional<Path>& model, const py::object& settings,
                           std::optional<int64_t> windows, std::optional<int64_t> seeds, uint64_t seed, int64_t samples,
                           std::optional<double> seconds, const Texts& keyframes, double noise, bool refine,
                           int64_t stride, const ShardArgument& shard, const std::optional<Path>& table,
                           const py::object& progress) {
  const auto at_least_one = [](const char* name, int64_t value) {
    if (value < 1) throw Error(name, "are fewer than 1");
  };
  if (windows) at_least_one("windows", *windows);
  if (seeds) at_least_one("seeds", *seeds);
  at_least_one("samples", samples);
  if (stride < 1) throw Error("stride", "is under 1");
  const auto* one = std::get_if<std::string>(&data);
  const Texts folders = one != nullptr ? Texts{*one} : std::get<Texts>(data), used = settings_of(settings);
  const nlohmann::json job = {{"python", system},
                              {"data", folders},
                              {"split", split},
                              {"model", model ? model->string() : ""},
                              {"settings", used},
                              {"windows", windows.value_or(0)},
                              {"seeds", seeds.value_or(0)},
                              {"seed", seed},
                              {"samples", samples},
                              {"seconds", seconds.value_or(0)},
                              {"keyframes", keyframes},
                              {"noise", noise},
                              {"refine", refine},
                              {"stride", stride}};
  const Asked asked{folders,
                    split,
                    model,
                    used,
                    windows.value_or(0),
                    seeds.value_or(system == "detour" ? 10 : 1),
                    stride,
                    seed,
                    progress_of(progress),
                    parts_of(shard, table, job)};
  const std::map<std::string, std::function<std::string()>> systems = {
      {"anticipate", [&] { return anticipate_rows(asked, samples, seconds.value_or(30)); }},
      {"contacts", [&] { return contacts_rows(asked); }},
      {"detour", [&] { return detour_rows(asked, refine); }},
      {"forecast", [&] { return forecast_rows(asked); }},
      {"inbetween", [&] { return inbetween_rows(asked, keyframes, noise, refine); }},
      {"interact", [&] { return interact_rows(asked, seconds.value_or(16)); }},
      {"reconstruct", [&] { return reconstruct_rows(asked, seconds.value_or(6)); }}};
  const auto rows_of = systems.find(system);
  if (rows_of == systems.end()) {
    std::string names;
    for (const auto& [name, run] : systems) names += (names.empty() ? "" : ", ") + name;
    throw Error("system", "is '" + system + "', which is none of " + names);
  }
  const bool own_rooms = system == "detour" || system == "reconstruct";
  if (asked.data.empty() != own_rooms)
    throw Error("data", own_rooms ? "is of no use: '" + system + "' makes its own rooms" : "is missing");
  if (system == "contacts" && windows) throw Error("windows", "are of no use to 'contacts', which takes all");
  const std::string rows = released(rows_of->second);
  if (rows.empty() && !asked.parts.shard().is_all()) return py::none();
  if (table) write_atomically(table->string(), nlohmann::ordered_json::parse(rows).dump(1) + "\n");
  asked.parts.remove();
  return python_of(rows);
}

}  // namespace

void add_evaluate(py::module_& m) {
  m.def("evaluate", &evaluate_system, "system"_a, "data"_a = Texts(), py::kw_only(), "split"_a = "test",
        "model"_a = py::none(), "settings"_a = py::none(), "windows"_a = py::none(), "seeds"_a = py::none(),
        "seed"_a = 1, "samples"_a = 50, "seconds"_a = py::none(), "keyframes"_a = Texts{"every:60"}, "noise"_a = 0.0,
        "refine"_a = true, "stride"_a = 30, "shard"_a = py::none(), "json"_a = py::none(), "progress"_a = py::none(),
        "The table of a system beside its baselines, as `inhabit eval` writes it to --json: lists and dictionaries.\n\n"
        "system: 'forecast', 'contacts', 'anticipate', 'inbetween', 'interact', or 'detour' and 'reconstruct', which "
        "make\n"
        "their own rooms. data: folders of native data sets, or for 'anticipate' one of 'cmu:FOLDER', 'h36m:FOLDER', "
        "FOLDER.\n"
        "model: a model file instead of the one that ships.\n"
        "settings: how it is used, {'inference.guidance': 0}. windows: at most so many (observations of an action,\n"
        "trials, rooms). seeds: runs of 'inbetween' (1) and 'detour' (10); keyframes, noise (degrees and cm) and "
        "refine (interpolations "
        "refined,\n"
        "too) are of it as well. stride: frames from one window to the next, of 'forecast' and 'contacts'. samples: "
        "futures of an observation, of 'anticipate'. seconds: the longest horizon of\n"
        "'anticipate', the length of a run of 'interact' and of a motion of 'reconstruct'. json: a file that the table "
        "is\n"
        "written to, too. shard: (I, N) for part I of N, for several processes: parts are kept beside `json`, and the "
        "last of\n"
        "them gives and writes the table; None before. progress(done, all) is called now and then.");
}

}  // namespace inhabit::python
