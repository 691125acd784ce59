#!/usr/bin/env bash
# test.sh [--all] [--again | --record]: runs the checks and the quick tests of the project, and stops at the first
# failure: formats, generated files, rules; lint of the changed modules; one build with warnings as errors; the tests that
# need no waiting; clang-tidy on the changed sources. With --all it runs everything that continuous integration runs: also
# lint of all modules, the sanitizers, the build for speed with all tests, clang-tidy on all sources, and the other release
# of Debian (scripts/other_debian.sh). It begins with a list of its steps and the time each took in the last run on this
# machine (build/test/), or an estimate.
#
# It leaves out a step that passed before, as long as nothing has changed that the result can depend on: files of the
# project, packages, and the captures beside the project. In the same way it leaves out quick tests whose programs have
# not changed. --again runs all steps, but builds still leave out what is up to date. A run from scratch, without build/,
# does everything; --record writes the times of such a run to results/.
#
# What takes too long for every push is run by hand: coverage, mutation, fuzzing, soaks, placements and experiments.
# results/ has when each was last run, at which commit, and by which command.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

all=false
again=false
record=false
for word; do
  case $word in
    --all) all=true ;;
    --again) again=true ;;
    --record)
      record=true
      [[ ! -e build ]] || { echo "test.sh: --record: goes only with a run from scratch; build/ is there" >&2; exit 2; }
      ;;
    -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/test.sh; exit 0 ;;
    *) echo "test.sh: $word: unknown; usage: scripts/test.sh [--all] [--again | --record]" >&2; exit 2 ;;
  esac
done

passed=build/test
mkdir -p "$passed"
scripts/setup.sh tests

# A hash of all that the steps depend on.
state_of_all() {
  {
    scripts/lib/files.sh | tr '\n' '\0' | xargs -0 sha256sum
    dpkg-query --show
    captures
  } | sha256sum | cut -d ' ' -f 1
}

captures() { find ../shared/data -type f -printf '%p %s\n' 2>/dev/null | LC_ALL=C sort || true; }

# ---- the steps ----

check_generated() { python3 model/spec/generate.py --check; }

check_rules() {
  local rule
  for rule in layers links; do python3 -B "tests/house/check_$rule.py"; done
  python3 -B scripts/results.py check
}

check_scripts() {
  local files
  mapfile -t files < <(scripts/lib/files.sh '*.sh' .ci/run)
  shellcheck "${files[@]}"
  echo "${#files[@]} scripts"
}

check_format() {
  local files folder format=clang-format-14
  mapfile -t files < <(scripts/lib/files.sh '*.cpp' '*.h' | grep -v '/generated/')
  if ! command -v "$format" >/dev/null; then  # not in Debian 13, whose version lays some lines out differently
    folder=$(python3 -B scripts/lib/pypi.py build/clang-format clang-format==14.0.6) ||
      { echo "skipped: there is no clang-format 14"; return; }
    format=$folder/clang-format
  fi
  printf '%s\0' "${files[@]}" | xargs -0 -n 50 -P "$(nproc)" "$format" --dry-run --Werror
  echo "${#files[@]} files"
}

lint_changed() {
  local modules
  mapfile -t modules < <(scripts/lib/files.sh --changed 'rtl/*/sp_*.sv' | grep -v sp_spec_pkg | sed 's|.*/||; s|[.]sv$||')
  if ((${#modules[@]} > 0)); then scripts/lint_rtl.sh "${modules[@]}"; else echo "no module has changed"; fi
}

lint_rtl() { scripts/lint_rtl.sh; }

build_quick() { scripts/build.sh quick all; }

# One test more at a time than there are processors, because some wait.
test_quick() {
  local files
  captures >"$passed/captures"
  mapfile -t files < <(scripts/lib/files.sh | grep -vE '[.](cpp|h|sv|md|py|sh|json)$')
  if $again; then rm -f build/quick/passed.json; fi
  python3 -B tests/quick.py select build/quick "$passed/captures" "${files[@]}"
  ctest --preset quick --parallel "$(($(nproc) + 1))" --progress
  python3 -B tests/quick.py passed build/quick
}

tidy_changed() { scripts/tidy.sh; }

build_sanitized() { scripts/build.sh sanitizers sanitized_tests; }

test_sanitized() { ctest --preset sanitizers --label-regex sanitized --parallel "$(nproc)" --progress; }

build_all() { scripts/build.sh ci all; }

tidy_all() { scripts/tidy.sh --all; }

test_all() { ctest --preset release --parallel "$(($(nproc) + 1))" --progress; }

other_debian() {
  local status=0
  scripts/other_debian.sh || status=$?
  ((status == 0 || status == 77))  # 77: skipped, and it has said why
}

# The names of the steps in their order, and what each one does.
if $all; then
  steps=(check_generated check_rules check_scripts check_format lint_rtl build_sanitized test_sanitized build_all tidy_all
    test_all other_debian)
  results=test_times
else
  steps=(check_generated check_rules check_scripts check_format lint_changed build_quick test_quick tidy_changed)
  results=quick_test_times
fi
declare -A does=(
  [check_generated]="generated files agree with the specification"
  [check_rules]="rules of the project: layers, links, figures in documents"
  [check_scripts]="shellcheck on the scripts"
  [check_format]="format of the C++ sources"
  [lint_changed]="lint of the changed RTL modules"
  [lint_rtl]="lint of the RTL by Verilator, Icarus, Yosys, slang and Verible"
  [build_quick]="build of what the quick tests need"
  [test_quick]="quick tests"
  [tidy_changed]="clang-tidy on the changed sources"
  [build_sanitized]="build with the address and undefined-behaviour sanitizers"
  [test_sanitized]="tests with the sanitizers"
  [build_all]="build for speed: programs, tests, benchmarks"
  [tidy_all]="clang-tidy on capi, constraints, host, model and sim"
  [test_all]="all tests; where PyPI is reached, also the bitstream for the ECPIX-5"
  [other_debian]="the other release of Debian, in a chroot: demo and quick tests"
)
# These always run, and decide themselves what they have to do.
incremental=" build_quick build_sanitized build_all other_debian "

# is_known STEP: whether the step has passed in the present state
is_known() {
  ! $again && [[ $incremental != *" $1 "* && -f $passed/$1 && $(<"$passed/$1") == "$state" ]]
}

# time_of STEP: the seconds it took when it was last run here, or otherwise in the recorded run from scratch
time_of() {
  if [[ -f $passed/$1.seconds ]]; then
    cat "$passed/$1.seconds"
  else
    python3 - "$1" "$results" <<'PYTHON'
import json, pathlib, sys
file = pathlib.Path("results") / f"{sys.argv[2]}.json"
steps = json.loads(file.read_text(encoding="utf-8"))["results"]["steps"] if file.exists() else {}
print(steps.get(sys.argv[1], {"seconds": 0})["seconds"])
PYTHON
  fi
}

# cpu_seconds: the CPU time of all that this script has run so far
cpu_seconds() { awk -v hz="$(getconf CLK_TCK)" '{sub(/.*\) /, ""); printf "%.1f", ($14 + $15) / hz}' "/proc/$$/stat"; }

minutes() { printf '%d:%02d min' "$(($1 / 60))" "$(($1 % 60))"; }

# From scratch means without what ccache keeps from earlier builds.
if $record; then export CCACHE_RECACHE=1; fi

scripts/setup.sh tests
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
echo "about $(minutes "$sum") in all; builds and tests take less where little has changed"

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
echo "test.sh: everything passed$($all || echo ' of the quick part; --all runs the rest'); the steps took"
sum=0
for step in "${steps[@]}"; do
  seconds=$(time_of "$step")
  sum=$((sum + seconds))
  printf '  %-76s %s\n' "${does[$step]}" "$(minutes "$seconds")"
done

if $record; then
  SELFPROJ_RESULTS=results python3 -B scripts/results.py record "$results" \
    --command "scripts/test.sh$($all && echo ' --all') --record" \
    --about "The $($all || echo 'quick ')checks and tests from scratch, with all packages installed" \
    "minutes=$(awk -v s="$sum" 'BEGIN {printf "%.0f", s / 60}')" \
    "cpu_minutes=$(awk -v s="$(cpu_seconds)" 'BEGIN {printf "%.0f", s / 60}')" "${figures[@]}"
fi
