#include "evaluate.h"
#include "inhabit/interact/evaluate_contacts.h"
#include "inhabit/interact/evaluate_starts.h"
#include "inhabit/io/scene_file.h"

namespace inhabit::python {

Measured interact_rows(const Asked& asked, Options& options) {
  constexpr int64_t kMany = std::numeric_limits<int64_t>::max();
  const std::vector<std::string> scenes = options.texts("scene");
  const int64_t runs = options.whole("runs", 120, 1, kMany), behind = options.whole("behind", 0, 0, kMany),
                draws = options.whole("draws", 0, 0, kMany);
  const double seconds = options.number("seconds", 16, 0.1, 1e6);
  const uint64_t seed = seed_of(options);
  options.refuse_others();
  if (int{!scenes.empty()} + int{behind > 0} + int{draws > 0} > 1 || (!scenes.empty() && !asked.data.empty()))
    throw Error("scene", "behind and draws exclude each other, and a scene is taken in place of data");
  if (draws > 0 && !asked.parts.shard().is_all()) throw Error("draws", "take seconds and have no parts");
  if (draws > 0) asked.one_model();
  const auto files = asked.networks(&interact::load_networks, "interact-compact.safetensors");
  const auto measured_starts = [&](const std::vector<interact::StartSet>& sets,
                                   const std::vector<interact::Use>& uses) {
    const auto methods = interact::methods_of(files, seconds, uses);
    return measured(interact::score_table(interact::evaluate_starts(sets, methods, seed, asked.progress, asked.parts)),
                    true);
  };
  if (!scenes.empty()) {
    std::vector<interact::StartSet> sets;
    for (const std::string& file : scenes)
      for (interact::StartSet& set : interact::around_chairs(read_scene_file(file).scene, file, runs, seed))
        sets.push_back(std::move(set));
    return measured_starts(sets, {{.raw = true}, {}});
  }
  // Contacts are few on each chair: all of the split are taken.
  const auto trials = interact::trials_of(asked.data, asked.split, draws > 0 ? kMany : runs, seconds);
  if (trials.empty()) throw asked.nothing("clip in which somebody sits");
  if (behind > 0)
    return measured_starts({{"behind", interact::behind_chairs(trials, behind, seed)}},
                           {{.raw = true, .straight = true}, {.raw = true}});
  if (draws > 0)
    return measured(interact::score_table(interact::evaluate_contacts(
                        trials, interact::ChairInteractor(files.front().second), draws, seed)),
                    true);
  const interact::Table table = interact::evaluate(trials, interact::methods_of(files, seconds, {{.raw = true}, {}}),
                                                   seed, asked.progress, asked.parts);
  if (table.rows.empty()) return {};
  return {table_json(table), table_text(table)};
}

}  // namespace inhabit::python
