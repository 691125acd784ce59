#!/usr/bin/env bash
# run.sh [FOLDER]: translates the SystemC shells to SystemVerilog by ICSC 1.6.8 (commit 7e86dff), if ICSC_HOME names an
# installation, adds the memories, lints the result with Verilator, and replays recordings of the RTL's benches in it: every output
# must be equal. What it makes is in FOLDER (build/icsc). The program with the benches is built if it is not there.
# docs/hls.md says how to get and build ICSC.
#
# SELFPROJ_RTL_BLOCKS names the program with the benches (build/release/tests/rtl/blocks/rtl_blocks).
# SELFPROJ_RECORD_STEPS is how many evaluations of each bench are recorded (100,000).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

to=${1:-build/icsc}
benches=${SELFPROJ_RTL_BLOCKS:-build/release/tests/rtl/blocks/rtl_blocks}
if [[ -z ${ICSC_HOME:-} ]]; then
  echo "icsc/run.sh: skipped: ICSC_HOME is not set"
  exit 0
fi
export ICSC_HOME
[[ -d $ICSC_HOME ]] || { echo "icsc/run.sh: ICSC_HOME: $ICSC_HOME is not a folder" >&2; exit 2; }

# The translators load libraries of the tool.
export LD_LIBRARY_PATH=$ICSC_HOME/lib:$ICSC_HOME/lib64${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}

shells=(column_moments column_runs gray_decoder median3x3 verdict)
mkdir -p "$to"
for name in "${shells[@]}"; do
  python3 hls/icsc/bench.py "$name" >"$to/$name.cpp"
done
cmake -S hls/icsc -B "$to" -DCMAKE_PREFIX_PATH="$ICSC_HOME" -DCMAKE_BUILD_TYPE=Release
for name in "${shells[@]}"; do
  cmake --build "$to" --target "${name}_shell_sctool"
  (cd "$to" && "./${name}_shell_sctool")
  [[ -s $to/sv_out/${name}_shell.sv ]] ||
    { echo "icsc/run.sh: $to/sv_out/${name}_shell.sv was not written" >&2; exit 1; }
done

[[ -x $benches ]] || scripts/build.sh release rtl_blocks
SELFPROJ_RTL_BLOCKS=$benches python3 hls/icsc/replay.py "$to/sv_out" "$to/replay"
echo "icsc/run.sh: five shells translated, linted and replayed → $to/sv_out"
