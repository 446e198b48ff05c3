#!/usr/bin/env bash
# Installs what is missing, builds, forecasts on the bundled recordings and rooms, and ends with out/demo/index.html.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/dependencies.sh
cmake --preset release >/dev/null
cmake --build --preset release --target inhabit_command
inhabit=build/release/cli/inhabit
out=out/demo
mkdir -p "$out"
