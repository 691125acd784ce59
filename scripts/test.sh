#!/usr/bin/env bash
# test.sh [--again | --record]: runs the checks and tests of the project, the quick ones first, and stops at the first
# failure. It begins with a list of its steps and the time each took in the last run on this machine (build/test/), or
# an estimate. Coverage, mutation, and long fuzzing and soaks are run by hand.
#
# It leaves out a step that passed before, as long as nothing has changed that the result can depend on: files of the
# project, packages, and the captures beside the project. clang-tidy does the same for each source (scripts/tidy.sh).
# --again runs all steps, but builds and clang-tidy still leave out what is up to date. A run from scratch, without
# build/, does everything; --record writes the times of such a run to results/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

again=false
record=false
case ${1:-} in
  "") ;;
  --again) again=true ;;
  --record)
    record=true
    [[ ! -e build ]] || { echo "test.sh: --record: goes only with a run from scratch; build/ is there" >&2; exit 2; }
    ;;
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/test.sh; exit 0 ;;
  *) echo "test.sh: $1: unknown; usage: scripts/test.sh [--again | --record]" >&2; exit 2 ;;
esac

passed=build/test
mkdir -p "$passed"

# The files of the project, except deleted ones.
sources() {
  local file
  git ls-files -z --cached --others --exclude-standard "$@" | while IFS= read -r -d '' file; do
    if [[ -f $file ]]; then printf '%s\n' "$file"; fi
  done
}

# A hash of all that the steps depend on.
state_of_all() {
  {
    sources | tr '\n' '\0' | LC_ALL=C sort -z | xargs -0 sha256sum
    dpkg-query --show
    find ../shared/data build/ap_types -type f -printf '%p %s\n' 2>/dev/null | LC_ALL=C sort || true
  } | sha256sum | cut -d ' ' -f 1
}

# ---- the steps ----

check_generated() { python3 model/spec/generate.py --check; }

check_rules() {
  local rule
  for rule in layers names links sizes; do python3 -B "tests/house/check_$rule.py"; done
  python3 -B scripts/results.py check
}

check_scripts() {
  local files
  mapfile -t files < <(sources '*.sh' .ci/run)
  shellcheck "${files[@]}"
  echo "${#files[@]} scripts"
}

check_format() {
  local files
  mapfile -t files < <(sources '*.cpp' '*.h' | grep -v '/generated/')
  clang-format-14 --dry-run --Werror "${files[@]}"
  echo "${#files[@]} files"
}

lint_rtl() { scripts/lint_rtl.sh; }

build_sanitized() { scripts/build.sh sanitizers sanitized_tests; }

test_sanitized() { ctest --preset sanitizers --label-regex sanitized --parallel "$(nproc)" --progress; }

build_all() { scripts/build.sh release all; }

# The sources of hls/, python/ and tests/ are left out; run scripts/tidy.sh for them by hand. The simulations of the
# ECPIX-5 and the Acorn are built with LiteEth and LitePCIe, in builds of their own (scripts/target_sim.sh,
# scripts/acorn_sim.sh).
tidy() {
  local files
  mapfile -t files < <(sources 'capi/*.cpp' 'host/*.cpp' 'model/*.cpp' 'sim/*.cpp' |
    grep -v -e '/generated/' -e '^sim/target/\(ecpix5\|acorn\)_sim.cpp$')
  scripts/tidy.sh "${files[@]}"
}

# Runs one test more at a time than there are processors, because tests that wait for cameras and screens use little
# processor time.
test_all() { ctest --preset release --parallel "$(($(nproc) + 1))" --progress; }

# The names of the steps in their order, and what each one does.
steps=(check_generated check_rules check_scripts check_format lint_rtl build_sanitized test_sanitized build_all tidy
  test_all)
declare -A does=(
  [check_generated]="generated files agree with the specification"
  [check_rules]="rules of the project: layers, names, links, sizes, figures in documents"
  [check_scripts]="shellcheck on the scripts"
  [check_format]="format of the C++ sources"
  [lint_rtl]="lint of the RTL by Verilator, Icarus, Yosys and slang"
  [build_sanitized]="build with the address and undefined-behaviour sanitizers"
  [test_sanitized]="tests with the sanitizers"
  [build_all]="build for speed: programs, tests, benchmarks"
  [tidy]="clang-tidy on capi, host, model and sim"
  [test_all]="all tests; where PyPI is reached, also the bitstream for the ECPIX-5"
)
# These always run, and decide themselves what they have to do.
incremental=" build_sanitized build_all tidy "

# is_known STEP: whether the step has passed in the present state
is_known() {
  ! $again && [[ $incremental != *" $1 "* && -f $passed/$1 && $(<"$passed/$1") == "$state" ]]
}

# time_of STEP: the seconds it took when it was last run here. Otherwise an estimate, from the CPU time that it took in
# the recorded run from scratch
time_of() {
  if [[ -f $passed/$1.seconds ]]; then
    cat "$passed/$1.seconds"
  else
    python3 - "$1" "$(nproc)" <<'PYTHON'
import json, pathlib, sys
file = pathlib.Path("results") / "test_times.json"
steps = json.loads(file.read_text(encoding="utf-8"))["results"]["steps"] if file.exists() else {}
print(round(steps.get(sys.argv[1], {"cpu_seconds": 0})["cpu_seconds"] / int(sys.argv[2])))
PYTHON
  fi
}

# cpu_seconds: the CPU time of all that this script has run so far
cpu_seconds() { awk -v hz="$(getconf CLK_TCK)" '{sub(/.*\) /, ""); printf "%.1f", ($14 + $15) / hz}' "/proc/$$/stat"; }

minutes() { printf '%d:%02d min' "$(($1 / 60))" "$(($1 % 60))"; }

scripts/setup.sh tests
hls/get_ap_types.sh ||
  echo "test.sh: skipped for want of PyPI: tests of the HLS kernels with the vendor's integers (kernels_ap)"
state=$(state_of_all)

echo "test.sh will do this, in this order, and take about as long as in the last run here (*: an estimate):"
sum=0
for step in "${steps[@]}"; do
  if is_known "$step"; then
    when="nothing changed since it passed: left out"
  else
    seconds=$(time_of "$step")
    sum=$((sum + seconds))
    when=$(minutes "$seconds")
    if [[ ! -f $passed/$step.seconds ]]; then when+=" *"; fi
  fi
  printf '  %-76s %s\n' "${does[$step]}" "$when"
done
echo "about $(minutes "$sum") in all; builds and clang-tidy take less where little has changed"

figures=()
for step in "${steps[@]}"; do
  is_known "$step" && continue
  printf '\n== %s\n' "${does[$step]}"
  SECONDS=0
  before=$(cpu_seconds)
  "$step"
  echo "$SECONDS" >"$passed/$step.seconds"
  echo "$state" >"$passed/$step"
  figures+=("steps/$step/seconds=$SECONDS"
    "steps/$step/cpu_seconds=$(awk -v a="$before" -v b="$(cpu_seconds)" 'BEGIN {print b - a}')")
done

echo
echo "test.sh: everything passed; the steps took"
sum=0
for step in "${steps[@]}"; do
  seconds=$(time_of "$step")
  sum=$((sum + seconds))
  printf '  %-76s %s\n' "${does[$step]}" "$(minutes "$seconds")"
done

if $record; then
  SELFPROJ_RESULTS=results python3 -B scripts/results.py record test_times --command "scripts/test.sh --record" \
    --about "The checks and tests from scratch, with all packages installed" \
    "minutes=$(awk -v s="$sum" 'BEGIN {printf "%.0f", s / 60}')" \
    "cpu_minutes=$(awk -v s="$(cpu_seconds)" 'BEGIN {printf "%.0f", s / 60}')" "${figures[@]}"
fi
