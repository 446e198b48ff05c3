#!/usr/bin/env bash
# Makes the HTML site of docs/ and the headers: build/site/index.html. Installs Doxygen and its theme where they are missing.
# Exit code 1 where a link leads nowhere, a comment is not understood, a public name has none, or functions are not listed at all.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/dependencies.sh site
rm -rf build/site
mkdir -p build/site
headers=$(grep '^inhabit/' cmake/public_headers.txt | tr '\n' ' ')
{ cat docs/Doxyfile; echo "INPUT += $headers"; } | doxygen - 2> build/site/warnings.txt
if grep -E 'warning:|error:' build/site/warnings.txt; then exit 1; fi
rm build/site/warnings.txt
# Doxygen is silent about names in a namespace or file that has no comment of its own: it leaves them out.
lists() {  # page, function
  grep -q "<td class=\"memItemRight\".*>$2<" "build/site/$1" || { echo "build/site/$1 does not list $2"; exit 1; }
}
for name in $(grep -rhoE '^namespace inhabit(::[a-z_]+)?' inhabit --include='*.h' | sort -u | sed 's/namespace //'); do
  [ -f "build/site/namespace${name//::/_1_1}.html" ] || { echo "docs/namespaces.dox does not say what $name is"; exit 1; }
done
lists namespaceinhabit.html read_clip
lists files_8h.html inhabit::read_clip
lists inhabit_8h.html inhabit_clip_read
echo "build/site/index.html"
