#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// A reader under test: takes any bytes, and either returns (true) or throws inhabit::Error (false).
struct FuzzTarget {
  std::string name;                     ///< also the folder of its seeds in tests/fuzz/seeds
  bool (*run)(const uint8_t*, size_t);  ///< lets every other exception through, to be seen as a fault
};

const std::vector<FuzzTarget>& fuzz_targets();

/// Makes what the target's reader makes once and keeps: seconds under sanitizers, no fault of the input at hand.
void prepare_fuzzing(const std::string& target);
