#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// An option or positional argument of a verb, as its parser knows it.
struct OptionFacts {
  std::vector<std::string> names;  ///< with their dashes; of a positional argument its name alone
  std::string about, value;        ///< what is said of it; what its value is called, empty for a flag
  std::vector<std::string> choices;
  bool positional = false, required = false;
};

/// A verb and those below it.
struct VerbFacts {
  std::string path;  ///< "inhabit eval forecast"
  std::string name, about;
  std::vector<std::string> examples;
  std::vector<OptionFacts> options;
  std::vector<VerbFacts> verbs;
};

/// Of the whole command: what help, completions, the man page and suggestions are made from.
VerbFacts facts_of(const CLI::App& app, const std::string& above = "");

/// The one of `names` that `text` may have been meant as, empty where none is near: a name that it begins or differs
/// from by few letters (left out, added, another, two the other way round).
std::string meant_by(const std::string& text, const std::vector<std::string>& names);
