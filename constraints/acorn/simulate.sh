#!/usr/bin/env bash
# simulate.sh [--lint] [--frames N] [--images] [--ready PERCENT] [--seed N] [--keep]: simulates the FPGA of the Acorn with
# LitePCIe's core, from the test camera to the packets of PCI Express, and the host's device for LitePCIe behind it. The
# board sends N frames (40); each packet must be that of the models, and none may be missing. PERCENT of the clocks the
# host takes packets (90). --lint only lints the top. --keep records the figures in the folder results. SELFPROJ_BUILD
# names the folder of the build with the driver and the models, if it is not build/release. Where PyPI is not reached the
# script says so and exits with status 77.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

options=()
keep=false
lint=false
while (($# > 0)); do
  case $1 in
    --frames | --ready | --seed) options+=("$1" "${2:?"simulate.sh: $1 needs a number"}"); shift 2 ;;
    --images) options+=("$1"); shift ;;
    --keep) keep=true; shift ;;
    --lint) lint=true; shift ;;
    *) echo "simulate.sh: $1: unknown; --help lists the options" >&2; exit 2 ;;
  esac
done

# What LitePCIe's generator writes is not linted.
core=$(python3 -B constraints/acorn/litepcie_core.py)
home=$(dirname "$core")
folder=$home/sim
search=()
for room in rtl/*/; do search+=(-y "${room%/}"); done
sources=(constraints/acorn/litepcie.vlt rtl/common/sp_spec_pkg.sv constraints/acorn/{acorn_dma,acorn_system,acorn}.sv
  constraints/common/xilinx7_cells.sv "$core" "$home/pcie_s7.v")
checks=(-Wall -Wno-fatal -Wno-COMBDLY -Wno-TIMESCALEMOD -Wno-UNOPTFLAT --top-module acorn
  '+define+SELFPROJ_PCIE_S7_BODY="constraints/acorn/pcie_s7.svh"')
if $lint; then
  said=$(verilator --lint-only "${checks[@]}" "${search[@]}" "${sources[@]}" 2>&1 >/dev/null) || true
  [[ -z $said ]] || { head -n 20 <<<"$said" >&2; exit 1; }
  echo "the top of the Acorn passes lint"
  exit 0
fi
libraries=(constraints/libselfproj_{scoreboard,board_links}.a host/libselfproj_{driver,files}.a
  model/libselfproj_model.a sim/board/libselfproj_verilator_{interfaces,runtime}.a)
CPATH=$home/driver/kernel constraints/common/verilated_sim.sh "${SELFPROJ_BUILD:-$PWD/build/release}" "$folder" Vacorn \
  constraints/acorn/acorn_sim.cpp "${libraries[@]}" -- -O3 "${checks[@]}" --x-assign fast --x-initial fast --assert \
  "${search[@]}" "${sources[@]}"
status=0
"$folder/sim" "${options[@]}" >"$folder/figures.txt" || status=$?
sed 's/^/    /; s/=/ /' "$folder/figures.txt"
((status == 0)) || { echo "simulate.sh: the counts do not fit" >&2; exit "$status"; }
echo "every packet equals the models', and none is missing"
if $keep; then
  mapfile -t figures <"$folder/figures.txt"
  name=acorn_sim
  [[ " ${options[*]} " == *" --images "* ]] && name=acorn_sim_images
  SELFPROJ_RESULTS=results python3 -B scripts/results.py record "$name" \
    --about "The FPGA of an Acorn in simulation, test camera to packets of PCI Express, and the host's device" \
    --command "constraints/acorn/simulate.sh ${options[*]} --keep" "${figures[@]}"
fi
