#pragma once
#include <string>

#include "command_facts.h"

// Scripts that complete verbs, options and the names that an option takes; all else are files.
std::string bash_completion(const VerbFacts& command);
std::string zsh_completion(const VerbFacts& command);
std::string fish_completion(const VerbFacts& command);
