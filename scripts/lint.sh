#!/usr/bin/env bash
# Formatting of every C++ file, whether git lets the scripts be run, and clang-tidy on the sources that differ from the
# main branch (on the main branch: from the commit before; without history: all). Sources that the build compiles
# together (a module, twelve of cli/) are read at once, since LibTorch's headers take most of the time. At most
# LINT_UNITS (default 8) of these units are read, those with the most changed sources first.
# usage: scripts/lint.sh [--all | SOURCE...]     --all: clang-tidy on every source of inhabit/ and cli/
set -euo pipefail
cd -P "$(dirname "$0")/.."  # as CMake and the units name files
# Files that git knows and that are there: one that was deleted stays in its list until that is staged.
there() { git ls-files "$@" | while read -r file; do if [ -f "$file" ]; then echo "$file"; fi; done; }
files=$(there '*.h' '*.cpp')
mapfile -t all <<<"$files"
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
limit=${LINT_UNITS:-8}
case ${1:-} in
  --all) list=$(there 'inhabit/*.cpp' 'cli/*.cpp') ;;
  "") list=$(changed | sources_of) ;;
  *) list=$(realpath --relative-to=. -- "$@") ;;
esac
if [ -z "$list" ]; then echo "clang-tidy: no source changed"; exit 0; fi
mapfile -t sources <<<"$list"
[ $# -eq 0 ] || limit=${#sources[@]}

# clang takes the commands of the release build, but not its precompiled headers and some of its warnings, which are
# GCC's; what is an error here .clang-tidy says. Of the build's units only these sources are left: their text itself, for
# clang's analyzer follows paths in the file that it is given and not in one that is included. Messages name the unit's
# lines, to be counted from the #line above.
rm -rf build/lint
cmake --preset release -B build/lint >/dev/null
sed -i -E "s# -(Winvalid-pch|Werror|Wno-restrict|Wno-stringop-overflow|Wno-subobject-linkage)##g; s#-include [^ \"]*/cmake_pch\\.hxx#-include ATen/core/ivalue.h -include $PWD/cmake/pch.h#g" \
  build/lint/compile_commands.json
printf '"%s"\n' "${sources[@]/#/$PWD/}" >build/lint/wanted.txt
units=()
: >build/lint/found.txt
for unit in build/lint/CMakeFiles/inhabit*.dir/Unity/*.cxx build/lint/cli/CMakeFiles/*.dir/Unity/*.cxx; do
  here=$(grep -F -f build/lint/wanted.txt "$unit") || continue
  sed -E 's/^#include "(.*)"$/\1/' <<<"$here" |
    while read -r source; do printf '#line 1 "%s"\n' "$source"; cat "$source" || exit 1; done >"$unit"
  units+=("$(wc -l <<<"$here") $PWD/$unit")
  grep -o '"/.*"' <<<"$here" >>build/lint/found.txt
done
# What no unit has: kernels, TinyGLTF, the built-in body's file, data_parallel.cpp, and named files that are not of the
# library or cli/ (clang-tidy takes the command of the nearest file for them).
mapfile -t -O ${#units[@]} units < <(grep -v -x -F -f build/lint/found.txt build/lint/wanted.txt | tr -d '"' | sed 's/^/1 /')
mapfile -t units < <(printf '%s\n' "${units[@]}" | sort -rn | head -n "$limit")
tidy() {
  local checks=""  # of a module's own .clang-tidy, which clang-tidy does not look for beside a unit
  case $1 in */unity_refine_*) checks=$(sed -n "s/^Checks: *'\(.*\)'/\1/p" inhabit/refine/.clang-tidy) ;; esac
  # What a source includes by a bare name lies beside it, not beside the unit.
  clang-tidy -p build/lint --quiet --extra-arg=-iquote"$PWD/cli" --extra-arg=-iquote"$PWD/cli/launcher" ${checks:+--checks="$checks"} "$1"
}
export -f tidy
printf '%s\n' "${units[@]#* }" |
  OMP_NUM_THREADS=1 xargs -d '\n' -P "$(nproc)" -I{} bash -c 'tidy "$1"' _ {} 2> >(grep -v -E 'warnings? generated|^Suppressed|^Use -header' >&2)
read_sources=$(printf '%s\n' "${units[@]}" | awk '{n += $1} END {print n}')
echo "clang-tidy: $read_sources of ${#sources[@]} sources"
