#!/usr/bin/env bash
# Formatting of every C++ file.
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t all < <(git ls-files '*.h' '*.cpp')
clang-format --dry-run --Werror "${all[@]}"
echo "clang-format: ${#all[@]} files"
