#!/usr/bin/env bash
# fuzz.sh [--runs N] [--jobs J] [--seed S]: builds the libFuzzer target of the packet reader with clang in build/fuzz
# and runs N cases (default 10,000,000) in J processes (default: one a processor) under the address and
# undefined-behaviour sanitizers. Inputs that reached new code are kept in build/fuzz/corpus, and those that failed in
# build/fuzz. With a seed one process runs without the corpus and keeps nothing, so that the run can be repeated. The
# exit status is 77 if no clang with libFuzzer is installed.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() {
  echo "usage: scripts/fuzz.sh [--runs N] [--jobs J] [--seed S]" >&2
  exit 2
}

runs=10000000
jobs=$(nproc)
seed=
while (($# > 0)); do
  [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || usage
  case $1 in
    --runs) runs=$2 ;;
    --jobs) jobs=$2 ;;
    --seed) seed=$2 jobs=1 ;;
    *) usage ;;
  esac
  shift 2
done

build=build/fuzz
compiler=$(command -v clang++-14 || command -v clang++-19 || command -v clang++ || true)
mkdir -p "$build/corpus"
if [[ -z $compiler ]] || ! "$compiler" -fsanitize=fuzzer -x c++ -o "$build/probe" - 2>/dev/null <<<'
    extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }'; then
  echo "fuzz.sh: skipped: there is no clang with libFuzzer (scripts/setup.sh installs it)"
  exit 77
fi

cmake -S . -B "$build" -G Ninja --log-level=WARNING -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release \
  -DSELFPROJ_FUZZ=ON -DSELFPROJ_RTL=OFF
ninja -C "$build" --quiet packet_reader_fuzz

share=$(((runs + jobs - 1) / jobs))
options=(-runs="$share" -max_len=200 -print_final_stats=1 -artifact_prefix="$build/")
if [[ -n $seed ]]; then
  options+=(-seed="$seed")
else
  options+=("$build/corpus")
fi
rm -f "$build"/job-*.log
processes=()
for ((job = 1; job <= jobs; ++job)); do
  "$build/tests/fuzz/packet_reader_fuzz" "${options[@]}" >"$build/job-$job.log" 2>&1 &
  processes+=($!)
done
failed=0
for ((job = 1; job <= jobs; ++job)); do
  if ! wait "${processes[job - 1]}"; then
    failed=1
    tail -n 60 "$build/job-$job.log" >&2
  fi
done
((failed == 0)) || exit 1
cases=$(awk '/stat::number_of_executed_units/ { cases += $2 } END { print cases }' "$build"/job-*.log)
echo "fuzz.sh: $cases cases, none failed"
python3 scripts/results.py record fuzz --about "The packet reader under libFuzzer and the sanitizers" \
  --command "scripts/fuzz.sh --runs $runs --jobs $jobs${seed:+ --seed $seed}" cases="$cases" failed=0
