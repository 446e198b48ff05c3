#!/usr/bin/env bash
# Builds the libFuzzer programs with clang and runs them one after the other; a finding is left in build/fuzz/found.
# usage: scripts/fuzz.sh [SECONDS [TARGET...]]     60 seconds for each folder of tests/fuzz/seeds by default
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
targets=("${@:2}")
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <(ls tests/fuzz/seeds)
cmake -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O1 -g1" \
  -DCMAKE_CXX_COMPILER=clang++ -DINHABIT_BUILD_FUZZERS=ON -DINHABIT_BUILD_TESTS=OFF >/dev/null
ninja -C build/fuzz "${targets[@]/#/fuzz_}"
export OMP_NUM_THREADS=1
mkdir -p build/fuzz/found
failed=()
for t in "${targets[@]}"; do
  mkdir -p "build/fuzz/corpus/$t"
  echo "== $t"
  case $t in *_model) longest=1048576 ;; *) longest=65536 ;; esac  # bytes: networks are no smaller
  "build/fuzz/tests/fuzz/fuzz_$t" -max_total_time="$seconds" -rss_limit_mb=2048 -timeout=10 -max_len=$longest \
    -print_final_stats=1 -artifact_prefix="build/fuzz/found/$t-" "build/fuzz/corpus/$t" "tests/fuzz/seeds/$t" \
    >"build/fuzz/corpus/$t.log" 2>&1 || failed+=("$t")
  grep -E 'SUMMARY|number_of_executed_units' "build/fuzz/corpus/$t.log" || true
done
[ ${#failed[@]} -eq 0 ] || { echo "found in: ${failed[*]} (build/fuzz/corpus/TARGET.log)"; exit 1; }
