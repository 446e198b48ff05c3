#pragma once
#include <unistd.h>

#include <cstdlib>

namespace inhabit {

/// To be called first in main(): starts the program over once with OMP_WAIT_POLICY=passive, unless the variable is set.
/// Spinning OpenMP threads cost small products up to four times their time, and the runtime reads the policy before
/// main() runs. Where /proc is missing the program goes on with the runtime's own policy.
inline void use_passive_waiting(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  setenv("OMP_WAIT_POLICY", "passive", 1);
  execv("/proc/self/exe", argv);
}

}  // namespace inhabit
