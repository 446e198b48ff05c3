// Protects what is seen of long work: a bar on a terminal, plain lines elsewhere, nothing with --quiet; and that what
// is printed for other programs stays clean.
#include <gmock/gmock.h>

#include "cli/command.h"
#include "cli/examples.h"

namespace {

using testing::AllOf, testing::HasSubstr, testing::Not;

const std::string kWork = INHABIT_COMMAND " eval reconstruct --rooms 3 --seconds 1 --width 64 --no-objects";

/// On a terminal of its own.
std::string on_terminal(const std::string& command) {
  return run_program("TERM=xterm script -qec '" + command + "' /dev/null </dev/null").out;
}

TEST(Progress, IsABarOnATerminalAndGoesAwayInTheEnd) {
  const std::string out = on_terminal(kWork);
  EXPECT_THAT(out, AllOf(HasSubstr("rooms ["), HasSubstr("of 3"), HasSubstr("/s, "), HasSubstr(" left")));
  const size_t bar = out.rfind("rooms ["), gone = out.rfind("\r\x1b[K");
  ASSERT_NE(bar, std::string::npos);
  EXPECT_GT(gone, bar);
  EXPECT_THAT(on_terminal(kWork + " --quiet"), Not(HasSubstr("rooms [")));
}

TEST(Progress, LeavesNoBarWhereItIsNoTerminal) {
  const CommandResult r = run_program(kWork);
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.err + r.out, Not(HasSubstr("\r")));
  EXPECT_THAT(r.out, Not(HasSubstr("of 3")));
}

TEST(Quiet, LeavesAwayWhatWasDetected) {
  const TempFolder folder;
  const std::string in = "convert " + kWalk + " " + folder / "a.bvh && " INHABIT_COMMAND " convert " +
                         folder / "a.bvh" + " " + folder / "b.npz";
  const CommandResult loud = run_command(in), quiet = run_command(in + " --quiet");
  ASSERT_EQ(loud.exit_code, 0) << loud.err;
  EXPECT_THAT(loud.out, HasSubstr("detected"));
  EXPECT_THAT(quiet.out, AllOf(Not(HasSubstr("detected")), HasSubstr("b.npz: 90 frames")));
}

}  // namespace
