#include "man_page.h"

#include "version.h"

namespace {

/// As roff takes text: a hyphen that is to be copied, no line that begins like a request.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
  return !out.empty() && (out.front() == '.' || out.front() == '\'') ? "\\&" + out : out;
}

std::string option_text(const OptionFacts& option) {
  std::string names;
  for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + escaped(name);
  std::string value = option.value;
  if (!option.choices.empty()) {
    value.clear();
    for (const std::string& choice : option.choices) value += (value.empty() ? "" : "|") + choice;
  }
  return ".TP\n\\fB" + names + "\\fR" + (value.empty() || option.positional ? "" : " \\fI" + escaped(value) + "\\fR") +
         "\n" + escaped(option.about) + "\n";
}

std::string verb_text(const VerbFacts& verb) {
  std::string out;
  if (verb.verbs.empty()) {
    std::string usage;
    for (const OptionFacts& option : verb.options)
      if (option.positional)
        usage += " \\fI" + escaped(option.names.front()) + "\\fR";
      else if (option.required)
        usage += " \\fB" + escaped(option.names.front()) + "\\fR \\fI" + escaped(option.value) + "\\fR";
    out += ".SS " + escaped(verb.path) + "\n" + escaped(verb.about) + ".\n.PP\n\\fB" + escaped(verb.path) + "\\fR" +
           usage + " [\\fIoptions\\fR]\n";
    for (const OptionFacts& option : verb.options)
      if (option.names.front() != "--help" && option.names.front() != "--quiet") out += option_text(option);
    if (!verb.examples.empty()) out += ".PP\nExamples:\n.PP\n.nf\n";
    for (const std::string& example : verb.examples) out += "    " + escaped(example) + "\n";
    if (!verb.examples.empty()) out += ".fi\n";
  }
  for (const VerbFacts& below : verb.verbs) out += verb_text(below);
  return out;
}

}  // namespace

std::string man_page(const VerbFacts& command) {
  const std::string version = kVersions;
  return ".TH INHABIT 1 \"\" \"" + version.substr(0, version.find(',')) +
         "\" \"User Commands\"\n"
         ".SH NAME\ninhabit \\- human motion in 3D scenes\n"
         ".SH SYNOPSIS\n\\fBinhabit\\fR \\fIverb\\fR [\\fIarguments\\fR]\n"
         ".SH DESCRIPTION\n"
         "Predicts, anticipates, fills in, cleans, converts and measures people's motion in rooms. Motion and scene "
         "files of\n"
         "all usual formats go in, motion (.npz .bvh .glb .json) and pages (.html) come out. Axes, units and rates "
         "are\n"
         "detected and said.\n"
         ".PP\n"
         "All verbs take \\fB\\-\\-help\\fR, and \\fB\\-\\-quiet\\fR, which says nothing of progress and of what was "
         "detected.\n"
         ".SH VERBS\n" +
         verb_text(command) +
         ".SH EXIT STATUS\n"
         ".TP\n0\nDone.\n"
         ".TP\n1\nDone, but for files that were skipped and named on stderr; or a bar of \\fBsynth check\\fR was "
         "missed.\n"
         ".TP\n2\nRefused, with one line on stderr that names the file or argument and the reason.\n"
         ".TP\n3\nSomething went wrong that should not.\n"
         ".TP\n130, 143\nInterrupted by SIGINT or SIGTERM, with one line on stderr, which says what is kept where "
         "anything is.\n"
         ".SH ENVIRONMENT\n"
         ".TP\nINHABIT_MODELS\nFolders, between colons, in which models are looked for first.\n"
         ".TP\nXDG_DATA_HOME, XDG_DATA_DIRS\nModels are looked for in inhabit/models of these too.\n"
         ".TP\nINHABIT_SIMD\nLevel of vector instructions: baseline, avx2 or avx512.\n"
         ".TP\nOMP_NUM_THREADS\nThreads.\n";
}
