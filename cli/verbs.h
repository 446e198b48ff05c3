#pragma once
#include <CLI/CLI.hpp>
#include <map>
#include <string>

#include "inhabit/io/up_axis.h"

// Each verb lives in a file of its own, adds its subcommand with its options and a callback that calls the library.
// A callback throws inhabit::Error for whatever a user can get wrong.

/// For check(): refuses what is no number over zero, NaN and infinity included (CLI11's own checks let NaN pass).
inline std::string positive_number(const std::string& text) {
  double value = 0;
  return CLI::detail::lexical_cast(text, value) && value > 0 && value < 1e12 ? "" : text + " is not a number over 0";
}

inline void add_up_axis(CLI::App& verb, inhabit::UpAxis& up) {
  verb.add_option("--up", up, "Up axis of the file, y or z (default: detected)")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, inhabit::UpAxis>{{"y", inhabit::UpAxis::y}, {"z", inhabit::UpAxis::z}}));
}

void add_version(CLI::App& app);
void add_forecast(CLI::App& app);
void add_inbetween(CLI::App& app);
void add_anticipate(CLI::App& app);
void add_train(CLI::App& app);
void add_eval(CLI::App& app);
void add_convert(CLI::App& app);
void add_intentions(CLI::App& app);
void add_info(CLI::App& app);
void add_view(CLI::App& app);
void add_synth(CLI::App& app);
void add_score(CLI::App& app);
void add_average(CLI::App& app);
