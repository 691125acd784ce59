#!/usr/bin/env bash
# Every check and test of the project: generated files, format, RTL lint, the build of two presets, clang-tidy, and the
# tests, first some of them with the sanitizers, then all of them built for speed. Stops at the first failure.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

step() { printf '\n== %s\n' "$*"; }

scripts/setup.sh

step "headers of HLS tools"
hls/get_ap_types.sh || echo "the kernels are not tested with the vendor's integers"

step "generated files"
python3 model/spec/generate.py --check
echo "they are what model/spec/selfproj.json gives"

step "format of the C++ sources"
mapfile -t files < <(git ls-files --cached --others --exclude-standard '*.cpp' '*.h' | grep -v '/generated/')
clang-format-14 --dry-run --Werror "${files[@]}"
echo "${#files[@]} files"

step "lint of the RTL"
scripts/lint_rtl.sh

step "build: all for speed, what works on raw memory with the sanitizers"
scripts/build.sh release
scripts/build.sh sanitizers sanitized_tests

# Tests and benchmarks are left to scripts/tidy.sh by hand: a source takes some ten seconds, and there are 150.
step "clang-tidy of host, model and sim"
mapfile -t files < <(git ls-files --cached --others --exclude-standard 'host/*.cpp' 'model/*.cpp' 'sim/*.cpp' | grep -v '/generated/')
scripts/tidy.sh "${files[@]}"

step "tests with the sanitizers"
# What has not been built has no label.
ctest --preset sanitizers --label-regex '^(unit|host)$' --parallel "$(nproc)" --progress

step "all tests"
ctest --preset release --parallel "$(nproc)" --progress
