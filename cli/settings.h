#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// Adds --set to a verb that measures a model.
inline void add_settings(CLI::App& verb, std::vector<std::string>& settings) {
  verb.add_option("--set", settings,
                  "Settings of how the model is used, KEY=VALUE, such as inference.guidance=0 (docs/training.md)");
}
