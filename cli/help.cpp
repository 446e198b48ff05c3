#include <algorithm>
#include <cstdio>
#include <memory>

#include "command_facts.h"
#include "completion.h"
#include "examples.h"
#include "inhabit/error.h"
#include "man_page.h"
#include "verbs.h"

namespace {

std::vector<std::string> names_of(const CLI::App& app) {
  std::vector<std::string> out;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; }))
    out.push_back(verb->get_name());
  return out;
}

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

}  // namespace

std::string no_verb(const CLI::App& app, const std::string& unknown) {
  const std::vector<std::string> verbs = names_of(app);
  if (unknown.empty()) return "a verb is missing; there are " + listed(verbs);
  if (unknown.front() == '-') {
    const std::string option = meant_by(unknown, {"--help", "--version"});
    return unknown + ": is no option of inhabit" + (option.empty() ? "" : ", did you mean " + option + "?") +
           "; those of a verb come after it";
  }
  const std::string meant = meant_by(unknown, verbs);
  return unknown + ": is no verb" + (meant.empty() ? "; there are " : ", did you mean " + meant + "? There are ") +
         listed(verbs);
}

std::string no_option(const CLI::App& verb, const std::string& path, const std::string& unknown) {
  if (unknown.empty() || unknown.front() != '-') return unknown + ": is one argument too many for " + path;
  const std::string name = unknown.substr(0, unknown.find('='));
  std::vector<std::string> known;
  for (const OptionFacts& option : facts_of(verb).options)
    if (!option.positional) known.insert(known.end(), option.names.begin(), option.names.end());
  if (std::find(known.begin(), known.end(), name) != known.end()) return name + ": stands before its verb, " + path;
  const std::string meant = meant_by(name, known);
  return name + ": is no option of " + path +
         (meant.empty() ? "; `inhabit help" + path.substr(path.find(' ')) + "` lists them"
                        : "; did you mean " + meant + "?");
}

void add_help(CLI::App& app) {
  struct Given {
    std::vector<std::string> words;
    bool man = false;
  };
  auto given = std::make_shared<Given>();
  CLI::App* verb = app.add_subcommand("help", "What a verb does, its options and examples");
  verb->add_option("verb", given->words, "A verb, and the one below it");
  verb->add_flag("--man", given->man, "The manual page of the whole command instead, for man");
  verb->callback([given, &app] {
    if (given->man) {
      std::printf("%s", man_page(facts_of(app)).c_str());
      return;
    }
    const CLI::App* at = &app;
    std::string above;
    for (const std::string& word : given->words) {
      const auto found = at->get_subcommands([&](const CLI::App* sub) { return sub->get_name() == word; });
      if (found.empty()) throw inhabit::Error(no_verb(*at, word));
      above += (above.empty() ? "" : " ") + at->get_name();
      at = found.front();
    }
    // The verb being parsed is this one: of the command itself its own help is asked for.
    const std::string text =
        at == &app ? app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal) : at->help(above);
    std::printf("%s", text.c_str());
  });
}

void add_completion(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App* verb = app.add_subcommand("completion", "A script that completes this command's words in a shell");
  verb->add_option("shell", *shell, "bash, zsh or fish")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  verb->callback([shell, &app] {
    const VerbFacts facts = facts_of(app);
    const std::string script = *shell == "bash"  ? bash_completion(facts)
                               : *shell == "zsh" ? zsh_completion(facts)
                                                 : fish_completion(facts);
    std::printf("%s", script.c_str());
  });
}

void add_examples(CLI::App& app, const std::string& above) {
  const std::string path = above.empty() ? app.get_name() : above + " " + app.get_name();
  const std::vector<CLI::App*> verbs = app.get_subcommands([](CLI::App*) { return true; });
  std::vector<std::string> examples = examples_of(path);
  if (examples.empty() && !above.empty())  // a verb that is several: the first example of each
    for (const CLI::App* verb : verbs)
      if (const auto own = examples_of(path + " " + verb->get_name()); !own.empty()) examples.push_back(own.front());
  std::string text;
  for (const std::string& example : examples) text += (text.empty() ? "Examples:\n  " : "\n  ") + example;
  if (!text.empty()) app.footer(text);
  for (CLI::App* verb : verbs) add_examples(*verb, path);
}
