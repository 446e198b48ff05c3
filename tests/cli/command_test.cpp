#include "cli/command.h"

TEST(Command, WithoutAVerbSaysSoInOneLineAndExitsTwo) {
  const CommandResult r = run_command("");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
}

TEST(Command, VersionNamesLibTorch) {
  const CommandResult r = run_command("version");
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_NE(r.out.find("LibTorch"), std::string::npos);
}
