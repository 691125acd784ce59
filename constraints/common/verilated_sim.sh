#!/usr/bin/env bash
# verilated_sim.sh BUILD FOLDER PREFIX SOURCE LIBRARY... -- OPTION...: builds the program FOLDER/sim of the C++ source,
# the model PREFIX that Verilator makes with these options, and libraries of the build BUILD. It uses the Verilator of
# that build. What is current already is not made again. A warning of Verilator is an error.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

build=$1 folder=$2 prefix=$3 source=$4
shift 4
libraries=()
while [[ $1 != -- ]]; do libraries+=("$build/$1"); shift; done
shift
for library in "${libraries[@]}"; do
  [[ -e $library ]] || { echo "verilated_sim.sh: $library is missing; run scripts/build.sh release all" >&2; exit 2; }
done
setting() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }
verilator=$(setting SELFPROJ_VERILATOR)
include=$("$verilator" --getenv VERILATOR_ROOT)/include
lz4=$(setting SELFPROJ_LZ4)

state=$({ echo "$*" "$verilator"; cat "$0" cmake/verilate.cmake "${libraries[@]}" constraints/*/*.{sv,svh,vlt,h,cpp} rtl/*/*
  for word; do [[ ! -f $word ]] || cat "$word"; done; } | sha256sum)
[[ ! -x $folder/sim || $(cat "$folder/made" 2>/dev/null) != "$state" ]] || exit 0
mkdir -p "$folder"
failed() { grep -m 5 -i error "$folder/build.log" >&2; exit 1; }
cmake "-DVERILATOR=$verilator" "-DFOLDER=$PWD/$folder/model" "-DPREFIX=$prefix" -P cmake/verilate.cmake -- \
  "$@" >"$folder/build.log" 2>&1 || failed
if grep -m 5 '^%Warning' "$folder/build.log" >&2; then exit 1; fi

# With -O1 compiling and a run of a test take the least together; -Os runs 1.6 times as long.
compile=("${CXX:-c++}" -std=c++20 -O1 -w -I. -Iinclude -I"$folder/model" -I"$include" -I"$include/vltstd" -DVM_COVERAGE=0 -DVM_SC=0
  -DVM_TRACE=1 -DVM_TRACE_FST=1 -DVM_TRACE_VCD=0)
objects=()
jobs=()
for part in "$folder/model/$prefix"__{often,seldom}.cpp "$source"; do
  objects+=("$folder/$(basename "$part").o")
  "${compile[@]}" -c "$part" -o "${objects[-1]}" >>"$folder/build.log" 2>&1 &
  jobs+=($!)
done
for job in "${jobs[@]}"; do wait "$job" || failed; done
"${compile[@]}" "${objects[@]}" "${libraries[@]}" ${lz4:+"$lz4"} -pthread -lz -o "$folder/sim" \
  >>"$folder/build.log" 2>&1 || failed
echo "$state" >"$folder/made"
