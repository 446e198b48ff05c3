#pragma once
#include <sched.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

namespace inhabit {

/// Sets what OpenMP and LibTorch read before main(), where nobody has: OMP_WAIT_POLICY=passive, because spinning
/// threads cost small products up to four times their time, and OMP_NUM_THREADS to the number of cores that the process
/// may use, because LibTorch counts by itself and on some virtual machines finds one of two.
inline void set_thread_variables() {
  setenv("OMP_WAIT_POLICY", "passive", 0);
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof cores, &cores) == 0)
    setenv("OMP_NUM_THREADS", std::to_string(CPU_COUNT(&cores)).c_str(), 0);
}

/// To be called first in main(): starts the program over once with these variables, unless OMP_WAIT_POLICY is set.
/// Where /proc is missing the program goes on as it is.
inline void start_with_thread_variables(char** argv) {
  if (std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  set_thread_variables();
  execv("/proc/self/exe", argv);
}

}  // namespace inhabit
