#!/usr/bin/env bash
# resources.sh [--update] [--depth N] [MODULE]: what the circuit takes of a Spartan-3, mapped by Yosys.
#
# For MODULE (default sp_board) in four configurations: a Markdown table, block by block: the blocks MODULE instantiates
# are kept apart, each flattened within (--depth 2 shows where one keeps blocks of its own); and the total with everything
# flattened, as a user would build it. A configuration sets the
# parameters MaxColumns, MaxRows, Grey, Image, Codes and CodeBits as far as MODULE has them. Warnings of Yosys go to stderr.
# --update writes the tables into rtl/README.md, between its markers.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() {
  echo "usage: scripts/resources.sh [--update] [--depth N] [MODULE]" >&2
  exit 2
}

update=false
depth=1
module=sp_board
while (($# > 0)); do
  case $1 in
    --update) update=true ;;
    --depth)
      [[ ${2:-} =~ ^[0-9]+$ ]] || usage
      depth=$2
      shift
      ;;
    -*) usage ;;
    *) module=$1 ;;
  esac
  shift
done

# Title and parameters
configurations=(
  "the original's image: 512 columns, 127 rows, binary|MaxColumns=512 MaxRows=127 Grey=0 Image=0"
  "with grey: 512 columns, 127 rows|MaxColumns=512 MaxRows=127 Grey=1 Image=0"
  "with the Gray-code decoder on chip: 512 columns, 127 rows, binary, codes of 8 bits with median|MaxColumns=512 MaxRows=127 Grey=0 Image=0 Codes=1 CodeBits=8"
  "the default maxima: 2048 columns, 1023 rows, grey, raw image|MaxColumns=2048 MaxRows=1023 Grey=1 Image=1"
)

# The part of sp_board that is compared with the original's whole user design
path="moments, packets with their header fields, packet FIFO=u_moments_path,u_info"

mapfile -t sources < <(find rtl -name 'sp_*.sv' ! -name 'sp_*_pkg.sv' | LC_ALL=C sort)
source_of_module=$(find rtl -name "$module.sv")
[[ -n $source_of_module ]] || { echo "resources.sh: $module: no such module under rtl/" >&2; exit 2; }

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# The blocks of the module
mapfile -t blocks_kept < <(grep -oE '^ +sp_[a-z0-9_]+' "$source_of_module" | tr -d ' ' | LC_ALL=C sort -u)

# map NAME PARAMETERS KEEP: writes $scratch/NAME.json (Yosys's netlist) and NAME.log
map() {
  local name=$1 parameters=$2 keep=$3 assignment set=""
  for assignment in $parameters; do
    grep -Eq "parameter[^,)]*\\b${assignment%%=*}\\b" "$source_of_module" &&
      set+=" -set ${assignment%%=*} ${assignment#*=}"
  done
  yosys -q -l "$scratch/$name.log" -p "
    read_verilog -sv rtl/common/sp_spec_pkg.sv ${sources[*]}
    ${set:+chparam$set $module}
    hierarchy -check -top $module
    ${keep:+setattr -mod -set keep_hierarchy 1 $keep}
    synth_xilinx -family xc3s -noiopad -nowidelut -flatten -top $module
    write_json $scratch/$name.json" >/dev/null 2>"$scratch/$name.warnings" || {
    echo "resources.sh: Yosys failed on $module ($parameters):" >&2
    cat "$scratch/$name.warnings" >&2
    exit 1
  }
  # Of no concern: Yosys's memory mapper leaves the unused high bits of a primitive's ports open; and it knows no shift
  # registers in this family (the table says so).
  if grep -Ev '^(Warning: Resizing cell port .*\.D[IO]P?[AB] from|Warning: Shift register inference not yet|Warning: Selection .* did not match any module)|^$' \
    "$scratch/$name.warnings" >"$scratch/$name.kept"; then
    echo "resources.sh: $module ($parameters):" >&2
    LC_ALL=C sort -u "$scratch/$name.kept" >&2
  fi
}

{
  yosys_version=$(yosys -V)
  echo "Module \`$module\`, Spartan-3 (\`synth_xilinx -family xc3s -noiopad -nowidelut -flatten\`, Yosys ${yosys_version:6:4})."
  echo "LUT4 counts LUT1 to LUT4, inverters and LUTs used as memory (a RAM16X1D takes 2), which are also stated on their"
  echo "own; carry is MUXCY. Yosys makes no shift registers (SRL16) in this family: they stand under FF. A block's row holds"
  echo "all it contains. Written by \`scripts/resources.sh --update\`."
  for i in "${!configurations[@]}"; do
    parameters=${configurations[i]#*|}
    map "blocks$i" "$parameters" "$(printf "*%s* " "${blocks_kept[@]}")" &
    blocks=$!
    map "flat$i" "$parameters" ""
    wait "$blocks"
    printf '\n**%s**\n\n' "${configurations[i]%%|*}"
    python3 scripts/resource_table.py --top "$module" --depth "$depth" --sum "$path" \
      "$scratch/blocks$i.json" "$scratch/flat$i.json"
  done
} >"$scratch/report.md"

if ! $update; then
  cat "$scratch/report.md"
  exit 0
fi
python3 scripts/resource_table.py --insert resources "$scratch/report.md" rtl/README.md
echo "resources.sh: rtl/README.md updated"
