#pragma once
#include <cstdio>
#include <cstdlib>
#include <iostream>

/// Runs `inhabit ARGUMENTS`. @param argv the program's name, then the arguments
/// @return the exit code: 0; 2 where what was given does not fit, said in one line on stderr; 3 for a fault of
/// inhabit's
int run_command_line(int argc, char** argv);

/// Ends the program.
[[noreturn]] inline void leave(int code) {
#ifdef INHABIT_LEAVE_AT_ONCE
  // Otherwise LibTorch would unregister its operators one by one, a sixth of a short command's time.
  std::cout.flush();
  std::fflush(nullptr);
  std::_Exit(code);
#else
  std::exit(code);  // where leaks and coverage are reported
#endif
}
