#!/usr/bin/env bash
# tidy.sh [SOURCE...]: runs clang-tidy over all our C++ sources, or only those named, with the compile options of preset
# release, which must have been built. A source that passed is checked again only if something has changed that its
# result depends on: the source, a header of ours that it includes, the settings, the compile options, the versions of
# tools and libraries. tidy_groups.py decides this, and build/tidy/good records which sources passed. The exit status is
# 1 if there is a finding.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

case ${1:-} in
  -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' scripts/tidy.sh; exit 0 ;;
  -*) echo "tidy.sh: $1: unknown; usage: scripts/tidy.sh [SOURCE...]" >&2; exit 2 ;;
esac

build=build/release
folder=build/tidy
[[ -f $build/compile_commands.json ]] ||
  { echo "tidy.sh: $build is missing; run scripts/build.sh release all" >&2; exit 2; }
mkdir -p "$folder/good"
rm -f "$folder"/UnifiedSource_*.cpp

if (($# > 0)); then
  sources=("$@")
else
  # Preset release does not build the fuzzer and the simulations of the ECPIX-5 and the Acorn. They have builds of their
  # own (scripts/fuzz.sh, scripts/target_sim.sh, scripts/acorn_sim.sh).
  mapfile -t sources < <(git ls-files --cached --others --exclude-standard '*.cpp' |
    grep -v -e '/generated/' -e '^tests/fuzz/' -e '^sim/target/\(ecpix5\|acorn\)_sim.cpp$')
fi

# Each line is a job: a file to check, and STATE:SOURCE for each source in it. The last line is the word "end".
mapfile -t jobs < <(python3 scripts/tidy_groups.py "$build" "$folder" "${sources[@]}")
[[ ${jobs[-1]:-} == end ]] || exit 1
unset 'jobs[-1]'

# find_faults FILE
find_faults() {
  # The compile commands are those of g++, and clang does not know some of its warnings.
  # The analyzer does not look into templates, nearly all of which are from libraries. To analyze them takes six times
  # as long. A third of the default limit for the states of a function halves the analyzer's time, and all its checkers
  # still find the same.
  clang-tidy-14 -p "$folder" --quiet --header-filter="^$PWD/((hls|host|model|sim|tests)/|capi/.*[.]cpp$)" \
    --warnings-as-errors='*' --extra-arg=-Wno-unknown-warning-option \
    --extra-arg=-Xclang --extra-arg=-analyzer-config \
    --extra-arg=-Xclang --extra-arg=c++-template-inlining=false,max-nodes=75000 \
    "$1" 2>/dev/null
}

# check FILE STATE:SOURCE...: checks the file, and records the states of its sources if it passes. Returns 1 if not.
check() {
  local file=$1 output part failed=0 together=() alone=()
  shift
  if output=$(find_faults "$file"); then
    for part; do touch "$folder/good/${part%%:*}"; done
    return 0
  fi
  # Two sources may use the same name for different things. Then the sources that do not compile after the others are
  # checked one by one. If the error is in a library's header, all sources are checked one by one.
  local strange
  strange=$(awk -v own="$PWD/" '/: error: / && (/clang-diagnostic-error/ || index($0, own) != 1) {print; exit}' \
    <<<"$output")
  if (($# == 1)) || [[ -z $strange ]]; then
    printf 'tidy.sh: %s\n' "$output" >&2
    return 1
  fi
  echo "tidy.sh: checked one by one: $strange"
  for part; do
    if grep -q "^${part#*:}:.*clang-diagnostic-error" <<<"$output"; then alone+=("$part"); else together+=("$part"); fi
  done
  if ((${#alone[@]} == 0)); then
    alone=("$@")
  elif ((${#together[@]} > 0)); then
    for part in "${alone[@]}"; do sed -i "\\|\"${part#*:}\"|d" "$file"; done
    check "$file" "${together[@]}" || failed=1
  fi
  for part in "${alone[@]}"; do check "${part#*:}" "$part" || failed=1; done
  return "$failed"
}

failed=0
running=0
count=0
for job in "${jobs[@]}"; do
  read -ra words <<<"$job"
  count=$((count + ${#words[@]} - 1))
  if ((running == $(nproc))); then
    wait -n || failed=1
    running=$((running - 1))
  fi
  check "${words[@]}" &
  running=$((running + 1))
done
while ((running > 0)); do
  wait -n || failed=1
  running=$((running - 1))
done
((failed == 0)) || exit 1
echo "tidy.sh: ${#sources[@]} sources are clean, $count of them checked now"
