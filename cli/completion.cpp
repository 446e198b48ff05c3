#include "completion.h"

#include <functional>

namespace {

void each_verb(const VerbFacts& verb, const std::function<void(const VerbFacts&)>& work) {
  work(verb);
  for (const VerbFacts& below : verb.verbs) each_verb(below, work);
}

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + word;
  return out;
}

/// In single quotes of a shell. @param escaped letters that get a backslash
std::string quoted(const std::string& text, const std::string& escaped = "") {
  std::string out = "'";
  for (const char c : text) {
    if (escaped.find(c) != std::string::npos) out += '\\';
    out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return out + "'";
}

/// Of a fish script: in single quotes a backslash stands before quotes and backslashes.
std::string fish_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += (c == '\'' || c == '\\' ? "\\" : "") + std::string(1, c);
  return out + "'";
}

/// The verbs below, of `help` those of the whole command.
std::vector<std::string> names_below(const VerbFacts& verb, const VerbFacts& command) {
  std::vector<std::string> out;
  for (const VerbFacts& below : (verb.name == "help" ? command : verb).verbs) out.push_back(below.name);
  for (const OptionFacts& option : verb.options)
    if (option.positional) out.insert(out.end(), option.choices.begin(), option.choices.end());
  return out;
}

}  // namespace

std::string bash_completion(const VerbFacts& command) {
  std::string paths, words, values;
  each_verb(command, [&](const VerbFacts& verb) {
    std::vector<std::string> options;
    for (const OptionFacts& option : verb.options) {
      if (option.positional) continue;
      for (const std::string& name : option.names) {
        options.push_back(name);
        if (!option.choices.empty())
          values += "    '" + verb.path + " " + name + "') COMPREPLY=($(compgen -W '" + joined(option.choices) +
                    "' -- \"$cur\")); return ;;\n";
        else if (!option.value.empty())
          values += "    '" + verb.path + " " + name + "') return ;;\n";
      }
    }
    for (const VerbFacts& below : verb.verbs) paths += (paths.empty() ? "'" : " | '") + below.path + "'";
    words += "    '" + verb.path + "') verbs='" + joined(names_below(verb, command)) + "' options='" + joined(options) +
             "' ;;\n";
  });
  return "# bash completion of inhabit, made by `inhabit completion bash`\n"
         "_inhabit() {\n"
         "  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} path=inhabit verbs= options= i\n"
         "  for ((i = 1; i < COMP_CWORD; i++)); do\n"
         "    case \"$path ${COMP_WORDS[i]}\" in\n"
         "    " +
         paths +
         ") path=\"$path ${COMP_WORDS[i]}\" ;;\n"
         "    esac\n"
         "  done\n"
         "  COMPREPLY=()\n"
         "  case \"$path $prev\" in\n" +
         values +
         "  esac\n"
         "  case \"$path\" in\n" +
         words +
         "  esac\n"
         "  if [[ $cur == -* ]]; then COMPREPLY=($(compgen -W \"$options\" -- \"$cur\"))\n"
         "  elif [[ -n $verbs ]]; then COMPREPLY=($(compgen -W \"$verbs\" -- \"$cur\"))\n"
         "  fi\n"
         "}\n"
         "complete -o default -F _inhabit inhabit\n";
}

namespace {

/// The function that completes a verb's words, after those of the verbs below.
std::string zsh_function(const VerbFacts& verb, const VerbFacts& command) {
  std::string name = "_" + verb.path, out, cases;
  for (char& c : name)
    if (c == ' ') c = '_';
  for (const VerbFacts& below : verb.verbs) {
    out += zsh_function(below, command);
    cases += "    " + below.name + ") " + name + "_" + below.name + " ;;\n";
  }
  out += name + "() {\n  local line state\n  _arguments -C";
  for (const OptionFacts& option : verb.options) {
    if (option.positional) continue;
    std::string about;  // in brackets, in which a bracket has a backslash
    for (const char c : option.about) about += (c == '[' || c == ']' ? "\\" : "") + std::string(1, c);
    const std::string value = option.value.empty()     ? ""
                              : option.choices.empty() ? ":value:_files"
                                                       : ":value:(" + joined(option.choices) + ")";
    for (const std::string& each : option.names) out += " \\\n    " + quoted("*" + each + "[" + about + "]" + value);
  }
  const std::vector<std::string> words = names_below(verb, command);
  if (verb.name == "help") return out + " \\\n    " + quoted("*:word:(" + joined(words) + ")") + "\n}\n";
  if (verb.verbs.empty()) {  // each positional argument with names at its place, files everywhere else
    int place = 0;
    for (const OptionFacts& option : verb.options) {
      if (!option.positional) continue;
      ++place;
      if (!option.choices.empty())
        out += " \\\n    " +
               quoted(std::to_string(place) + ":" + option.names.front() + ":(" + joined(option.choices) + ")");
    }
    return out + " \\\n    '*:file:_files'\n}\n";
  }
  return out + " \\\n    '1:verb:->verb' '*::word:->words'\n  case $state in\n  verb) compadd " + joined(words) +
         " ;;\n  words) case $words[1] in\n" + cases + "    esac ;;\n  esac\n}\n";
}

}  // namespace

std::string zsh_completion(const VerbFacts& command) {
  return "#compdef inhabit\n# made by `inhabit completion zsh`\n" + zsh_function(command, command) +
         "if [[ $funcstack[1] == _inhabit ]]; then _inhabit \"$@\"; else compdef _inhabit inhabit; fi\n";
}

std::string fish_completion(const VerbFacts& command) {
  std::string out =
      "# fish completion of inhabit, made by `inhabit completion fish`\n"
      "function __inhabit_in  # whether these are the first words after the command\n"
      "  set -l words (commandline -opc); set -e words[1]\n"
      "  set -l many (count $argv)\n"
      "  test (count $words) -ge $many; and test \"$words[1..$many]\" = \"$argv\"\n"
      "end\n"
      "function __inhabit_at  # whether these are all words after the command\n"
      "  set -l words (commandline -opc); set -e words[1]\n"
      "  test \"$words\" = \"$argv\"\n"
      "end\n";
  each_verb(command, [&](const VerbFacts& verb) {
    const std::string words = verb.path == command.path ? "" : " " + verb.path.substr(command.path.size() + 1);
    const std::string start = "complete -c inhabit -n ";
    const auto& below = verb.name == "help" ? command.verbs : verb.verbs;
    for (const VerbFacts& each : below)
      out +=
          start + fish_quoted("__inhabit_at" + words) + " -f -a " + each.name + " -d " + fish_quoted(each.about) + "\n";
    for (const OptionFacts& option : verb.options) {
      const std::string condition = start + fish_quoted((words.empty() ? "__inhabit_at" : "__inhabit_in") + words);
      if (option.positional) {
        // At its place alone: files may follow.
        if (!option.choices.empty())
          out += start + fish_quoted("__inhabit_at" + words) + " -f -a " + fish_quoted(joined(option.choices)) + "\n";
        continue;
      }
      out += condition;
      for (const std::string& name : option.names)
        out += name.rfind("--", 0) == 0 ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!option.choices.empty())
        out += " -x -a " + fish_quoted(joined(option.choices));
      else if (!option.value.empty())
        out += " -r";
      out += " -d " + fish_quoted(option.about) + "\n";
    }
  });
  return out;
}
