#!/usr/bin/env bash
# acorn_sim.sh [--lint] [--frames N] [--images] [--ready PERCENT] [--seed N] [--keep]: simulates the FPGA of the Acorn
# (constraints/acorn), LitePCIe's core included, from the test camera to the packets of PCI Express, and the host's
# device for LitePCIe behind it. The board sends N frames (40); each packet must be that of the models, and none may be
# missing. PERCENT of the clocks the host takes packets (90). --lint only lints the top. --keep records the figures in
# the folder results. SELFPROJ_BUILD names the folder of the build with the driver and the models, if it is not
# build/release. Where PyPI is not reached the script says so and exits with status 77.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."

options=()
keep=false
lint=false
while (($# > 0)); do
  case $1 in
    --frames | --ready | --seed) options+=("$1" "${2:?"acorn_sim.sh: $1 needs a number"}"); shift 2 ;;
    --images) options+=("$1"); shift ;;
    --keep) keep=true; shift ;;
    --lint) lint=true; shift ;;
    *) echo "acorn_sim.sh: $1: unknown; --help lists the options" >&2; exit 2 ;;
  esac
done

# What LitePCIe's generator writes is not linted.
core=$(scripts/litepcie_core.sh)
home=$(dirname "$core")
folder=$home/sim
search=()
for room in rtl/*/; do search+=(-y "${room%/}"); done
sources=(sim/target/litepcie.vlt rtl/common/sp_spec_pkg.sv constraints/acorn/{acorn_dma,acorn_system,acorn}.sv
  sim/target/xilinx7_cells.sv "$core" "$home/pcie_s7.v")
checks=(-Wall -Wno-fatal -Wno-COMBDLY -Wno-TIMESCALEMOD -Wno-UNOPTFLAT --top-module acorn
  '+define+SELFPROJ_PCIE_S7_BODY="sim/target/pcie_s7.svh"')
# Fails where Verilator has an error or a warning.
checked() {
  local log=$1
  shift
  "$@" >"$log" 2>&1 || { grep -m 5 -i error "$log" >&2; exit 1; }
  if grep -m 5 '^%Warning' "$log" >&2; then exit 1; fi
}
mkdir -p "$folder"
checked "$folder/lint.log" verilator --lint-only "${checks[@]}" "${search[@]}" "${sources[@]}"
if $lint; then
  echo "the top of the Acorn passes lint"
  exit 0
fi
libraries=(sim/target/libselfproj_{frame_packets,sim_target}.a host/libselfproj_{driver,files}.a
  model/libselfproj_model.a sim/board/libselfproj_verilator_{interfaces,runtime}.a)
libraries=("${libraries[@]/#/${SELFPROJ_BUILD:-$PWD/build/release}/}")
for library in "${libraries[@]}"; do
  [[ -e $library ]] || { echo "acorn_sim.sh: $library is missing; run scripts/build.sh release all" >&2; exit 2; }
  # make does not know that the simulation depends on the libraries.
  [[ ! $library -nt $folder/acorn_sim ]] || rm -f "$folder/acorn_sim"
done
# What Verilator writes is compiled as one file, because each of its files reads the same headers.
checked "$folder/build.log" verilator --cc --exe --build -j 2 \
  -MAKEFLAGS "VM_PARALLEL_BUILDS=0 OPT_FAST=-O1 VM_GLOBAL_FAST=" -O3 "${checks[@]}" \
  --x-assign fast --x-initial fast --assert "${search[@]}" -Mdir "$folder" -o acorn_sim \
  -CFLAGS "-std=c++20 -I$PWD -I$PWD/$home/driver/kernel" -LDFLAGS "${libraries[*]} -pthread -lz" \
  "${sources[@]}" "$PWD/sim/target/acorn_sim.cpp"
status=0
"$folder/acorn_sim" "${options[@]}" >"$folder/figures.txt" || status=$?
sed 's/^/    /; s/=/ /' "$folder/figures.txt"
((status == 0)) || { echo "acorn_sim.sh: the counts do not fit" >&2; exit "$status"; }
echo "every packet equals the models', and none is missing"
if $keep; then
  mapfile -t figures <"$folder/figures.txt"
  name=acorn_sim
  [[ " ${options[*]} " == *" --images "* ]] && name=acorn_sim_images
  SELFPROJ_RESULTS=results python3 -B scripts/results.py record "$name" \
    --about "The FPGA of an Acorn in simulation, test camera to packets of PCI Express, and the host's device" \
    --command "scripts/acorn_sim.sh ${options[*]} --keep" "${figures[@]}"
fi
