#!/usr/bin/env bash
# tidy.sh [SOURCE...]: clang-tidy over all our C++ sources (or those named), as preset release compiles them; that must
# have been built. A source that passed is not looked at again until it, a header of ours that it includes, the settings
# or its compile command change (stamps in build/tidy/).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=build/release
stamps=build/tidy
[[ -f $build/compile_commands.json ]] || { echo "tidy.sh: $build is missing; run scripts/build.sh first" >&2; exit 2; }
mkdir -p "$stamps"

if (($# > 0)); then
  sources=("$@")
else
  # The fuzzer is built by clang alone, in a build of its own (scripts/fuzz.sh).
  mapfile -t sources < <(git ls-files --cached --others --exclude-standard '*.cpp' | grep -v -e '/generated/' -e '^tests/fuzz/')
fi

# One line a source: its stamp, a hash of all the verdict depends on, and its name. The list ends with the word "end".
mapfile -t jobs < <(ninja -C "$build" -t deps | python3 scripts/tidy_stamps.py "$build" "${sources[@]}")
[[ ${jobs[-1]:-} == end ]] || exit 1
unset 'jobs[-1]'

check() {
  local stamp=$stamps/$1 source=$2 output
  # The compile commands are those of g++, some of whose warnings clang does not know.
  if output=$(clang-tidy-14 -p "$build" --quiet --header-filter="^$PWD/(hls|host|model|sim|tests)/" \
    --warnings-as-errors='*' --extra-arg=-Wno-unknown-warning-option "$source" 2>/dev/null); then
    touch "$stamp"
  else
    printf 'tidy.sh: %s:\n%s\n' "$source" "$output" >&2
    return 1
  fi
}

failed=0
running=0
count=0
for job in "${jobs[@]}"; do
  stamp=${job%% *}
  [[ -f $stamps/$stamp ]] && continue
  count=$((count + 1))
  if ((running == $(nproc))); then
    wait -n || failed=1
    running=$((running - 1))
  fi
  check "$stamp" "${job#* }" &
  running=$((running + 1))
done
while ((running > 0)); do
  wait -n || failed=1
  running=$((running - 1))
done
((failed == 0)) || exit 1
echo "tidy.sh: ${#jobs[@]} sources are clean, $count of them looked at now"
