#!/usr/bin/env bash
# Formatting of every C++ file, whether git lets the scripts be run, and clang-tidy on the sources that differ from the
# main branch (on the main branch: from the commit before; without history: all). What takes time is LibTorch's headers,
# so the changed sources of a module are read at once, and at most LINT_UNITS (default 8) modules, those with most of them.
# usage: scripts/lint.sh [--all | SOURCE...]     --all: clang-tidy on every source of inhabit/ and cli/
set -euo pipefail
cd -P "$(dirname "$0")/.."  # as CMake and the units name files
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
limit=${LINT_UNITS:-8}
case ${1:-} in
  --all) mapfile -t sources < <(git ls-files 'inhabit/*.cpp' 'cli/*.cpp'); limit=1000 ;;
  "") mapfile -t sources < <(changed | sources_of) ;;
  *) sources=("$@"); limit=1000 ;;
esac
if [ ${#sources[@]} -eq 0 ]; then echo "clang-tidy: no source changed"; exit 0; fi

# clang takes the commands of the release build, but not its precompiled headers and some of its warnings, which are
# GCC's; what is an error here .clang-tidy says. Of the build's units only the lines of these sources are left.
rm -rf build/lint
cmake --preset release -B build/lint >/dev/null
sed -i -E "s# -(Winvalid-pch|Werror|Wno-restrict|Wno-stringop-overflow|Wno-subobject-linkage)##g; s#-include [^ \"]*/cmake_pch\\.hxx#-include ATen/core/ivalue.h -include $PWD/cmake/pch.h#g" \
  build/lint/compile_commands.json
printf "\"$PWD/%s\"\n" "${sources[@]}" >build/lint/wanted.txt
units=()
: >build/lint/found.txt
for unit in build/lint/CMakeFiles/inhabit*.dir/Unity/*.cxx build/lint/cli/CMakeFiles/*.dir/Unity/*.cxx; do
  here=$(grep -F -f build/lint/wanted.txt "$unit") && printf '%s\n' "$here" >"$unit" && units+=("$(wc -l <<<"$here") $PWD/$unit")
  grep -o '"/.*"' <<<"$here" >>build/lint/found.txt || true
done
# What the build reads by itself: kernels, TinyGLTF.
mapfile -t -O ${#units[@]} units < <(grep -v -x -F -f build/lint/found.txt build/lint/wanted.txt | tr -d '"' | sed 's/^/1 /')
mapfile -t units < <(printf '%s\n' "${units[@]}" | sort -rn | head -n "$limit")
printf '%s\n' "${units[@]#* }" |
  OMP_NUM_THREADS=1 xargs -P "$(nproc)" -n 1 clang-tidy -p build/lint --quiet 2> >(grep -v -E 'warnings? generated|^Suppressed|^Use -header' >&2)
read_sources=$(printf '%s\n' "${units[@]}" | awk '{n += $1} END {print n}')
echo "clang-tidy: $read_sources of ${#sources[@]} sources"
