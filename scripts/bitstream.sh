#!/usr/bin/env bash
# bitstream.sh ecpix5 [--seed N | --seeds FIRST-LAST] [--address A.B.C.D] [--sensor | --codes] [--jumbo] [--keep]: makes
# a bitstream of the board for an ECPIX-5 with the LFE5UM5G-85F, from Debian and PyPI alone, and says how to load it. It
# prints what the circuit takes and the clocks that each seed of the placement reaches. --sensor makes the parallel
# sensor the camera, in place of the test camera; --codes has the Gray decoder in place of grey moments and raw images.
# --jumbo sends packets in datagrams of up to 8,972 bytes, for a network whose frames may have 9,000 bytes. --keep
# records the figures in the folder results. Where PyPI is not reached it prints one line and exits with status 77.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case ${1:-} in
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/bitstream.sh; exit 0 ;;
  ecpix5) ;;
  *) echo "bitstream.sh: '${1:-}': no such board; usage: scripts/bitstream.sh ecpix5 [OPTION...]" >&2; exit 2 ;;
esac
command -v yosys >/dev/null || scripts/setup.sh >&2
exec python3 -B scripts/bitstream.py "${@:2}"
