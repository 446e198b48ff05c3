#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/command.h"
#include "inhabit/io/atomic_file.h"
#include "temp_folder.h"

namespace inhabit {

/// An evaluation in two parts, the second first, ends in the table of one run, and no part is left.
inline void expect_shards_alike(const std::string& evaluation) {
  const TempFolder folder;
  const std::string whole = folder / "whole.json", table = folder / "table.json";
  const CommandResult once = run_command(evaluation + " --json " + whole);
  ASSERT_EQ(once.exit_code, 0) << once.err;
  const CommandResult first = run_command(evaluation + " --json " + table + " --shard 2/2");
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, ::testing::HasSubstr("shard 2-of-2 is measured; the others are still to come"));
  EXPECT_FALSE(std::filesystem::exists(table));
  const CommandResult last = run_command(evaluation + " --json " + table + " --shard 1/2");
  ASSERT_EQ(last.exit_code, 0) << last.err;
  EXPECT_EQ(last.out, once.out);
  EXPECT_EQ(nlohmann::json::parse(read_whole_file(table)), nlohmann::json::parse(read_whole_file(whole)));
  for (const auto& entry : std::filesystem::directory_iterator(folder.path))
    EXPECT_EQ(entry.path().extension(), ".json") << entry.path() << " is in the table";
}

}  // namespace inhabit
