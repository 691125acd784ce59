#!/usr/bin/env bash
# mutation.sh [MODEL...]: runs the tests of tests/rtl on more than a thousand mutants of the blocks and the board, or on
# those of the models named (Vsp_fifo, ...). It builds them in build/release; tests/netlist/mutation.py says what
# counts. The exit status is 1 if fewer than 95 % are killed.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."

[[ ${1:-} != -* ]] || { echo "mutation.sh: $1: unknown; usage: scripts/mutation.sh [MODEL...]" >&2; exit 2; }
build=build/release
[[ -e $build/build.ninja ]] || cmake --preset release --log-level=NOTICE
cmake --build "$build" --target mutants_all
exec python3 tests/netlist/mutation.py "$build/tests/netlist" "$@"
