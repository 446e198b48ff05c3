#pragma once
#include <CLI/CLI.hpp>

// Each verb lives in a file of its own, adds its subcommand with its options and a callback that calls the library.
// A callback throws inhabit::Error for whatever a user can get wrong.
void add_version(CLI::App& app);
void add_train(CLI::App& app);
void add_eval(CLI::App& app);
void add_info(CLI::App& app);
void add_view(CLI::App& app);
void add_synth(CLI::App& app);
