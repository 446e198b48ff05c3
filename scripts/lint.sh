#!/usr/bin/env bash
# Formatting of every C++ file, whether git lets the scripts be run, and clang-tidy on the sources that differ from the
# main branch (on the main branch: from the commit before; without history: all). One source takes half a minute of a
# core, so of many only LINT_SOURCES (default 12), evenly spread, are read.
# usage: scripts/lint.sh [--all | SOURCE...]     --all: clang-tidy on every source of inhabit/ and cli/
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t all < <(git ls-files '*.h' '*.cpp')
clang-format --dry-run --Werror "${all[@]}"
echo "clang-format: ${#all[@]} files"

# The bit was lost once, and what calls a script by its path fails then.
if git ls-files -s 'scripts/*.sh' 'scripts/*.mjs' .ci/run | grep -v '^100755'; then echo "scripts: not executable in git (chmod +x)" >&2; exit 1; fi

# What changed since the fork from the main branch.
changed() {
  local head base=""
  head=$(git rev-parse HEAD)
  for main in origin/main main origin/HEAD; do
    base=$(git merge-base "$head" "$main" 2>/dev/null) && [ "$base" != "$head" ] && break || base=""
  done
  [ -n "$base" ] || base=$(git rev-parse --verify --quiet HEAD~1) || base=""
  if [ -n "$base" ]; then
    git diff --name-only --diff-filter=d "$base" -- 'inhabit/*.cpp' 'inhabit/*.h' 'cli/*.cpp' 'cli/*.h'
  else
    git ls-files 'inhabit/*.cpp' 'cli/*.cpp'
  fi
}
# A header is read through the source beside it, or through the first that includes it.
sources_of() {
  while read -r file; do
    case $file in
      *.cpp) echo "$file" ;;
      *) if [ -f "${file%.h}.cpp" ]; then echo "${file%.h}.cpp"; else
           git grep -l -F "#include \"${file#cli/}\"" -- 'inhabit/*.cpp' 'cli/*.cpp' | head -n 1 || true; fi ;;
    esac
  done | sort -u
}
limit=${LINT_SOURCES:-12}
case ${1:-} in
  --all) mapfile -t sources < <(git ls-files 'inhabit/*.cpp' 'cli/*.cpp'); limit=${#sources[@]} ;;
  "") mapfile -t sources < <(changed | sources_of) ;;
  *) sources=("$@"); limit=$# ;;
esac
if [ ${#sources[@]} -eq 0 ]; then echo "clang-tidy: no source changed"; exit 0; fi
count=${#sources[@]}
[ "$count" -le "$limit" ] ||
  mapfile -t sources < <(printf '%s\n' "${sources[@]}" | awk -v n="$count" -v l="$limit" 'NR * l % n < l')

# clang takes the commands of the release build, source by source, but not its precompiled header and some of its
# warnings, which are GCC's; what is an error here .clang-tidy says.
cmake --preset release -B build/lint -DINHABIT_UNITY=OFF >/dev/null
sed -i -E "s# -(Winvalid-pch|Werror|Wno-restrict|Wno-stringop-overflow)##g; s#-include [^ \"]*/cmake_pch\\.hxx#-include ATen/core/ivalue.h -include $PWD/cmake/pch.h#g" \
  build/lint/compile_commands.json
printf '%s\n' "${sources[@]}" |
  OMP_NUM_THREADS=1 xargs -P "$(nproc)" -n 1 clang-tidy -p build/lint --quiet 2> >(grep -v -E 'warnings? generated|^Suppressed|^Use -header' >&2)
echo "clang-tidy: ${#sources[@]} of $count sources"
