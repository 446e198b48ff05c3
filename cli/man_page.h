#pragma once
#include <string>

#include "command_facts.h"

/// The manual page of the whole command, for man: every verb with its options and examples.
std::string man_page(const VerbFacts& command);
