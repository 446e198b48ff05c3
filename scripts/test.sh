#!/usr/bin/env bash
# Installs what is missing, builds, and runs the whole test suite.
# usage: scripts/test.sh [release|dev|coverage]     dev: under the address and undefined-behaviour sanitizers;
#   coverage: ends with the lines reached, in build/coverage/report/index.html
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
scripts/dependencies.sh "$([ "$preset" = coverage ] && echo coverage || echo test)"
cmake --preset "$preset" ${CI:+-DINHABIT_WERROR=ON} >/dev/null
cmake --build --preset "$preset"
# The glTF validator; without a network its test is skipped.
[ -d tests/gltf_validator/node_modules ] || npm ci --silent --no-audit --no-fund --prefix tests/gltf_validator || true
ctest --test-dir "build/$preset" --output-on-failure -j "$(nproc)"
if [ "$preset" = coverage ]; then
  lcov --quiet --capture --directory build/coverage --include "$PWD/inhabit/*" --include "$PWD/cli/*" --output-file build/coverage/lines.info
  genhtml --quiet --prefix "$PWD" --output-directory build/coverage/report build/coverage/lines.info
  lcov --summary build/coverage/lines.info
fi
