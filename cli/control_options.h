#pragma once
#include <CLI/CLI.hpp>

#include "inhabit/inbetween/controls.h"

/// --key-weights, --contact, --root-path and --loop.
void add_controls(CLI::App& verb, inhabit::inbetween::Controls& controls);
