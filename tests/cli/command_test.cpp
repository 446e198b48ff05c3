#include "cli/command.h"

#include <gmock/gmock.h>

TEST(Command, WithoutAVerbSaysSoInOneLineAndExitsTwo) {
  const CommandResult r = run_command("");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
}

TEST(Command, AWrongVerbOrNameIsSaidWithWhatThereIs) {
  const auto said = [](const std::string& arguments) {
    const CommandResult r = run_command(arguments);
    EXPECT_EQ(r.exit_code, 2) << arguments;
    return r.err;
  };
  using ::testing::HasSubstr, ::testing::AllOf;
  EXPECT_THAT(said(""), AllOf(HasSubstr("a verb is missing"), HasSubstr("forecast, inbetween")));
  EXPECT_THAT(said("frobnicate"), AllOf(HasSubstr("frobnicate: is no verb"), HasSubstr("forecast, inbetween")));
  EXPECT_THAT(said("eval frobnicate"), AllOf(HasSubstr("frobnicate: is no verb"), HasSubstr("detour")));
  EXPECT_THAT(said("inbetween a.bvh --sampler foo"),
              HasSubstr("--sampler: is foo, which is none of ddim, ddpm, dpm\n"));
  EXPECT_THAT(said("convert a.bvh b.bvh --up w"), HasSubstr("--up: is w, which is none of y, z\n"));
  EXPECT_THAT(said("train forecast --data a --out b --preset foo"), HasSubstr("foo"));
  EXPECT_THAT(run_command("inbetween --help").out, AllOf(HasSubstr("--no-refine "), ::testing::Not(HasSubstr("{"))));
}

TEST(Command, VersionNamesLibTorch) {
  for (const std::string asked : {"version", "--version"}) {
    const CommandResult r = run_command(asked);
    EXPECT_EQ(r.exit_code, 0) << asked << r.err;
    EXPECT_NE(r.out.find("LibTorch"), std::string::npos) << r.out;
  }
}

/// What is called inhabit is a launcher: it must pass on arguments, exit codes and, as it becomes the program it
/// starts, signals; --version must not wait for LibTorch.
TEST(Command, IsSmallAndBecomesTheProgramOfTheVerbs) {
  const std::filesystem::path command = INHABIT_COMMAND;
  EXPECT_LT(std::filesystem::file_size(command),
            std::filesystem::file_size(command.parent_path() / "inhabit-verbs") / 5);
  EXPECT_EQ(run_program("ldd " INHABIT_COMMAND " | grep -c torch").out, "0\n");
  EXPECT_EQ(run_command("info /no/such/file").exit_code, 2);
  // A pipe that nobody has written to: the shell opens it once the verb does, which the signal then reaches.
  const TempFolder folder;
  const std::string pipe = folder / "walk.bvh";
  const CommandResult killed = run_program("timeout 60 sh -c 'mkfifo " + pipe + "; " INHABIT_COMMAND " info " + pipe +
                                           " >/dev/null & pid=$!; exec 3>" + pipe + "; kill -TERM $pid; wait $pid'");
  EXPECT_EQ(killed.exit_code, 128 + 15);
}

TEST(Command, SaysSoWhereItsProgramIsMissing) {
  const TempFolder folder;
  std::filesystem::copy_file(INHABIT_COMMAND, folder / "inhabit");
  const CommandResult r = run_program(folder / "inhabit" + " info x");
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_NE(r.err.find("cannot be started"), std::string::npos) << r.err;
  EXPECT_EQ(run_program(folder / "inhabit" + " --version").exit_code, 0);
}

/// Through a link, as people put programs into their path.
TEST(Command, IsFoundThroughALink) {
  const TempFolder folder;
  std::filesystem::create_symlink(INHABIT_COMMAND, folder / "linked");
  EXPECT_EQ(run_program(folder / "linked" + " info --help").exit_code, 0);
}
