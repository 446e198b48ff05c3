#pragma once
#include "cli/command.h"

/// A data set of three rooms, one each for training, validation and test, with two clips of four seconds in each.
/// Returns its folder.
inline std::string make_tiny_rooms(const TempFolder& folder) {
  const std::string rooms = folder / "rooms";
  const CommandResult r = run_command("synth rooms --clips 6 --clips-per-room 2 --seconds 4 --seed 3 --out " + rooms);
  EXPECT_EQ(r.exit_code, 0) << r.err;
  return rooms;
}
