#pragma once
#include <algorithm>

#include <gmock/gmock.h>

#include "cli/command.h"

/// What every verb owes to bad input: exit code 2, one line on stderr that holds `parts` (the file, the reason),
/// nothing on stdout, and nothing in `out`, the folder that the outputs were to go to.
inline void expect_refused(const std::string& arguments, const std::vector<std::string>& parts,
                           const std::string& out) {
  const CommandResult r = run_command(arguments);
  EXPECT_EQ(r.exit_code, 2) << arguments << "\n" << r.err;
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << arguments << "\n" << r.err;
  for (const std::string& part : parts) EXPECT_THAT(r.err, ::testing::HasSubstr(part)) << arguments;
  EXPECT_EQ(r.out, "") << arguments;
  for (const auto& entry : std::filesystem::directory_iterator(out))
    ADD_FAILURE() << arguments << "\nleft " << entry.path();
}
