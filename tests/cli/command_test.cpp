#include "cli/command.h"

TEST(Command, WithoutAVerbSaysSoInOneLineAndExitsTwo) {
  const CommandResult r = run_command("");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
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
  const CommandResult killed =
      run_program("sh -c '" INHABIT_COMMAND " eval forecast --help >/dev/null & pid=$!; kill -TERM $pid; wait $pid'");
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
