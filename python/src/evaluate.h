#pragma once
#include <limits>

#include "inhabit/data/measured_parts.h"
#include "inhabit/error.h"
#include "inhabit/io/shipped_model.h"
#include "inhabit/metrics/score_table.h"
#include "inhabit/nn/used_settings.h"
#include "options.h"

// What `evaluate` measures of each system: `inhabit eval`, with its options by their names.

namespace inhabit::python {

/// What every system is asked for.
struct Asked {
  std::vector<std::string> data;
  std::string split;
  std::vector<std::string> models;  ///< empty: the one that ships
  std::vector<std::string> settings;
  bool text = false;
  Progress progress;
  MeasuredParts parts;

  /// All models, each behind its file's name, used as the settings have it.
  template <class Networks>
  std::vector<std::pair<std::string, Networks>> networks(Networks (*load)(const std::string&),
                                                         const std::string& shipped) const {
    std::vector<std::pair<std::string, Networks>> out;
    for (const std::string& given : models.empty() ? std::vector<std::string>{shipped} : models) {
      out.emplace_back(given, load(inhabit::model_file(given, shipped)));
      set_used(out.back().second.config, settings);
    }
    return out;
  }
  template <class Networks>
  Networks network(Networks (*load)(const std::string&), const std::string& shipped) const {
    one_model();
    return networks(load, shipped).front().second;
  }
  void one_model() const {
    if (models.size() > 1) throw Error("model", "is one file here");
  }
  Error nothing(const std::string& what) const {
    return Error(data.empty() ? "data" : data.front(), "has no " + what + " in split " + split);
  }
};

/// A table as JSON and as the command prints it; null where other parts are still to come.
struct Measured {
  nlohmann::ordered_json table;
  std::string text;
  Notes notes = {};
};
Measured measured(const ScoreTable& table, bool intervals);

uint64_t seed_of(Options& options);

Measured inbetween_rows(const Asked& asked, Options& options);
Measured detour_rows(const Asked& asked, Options& options);
Measured interact_rows(const Asked& asked, Options& options);

}  // namespace inhabit::python
