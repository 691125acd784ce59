#!/usr/bin/env bash
# run.sh [FOLDER]: translates the SystemC shells to SystemVerilog by ICSC 1.6.8, if ICSC_HOME names an installation,
# adds the memories, and lints the result with Verilator. The results are in FOLDER (build/icsc). It has not been run
# yet: ICSC comes as sources that build LLVM.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

to=${1:-build/icsc}
if [[ -z ${ICSC_HOME:-} ]]; then
  echo "icsc/run.sh: skipped: ICSC_HOME is not set"
  exit 0
fi
[[ -d $ICSC_HOME ]] || { echo "icsc/run.sh: ICSC_HOME: $ICSC_HOME is no folder" >&2; exit 2; }

cmake -S hls/icsc -B "$to" -DCMAKE_PREFIX_PATH="$ICSC_HOME" -DCMAKE_BUILD_TYPE=Release
for name in column_moments gray_decoder median3x3; do
  cmake --build "$to" --target "${name}_shell_sctool"
  (cd "$to" && "./${name}_shell_sctool")
  [[ -s $to/sv_out/${name}_shell.sv ]] ||
    { echo "icsc/run.sh: $to/sv_out/${name}_shell.sv was not written" >&2; exit 1; }
done

# ICSC has a style of its own, so only the messages that may mean a fault count.
lint() { verilator --lint-only --top-module "$1" -Wno-style rtl/common/sp_ram.sv "${@:2}"; }
lint sp_column_moments_hls "$to/sv_out/column_moments_shell.sv" hls/icsc/sp_column_moments_hls.sv
lint sp_median3x3_hls "$to/sv_out/median3x3_shell.sv" hls/icsc/sp_median3x3_hls.sv
lint hls_GrayDecoderShell "$to/sv_out/gray_decoder_shell.sv"
echo "icsc/run.sh: three shells translated and linted → $to/sv_out"
