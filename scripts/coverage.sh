#!/usr/bin/env bash
# coverage.sh [--no-build]: line and toggle coverage of rtl/ by the tests of its blocks and of the board. It builds them
# with counting models in build/coverage, runs them (the first 20 cases of each random test), lists every point that no
# test reached, and compares the list with tests/rtl/coverage_exceptions.txt.
# The exit status is 1 if a point was not reached and no exception gives a reason, or if an exception is not needed any
# more.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=build/coverage
case "${1:-}" in
  --no-build) ;;
  "")
    cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG" \
      -DSELFPROJ_COVERAGE=ON >/dev/null
    cmake --build "$build" --target rtl_blocks board_test board_codes_test
    ;;
  *)
    echo "coverage.sh: $1: unknown; usage: scripts/coverage.sh [--no-build]" >&2
    exit 2
    ;;
esac

rm -rf "$build/counts"
mkdir -p "$build/counts"
export SELFPROJ_CASES=20 SELFPROJ_COVERAGE_FILE="$PWD/$build/counts/coverage.dat"
# The longest first. Each runs in one program, so that the tests share a model and its resets are counted.
# shellcheck disable=SC2016  # $0 and $1 are those of the inner bash
printf '%s\n' 'board/board_test Board.*' 'board/board_codes_test CodesBoard.*:RunsBoard.*' 'blocks/rtl_blocks *' |
  (cd "$build/tests/rtl" && xargs -L 1 -P "$(nproc)" bash -c '"./$0" --gtest_brief=1 "--gtest_filter=$1"')
unset SELFPROJ_CASES SELFPROJ_COVERAGE_FILE
python3 scripts/coverage_report.py --exceptions tests/rtl/coverage_exceptions.txt "$build/counts"
