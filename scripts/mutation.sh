#!/usr/bin/env bash
# mutation.sh [MODEL...]: the tests of tests/rtl on more than a thousand mutants of the blocks and the board, or those of the
# models named (Vsp_fifo, ...). Builds them in build/release; see tests/netlist/mutation.py for what is counted. Exit status 1 below
# 95 % killed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=build/release
[[ -e $build/build.ninja ]] || cmake --preset release --log-level=NOTICE
cmake --build "$build" --target mutants_all
exec python3 tests/netlist/mutation.py "$build/tests/netlist" "$@"
