// Protects what a user sees who does not know the command yet: suggestions for typos, help with examples that hold,
// completions and the man page, all made from the parser itself.
#include <gmock/gmock.h>

#include <regex>
#include <sstream>

#include "cli/command.h"
#include "inhabit/io/atomic_file.h"

namespace {

using testing::AllOf, testing::Each, testing::ElementsAre, testing::HasSubstr, testing::Not, testing::SizeIs;

std::string said(const std::string& arguments) {
  const CommandResult r = run_command(arguments);
  EXPECT_EQ(r.exit_code, 2) << arguments;
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  return r.err;
}

std::string shown(const std::string& arguments) {
  const CommandResult r = run_command(arguments);
  EXPECT_EQ(r.exit_code, 0) << arguments << "\n" << r.err;
  return r.out;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> out;
  std::stringstream all(text);
  for (std::string line; std::getline(all, line);) out.push_back(line);
  return out;
}

TEST(Typos, OfVerbsAndOptionsGetASuggestion) {
  EXPECT_THAT(said("forcast x"), HasSubstr("forcast: is no verb, did you mean forecast? There are version, forecast"));
  EXPECT_THAT(said("eval forecats"), HasSubstr("did you mean forecast?"));
  EXPECT_THAT(said("help inbetwen"), HasSubstr("did you mean inbetween?"));
  EXPECT_THAT(said("inbetween a.bvh --keyframe 3"),
              HasSubstr("--keyframe: is no option of inhabit inbetween; did you mean --keyframes?"));
  EXPECT_THAT(said("--quiet convert a b"), HasSubstr("--quiet: stands before its verb, inhabit convert"));
  EXPECT_THAT(said("--hlep"), HasSubstr("--hlep: is no option of inhabit, did you mean --help?"));
  EXPECT_THAT(said("convert a b --input-raet=30"), HasSubstr("did you mean --input-rate?"));
  // Said before what follows from it: that --motion is missing.
  EXPECT_THAT(said("score ndms --motoin a.bvh"), HasSubstr("did you mean --motion?"));
  EXPECT_THAT(said("info a.bvh --frobnicate"),
              AllOf(HasSubstr("`inhabit help info` lists them"), Not(HasSubstr("did you"))));
  EXPECT_THAT(said("info a.bvh b.bvh"), HasSubstr("b.bvh: is one argument too many for inhabit info"));
  EXPECT_THAT(said("xyzzy"), Not(HasSubstr("did you mean")));
}

TEST(Help, OfAVerbIsItsOwnWithExamples) {
  EXPECT_EQ(shown("help forecast"), shown("forecast --help"));
  EXPECT_EQ(shown("help eval inbetween"), shown("eval inbetween --help"));
  EXPECT_THAT(shown("help forecast"),
              AllOf(HasSubstr("Usage: inhabit forecast"), HasSubstr("Examples:\n  inhabit forecast")));
  EXPECT_THAT(shown("help"), AllOf(HasSubstr("forecast"), HasSubstr("score")));
  EXPECT_THAT(shown("help score"), HasSubstr("penetration"));
  for (const std::string several : {"train", "eval", "synth", "score", "stream"}) {
    const std::string help = shown("help " + several);
    const size_t start = help.find("Examples:\n");
    ASSERT_NE(start, std::string::npos) << several;
    EXPECT_THAT(help.substr(start), HasSubstr("inhabit " + several + " "));
  }
}

/// Every verb has an example, and every option in it is one of the verb's.
TEST(Help, ExamplesHold) {
  const std::string all = shown("help --man");
  const std::regex verb("\\.SS (inhabit [a-z\\\\-]+( [a-z]+)?)\n");
  int verbs = 0;
  for (std::sregex_iterator at(all.begin(), all.end(), verb), end; at != end; ++at, ++verbs) {
    const std::string path = (*at)[1], help = shown("help" + path.substr(7));
    if (path == "inhabit version") continue;
    const size_t start = help.find("Examples:\n");
    ASSERT_NE(start, std::string::npos) << path;
    const std::string options = help.substr(0, start);
    for (const std::string& example : lines_of(help.substr(start + 10))) {
      if (example.find_first_not_of(' ') == std::string::npos) continue;
      EXPECT_THAT(example, HasSubstr(path)) << "an example of another verb";
      const std::regex option(" (--?[a-z][a-z-]*)");
      for (std::sregex_iterator o(example.begin(), example.end(), option); o != end; ++o)
        EXPECT_THAT(options, HasSubstr((*o)[1].str())) << example;
    }
  }
  EXPECT_GT(verbs, 35);
}

/// What bash offers for the words of a line, the last of which is being typed.
std::vector<std::string> offered(const std::string& script, const std::string& words) {
  const CommandResult r =
      run_program("bash -c 'source " + script + "; COMP_WORDS=(" + words +
                  "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _inhabit; printf \"%s\\n\" \"${COMPREPLY[@]}\"'");
  EXPECT_EQ(r.err, "");
  std::vector<std::string> out;
  for (const std::string& line : lines_of(r.out))
    if (!line.empty()) out.push_back(line);
  return out;
}

TEST(Completion, BashOffersVerbsOptionsAndNames) {
  const TempFolder folder;
  const std::string script = folder / "inhabit.bash";
  inhabit::write_atomically(script, shown("completion bash"));
  EXPECT_THAT(offered(script, "inhabit fore"), ElementsAre("forecast"));
  EXPECT_THAT(offered(script, "inhabit eval inb"), ElementsAre("inbetween"));
  EXPECT_THAT(offered(script, "inhabit help refi"), ElementsAre("refine"));
  EXPECT_THAT(offered(script, "inhabit convert --out-u"), ElementsAre("--out-up"));
  EXPECT_THAT(offered(script, "inhabit convert --out-up \"\""), ElementsAre("y", "z"));
  EXPECT_THAT(offered(script, "inhabit eval forecast --split t"), ElementsAre("train", "test"));
  EXPECT_THAT(offered(script, "inhabit completion z"), ElementsAre("zsh"));
  EXPECT_THAT(offered(script, "inhabit forecast walk"), SizeIs(0)) << "files are the shell's";
  // The data set is called like a verb: still the options of eval forecast.
  EXPECT_THAT(offered(script, "inhabit eval forecast --data score --interv"), ElementsAre("--intervals"));
}

TEST(Completion, OfAllShellsKnowsEveryVerbAndOption) {
  const std::string bash = shown("completion bash"), zsh = shown("completion zsh"), fish = shown("completion fish");
  for (const char* name : {"forecast", "anticipate", "detour", "penetration", "completion"})
    EXPECT_THAT((std::vector<std::string>{bash, zsh, fish}), Each(HasSubstr(name)));
  for (const char* option : {"keyframes", "input-rate", "intervals", "asf"})
    EXPECT_THAT((std::vector<std::string>{bash, zsh, fish}), Each(HasSubstr(option)));
  // Names at their place, files behind them.
  EXPECT_THAT(zsh, HasSubstr("'1:format:(amass "));
  EXPECT_THAT(fish, HasSubstr("'__inhabit_at import' -f -a 'amass "));
  const TempFolder folder;
  for (const auto& [shell, script] : {std::pair("bash", bash), {"zsh", zsh}, {"fish", fish}}) {
    inhabit::write_atomically(folder / shell, script);
    const CommandResult r =
        run_program("command -v " + std::string(shell) + " >/dev/null || exit 0; " + shell + " -n " + folder / shell);
    EXPECT_EQ(r.exit_code, 0) << shell << r.err;
  }
  const CommandResult offers =
      run_program("command -v fish >/dev/null || { echo --intervals; exit 0; }; fish -c 'source " + folder / "fish" +
                  "; complete -C \"inhabit eval forecast --interv\"'");
  EXPECT_THAT(offers.out, HasSubstr("--intervals")) << offers.err;
}

TEST(ManPage, HasEveryVerbWithItsOptions) {
  const std::string page = shown("help --man");
  EXPECT_THAT(page,
              AllOf(HasSubstr(".TH INHABIT 1"), HasSubstr(".SH EXIT STATUS"), HasSubstr(".SS inhabit eval forecast\n"),
                    HasSubstr("\\fB\\-\\-keyframes\\fR"), HasSubstr("INHABIT_MODELS")));
  for (const std::string& line : lines_of(page)) {
    if (line.rfind('.', 0) != 0) continue;
    EXPECT_THAT(line, testing::ContainsRegex("^\\.(TH|SH|SS|TP|PP|nf|fi)")) << "no request";
  }
}

}  // namespace
