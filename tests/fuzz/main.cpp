// libFuzzer's entry for one target, chosen when compiled: -DFUZZ_TARGET="npz".
#include <algorithm>
#include <cstdlib>

#include "targets.h"

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  prepare_fuzzing(FUZZ_TARGET);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const FuzzTarget* target = [] {
    for (const FuzzTarget& t : fuzz_targets())
      if (t.name == FUZZ_TARGET) return &t;
    std::abort();
  }();
  target->run(data, size);
  return 0;
}
