#!/usr/bin/env bash
# Installs what is missing, builds, and runs the whole test suite.
# usage: scripts/test.sh [release|dev|coverage]     dev: under the address and undefined-behaviour sanitizers
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
scripts/dependencies.sh test
cmake --preset "$preset" ${CI:+-DINHABIT_WERROR=ON} >/dev/null
cmake --build --preset "$preset"
# The glTF validator; without a network its test is skipped.
[ -d tests/gltf_validator/node_modules ] || npm ci --silent --no-audit --no-fund --prefix tests/gltf_validator || true
export OMP_WAIT_POLICY=passive
ctest --test-dir "build/$preset" --output-on-failure -j "$(nproc)"
