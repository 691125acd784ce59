#!/usr/bin/env bash
# wheel.sh [BUILD]: makes a wheel of the Python package for the python3 of the path, with the libraries of a build,
# build/release unless another is named. It lies in build/wheels/. It is for this release of Debian with the shared
# libraries of `scripts/setup.sh programs`, where `pip install` of it takes seconds. The last line names it.
#
# Takes the time of the bindings alone, about a minute of a processor core, and nothing where they are up to date. What it
# needs comes from PyPI; where that is not reached it says so, and its exit status is 77.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=$(realpath "${1:-build/release}")
[[ -f $build/selfproj_libraries.cmake ]] || { echo "wheel.sh: $build: is no build of the project" >&2; exit 2; }
tools=$(python3 -B scripts/lib/pypi.py build/wheel-tools nanobind==3.1.0 scikit-build-core==1.1.2) || exit
mkdir -p build/wheels
"$tools/python3" -m pip --quiet --disable-pip-version-check wheel --no-build-isolation --no-deps --no-index \
  --config-settings "cmake.define.SELFPROJ_BUILT=$build" --wheel-dir build/wheels .
wheel=$(find "$PWD/build/wheels" -name 'selfproj-*.whl' -printf '%T@ %p\n' | sort -n | tail -1 | cut -d ' ' -f 2)
echo "$wheel"
