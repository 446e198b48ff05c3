// Protects what is seen of long work: a bar on a terminal, plain lines elsewhere, nothing with --quiet; and that what
// is printed for other programs stays clean; and what becomes of work that is interrupted.
#include <gmock/gmock.h>

#include <filesystem>
#include <sstream>

#include "cli/command.h"
#include "cli/examples.h"
#include "cli/tiny_rooms.h"
#include "inhabit/io/atomic_file.h"

namespace {

using testing::AllOf, testing::HasSubstr, testing::Not;

/// Work of a second or so.
std::string work(const std::string& folder) {
  return INHABIT_COMMAND " synth rooms --clips 60 --seed 3 --out " + folder;
}

/// On a terminal of its own.
std::string on_terminal(const std::string& command) {
  return run_program("TERM=xterm script -qec '" + command + "' /dev/null </dev/null").out;
}

TEST(Progress, IsABarOnATerminalAndGoesAwayInTheEnd) {
  const TempFolder folder;
  const std::string out = on_terminal(work(folder / "a"));
  EXPECT_THAT(out, AllOf(HasSubstr("clips ["), HasSubstr("of 60, "), HasSubstr("/s, "), HasSubstr(" left")));
  const size_t bar = out.rfind("clips ["), gone = out.rfind("\r\x1b[K");
  ASSERT_NE(bar, std::string::npos);
  EXPECT_GT(gone, bar);
  EXPECT_LT(gone, out.rfind("60 clips")) << "what the verb says in the end stands alone";
  const std::string quiet = on_terminal(work(folder / "b") + " --quiet");
  EXPECT_THAT(quiet, AllOf(Not(HasSubstr("clips [")), HasSubstr("60 clips")));
}

TEST(Progress, OfATrainingIsABarBelowItsLines) {
  const TempFolder folder;
  const std::string data = make_tiny_rooms(folder),
                    out = on_terminal(INHABIT_COMMAND
                                      " train forecast --stage motion --set decoder=recurrent"
                                      " training.motion_steps=60 training.motion_batch=2 --data " +
                                      data + " --out " + folder / "m.safetensors");
  EXPECT_THAT(out, AllOf(HasSubstr("motion ["), HasSubstr("of 60, "), HasSubstr("/s, "), HasSubstr(" left")));
  std::istringstream lines(out);
  int64_t logged = 0;
  for (std::string line; std::getline(lines, line); ++logged) {
    const size_t said = line.find("[info]");
    if (said == std::string::npos) continue;
    const size_t bar = line.rfind("motion [", said), gone = line.rfind("\r\x1b[K", said);
    if (bar == std::string::npos) continue;
    ASSERT_NE(gone, std::string::npos) << line;
    EXPECT_GT(gone, bar) << "a line stands behind the bar: " << line;
  }
  EXPECT_GT(logged, 2);
}

TEST(Progress, LeavesNoBarWhereThereIsNoTerminal) {
  const TempFolder folder;
  const CommandResult r = run_program(work(folder / "a"));
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.err + r.out, Not(HasSubstr("\r")));
  EXPECT_THAT(r.out, Not(HasSubstr("of 60")));
}

TEST(Interrupted, WorkIsKeptAndTheSameCommandGoesOn) {
  const TempFolder folder;
  const std::string out = folder / "rooms", kept = out + "/unfinished.jsonl",
                    command = "synth rooms --clips 40 --seed 3 --seconds 4 --out " + out;
  const CommandResult ended = run_program("sh -c '" INHABIT_COMMAND " " + command + " & pid=$!; until test -s " + kept +
                                          " || ! kill -0 $pid; do sleep 0.02; done; kill $pid; wait $pid'");
  EXPECT_EQ(ended.exit_code, 128 + 15);
  EXPECT_THAT(ended.err,
              HasSubstr("inhabit: interrupted; what is made is kept, and the same command makes the rest\n"));
  ASSERT_TRUE(std::filesystem::exists(kept)) << "the run was not long enough to be interrupted";
  const CommandResult rest = run_command(command);
  EXPECT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(rest.out, HasSubstr("40 clips"));
  EXPECT_FALSE(std::filesystem::exists(kept));
}

TEST(Interrupted, WorkThatKeepsNothingEndsAtOnce) {
  const TempFolder folder;
  const std::string in = folder / "in", said = folder / "said";  // `in`: a pipe that nobody writes to
  const CommandResult r = run_program(
      "sh -c 'mkfifo " + in + "; exec 3<>" + in + "; " INHABIT_COMMAND " stream forecast <&3 >/dev/null 2>" + said +
      " & pid=$!; until test -s " + said + " || ! kill -0 $pid; do sleep 0.02; done; kill $pid; wait $pid'");
  EXPECT_EQ(r.exit_code, 128 + 15);
  EXPECT_THAT(inhabit::read_whole_file(said), testing::EndsWith("inhabit: interrupted\n"));
}

TEST(Quiet, LeavesAwayWhatWasDetected) {
  const TempFolder folder;
  const std::string in = "convert " + kWalk + " " + folder / "a.bvh && " INHABIT_COMMAND " convert " +
                         folder / "a.bvh" + " " + folder / "b.npz";
  const CommandResult loud = run_command(in), quiet = run_command(in + " --quiet");
  ASSERT_EQ(loud.exit_code, 0) << loud.err;
  EXPECT_THAT(loud.out, HasSubstr("taken for centimetres"));
  EXPECT_THAT(quiet.out, AllOf(Not(HasSubstr("taken for")), HasSubstr("b.npz: 90 frames")));
}

}  // namespace
