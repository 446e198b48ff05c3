#!/usr/bin/env bash
# Makes the HTML site of docs/ and the headers: build/site/index.html. Installs Doxygen and its theme where they are missing.
# Exit code 1 where a link leads nowhere or a comment is not understood.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/dependencies.sh site
rm -rf build/site
mkdir -p build/site
doxygen docs/Doxyfile 2> build/site/warnings.txt
if grep -E 'warning:|error:' build/site/warnings.txt; then exit 1; fi
rm build/site/warnings.txt
echo "build/site/index.html"
