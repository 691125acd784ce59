#!/usr/bin/env bash
# build.sh [PRESET [TARGET...]]: installs missing packages, configures, and builds. PRESET is release (default), ci,
# quick, dev or sanitizers (docs/contributing.md). Without a TARGET it builds the programs alone; TARGET all builds the tests as well. Targets
# selfproj_demo and selfproj-sim_demo build variants with only the commands that scripts/demo.sh shows.
# Preset release builds for speed and puts the programs into build/bin/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case ${1:-release} in
  release | ci | quick | dev | sanitizers) ;;
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/build.sh; exit 0 ;;
  *) echo "build.sh: $1: no such preset; usage: scripts/build.sh [release|ci|quick|dev|sanitizers [TARGET...]]" >&2; exit 2 ;;
esac
preset=${1:-release}
folder=build/$preset
if [[ $preset == ci ]]; then folder=build/release; fi
targets=("${@:2}")
((${#targets[@]} > 0)) || targets=(programs)

tests=false
for target in "${targets[@]}"; do
  case $target in
    programs | selfproj | selfproj-sim | selfproj_demo | selfproj-sim_demo) ;;
    -*) echo "build.sh: $target: no target; usage: scripts/build.sh [PRESET [TARGET...]]" >&2; exit 2 ;;
    *) tests=true ;;
  esac
done

options=()
if $tests; then
  scripts/setup.sh tests
  options=(-DBUILD_TESTING=ON)
else
  scripts/setup.sh programs
  # A folder that has been configured with the tests keeps them; they are just not built.
  [[ -e $folder/CMakeCache.txt ]] || options=(-DBUILD_TESTING=OFF)
fi
# ccache keeps what was compiled before, where it is installed.
if [[ ! -e $folder/CMakeCache.txt ]] && command -v ccache >/dev/null; then
  options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
export CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_BASEDIR=$PWD
cmake --preset "$preset" --log-level=NOTICE "${options[@]}" >/dev/null
# One compiler a processor: ninja would start two more, which push each other out of the caches (a fifth of the time).
cmake --build --preset "$preset" --parallel "$(nproc)" --target "${targets[@]}"
