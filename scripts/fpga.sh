#!/usr/bin/env bash
# fpga.sh [table [--module NAME] [FAMILY...] | place [--seeds N] | update [--seeds N] | stale]: prints the resources
# that the board, or another module, takes in five FPGA families (table, the default), or the clock that the board
# reaches on an iCE40 HX8K and, with nextpnr-ecp5 from PyPI, on an LFE5U-85F (place). update measures what is stale of
# both and writes it into constraints/README.md; stale lists it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

command -v yosys >/dev/null || scripts/setup.sh >&2
if [[ ${1:-} == place || ${1:-} == update ]] && ! command -v nextpnr-ice40 >/dev/null; then
  echo "fpga.sh: nextpnr-ice40: not installed; apt-get install nextpnr-ice40" >&2
  exit 2
fi
exec python3 scripts/fpga.py "${@:-table}"
