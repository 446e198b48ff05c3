#!/usr/bin/env bash
# Installs what inhabit builds and tests with, on Debian 12 (root or sudo). Does nothing where all of it is there.
# usage: scripts/dependencies.sh [test|coverage|site]     also what only the tests and checks, their coverage, or the HTML site use
set -euo pipefail
packages=(g++ cmake ninja-build pkg-config nodejs libtorch-dev libgloo-dev libopenblas-dev libboost-dev libembree-dev libassimp-dev libnanoflann-dev libeigen3-dev
  libtinygltf-dev nlohmann-json3-dev libcli11-dev libspdlog-dev libfmt-dev libzip-dev zipcmp zipmerge ziptool zlib1g-dev libpng-dev libbenchmark-dev
  python3-dev python3-venv pybind11-dev python3-numpy)
[[ "${1:-}" =~ ^(test|coverage)$ ]] && packages+=(libgtest-dev libgmock-dev libceres-dev chromium libegl1 clang-format clang-tidy git python3-pip python3-pytest python3-mypy python3-torch doxygen doxygen-awesome-css blender zsh fish)
[ "${1:-}" = coverage ] && packages+=(lcov)
[ "${1:-}" = site ] && packages=(doxygen doxygen-awesome-css)
# A Node.js from elsewhere brings its own npm; Debian's comes as two packages.
command -v node >/dev/null && packages=("${packages[@]/nodejs/}")
command -v npm >/dev/null || packages+=(npm)
missing=()
for p in "${packages[@]}"; do
  [ -z "$p" ] || dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing+=("$p")
done
[ ${#missing[@]} -eq 0 ] && exit 0
sudo=""
[ "$(id -u)" -eq 0 ] || sudo=sudo
echo "installing: ${missing[*]}"
$sudo apt-get update -qq
DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
