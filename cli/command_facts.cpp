#include "command_facts.h"

#include <algorithm>
#include <sstream>

#include "examples.h"

namespace {

/// "TEXT:{a,b}" -> a, b.
std::vector<std::string> choices_in(const std::string& type) {
  std::vector<std::string> out;
  const size_t open = type.find('{'), close = type.find('}', open);
  if (open == std::string::npos || close == std::string::npos) return out;
  std::stringstream list(type.substr(open + 1, close - open - 1));
  for (std::string choice; std::getline(list, choice, ',');) out.push_back(choice);
  return out;
}

OptionFacts option_facts(const CLI::Option& option) {
  OptionFacts out;
  out.about = option.get_description();
  out.positional = option.get_positional() && option.get_lnames().empty() && option.get_snames().empty();
  out.required = option.get_required();
  if (out.positional) out.names = {option.get_name(true)};
  for (const std::string& name : option.get_lnames()) out.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) out.names.push_back("-" + name);
  if (option.get_items_expected_max() == 0) return out;
  out.choices = choices_in(option.get_type_name());
  out.value = option.get_option_text();
  if (out.value.empty()) out.value = out.choices.empty() ? option.get_type_name() : "NAME";
  return out;
}

/// Damerau and Levenshtein's distance, of neighbours that change places counted as one.
size_t distance_between(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (size_t k = 0; k <= b.size(); ++k) d[0][k] = k;
  for (size_t i = 1; i <= a.size(); ++i)
    for (size_t k = 1; k <= b.size(); ++k) {
      d[i][k] = std::min({d[i - 1][k] + 1, d[i][k - 1] + 1, d[i - 1][k - 1] + (a[i - 1] == b[k - 1] ? 0 : 1)});
      if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1])
        d[i][k] = std::min(d[i][k], d[i - 2][k - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

VerbFacts facts_of(const CLI::App& app, const std::string& above) {
  VerbFacts out;
  out.name = app.get_name();
  out.path = above.empty() ? out.name : above + " " + out.name;
  out.about = app.get_description();
  out.examples = examples_of(out.path);
  for (const CLI::Option* option : app.get_options()) out.options.push_back(option_facts(*option));
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    out.verbs.push_back(facts_of(*verb, out.path));
  return out;
}

std::string meant_by(const std::string& text, const std::vector<std::string>& names) {
  const size_t letters =
      text.find_first_not_of('-') == std::string::npos ? 0 : text.size() - text.find_first_not_of('-');
  std::string best;
  size_t least = letters / 3 + 1;  // of a third of the letters wrong nothing can be told any more
  if (letters < 2) return best;
  for (const std::string& name : names) {
    const size_t d = letters > 2 && name.rfind(text, 0) == 0 ? 1 : distance_between(text, name);
    if (d < least || (d == least && best.empty() && d == 1)) {
      least = d;
      best = name;
    }
  }
  return best;
}
