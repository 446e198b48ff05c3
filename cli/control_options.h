#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "inhabit/inbetween/controls.h"

/// Contacts and targets as they are given: which joints they name is known once the motion is.
struct ControlTexts {
  std::vector<std::string> contacts, targets;
};

/// --key-weights, --contact, --target, --root-path and --loop.
void add_controls(CLI::App& verb, inhabit::inbetween::Controls& controls, ControlTexts& texts);

/// Adds contacts and targets to the controls. Throws inhabit::Error naming the option. @param file whose joints they
/// may name
void set_contacts(inhabit::inbetween::Controls& controls, const ControlTexts& texts, const inhabit::Skeleton& file);

/// Throws inhabit::Error naming the option whose time is outside of the keys', on both clocks. After set_contacts.
/// @param first seconds of the first key as --times or the file has it; @param seconds from there to the last key
void require_times(const inhabit::inbetween::Controls& controls, const ControlTexts& texts, double first,
                   double seconds);
