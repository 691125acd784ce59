#!/usr/bin/env bash
# fuzz.sh [--runs N] [--seed S] [OPTION...]: builds the libFuzzer target of the packet reader with clang in build/fuzz and
# runs N cases (default 10,000,000) under the address and undefined-behaviour sanitizers. What follows goes to libFuzzer.
# Inputs that reached something new are kept in build/fuzz/corpus where no seed is given. Exit status 77 where there is no
# clang with libFuzzer.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

runs=10000000
seed=
while (($# > 0)); do
  case $1 in
    --runs) runs=${2:?"fuzz.sh: --runs needs a number"}; shift 2 ;;
    --seed) seed=${2:?"fuzz.sh: --seed needs a number"}; shift 2 ;;
    *) break ;;
  esac
done

build=build/fuzz
compiler=$(command -v clang++-14 || command -v clang++ || true)
mkdir -p "$build/corpus"
if [[ -z $compiler ]] || ! "$compiler" -fsanitize=fuzzer -x c++ -o "$build/probe" - 2>/dev/null <<<'
    extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }'; then
  echo "fuzz.sh: skipped: there is no clang with libFuzzer (Debian: clang-14, libclang-rt-14-dev)"
  exit 77
fi

cmake -S . -B "$build" -G Ninja --log-level=WARNING -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release \
  -DSELFPROJ_FUZZ=ON -DSELFPROJ_RTL=OFF
ninja -C "$build" --quiet packet_reader_fuzz

options=(-runs="$runs" -max_len=200 -print_final_stats=1)
if [[ -n $seed ]]; then
  options+=(-seed="$seed")  # repeatable: begins with nothing, keeps nothing
else
  options+=("$build/corpus")
fi
"$build/tests/fuzz/packet_reader_fuzz" "${options[@]}" "$@"
echo "fuzz.sh: $runs cases, none failed"
