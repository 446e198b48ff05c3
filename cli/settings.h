#pragma once
#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "inhabit/error.h"

/// Adds --set to a verb that measures a model.
inline void add_settings(CLI::App& verb, std::vector<std::string>& settings) {
  verb.add_option("--set", settings,
                  "Settings of how the model is used, KEY=VALUE, such as inference.guidance=0 (docs/training.md)");
}

/// Sets fields of a model that is measured: those that begin with one of `keys`.
template <class Config>
void set_used(Config& config, const std::vector<std::string>& settings, const std::vector<std::string>& keys) {
  std::string there;
  for (const std::string& key : keys) there += (there.empty() ? "" : ", ") + key;
  for (const std::string& setting : settings)
    if (std::none_of(keys.begin(), keys.end(), [&](const auto& key) { return setting.rfind(key, 0) == 0; }))
      throw inhabit::Error("--set " + setting, "is how the networks were made; eval may change " + there);
  set_fields(config, settings);
  validate(config, "--set");
}
