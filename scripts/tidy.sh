#!/usr/bin/env bash
# tidy.sh [SOURCE...]: clang-tidy over all our C++ sources (or those named), as preset release compiles them; that must
# have been built. Sources of a folder that are compiled alike are looked at together (tidy_groups.py); such a group that
# passed is not looked at again until a source, a header of ours that it includes, the settings or the compile command
# change (stamps in build/tidy/).
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

# One line a group: its stamp, a hash of all the verdict depends on, the file that is it, and its sources. The list ends
# with the word "end".
mapfile -t jobs < <(ninja -C "$build" -t deps | python3 scripts/tidy_groups.py "$build" "$stamps" "${sources[@]}")
[[ ${jobs[-1]:-} == end ]] || exit 1
unset 'jobs[-1]'

look_at() {
  # The compile commands are those of g++, some of whose warnings clang does not know.
  clang-tidy-14 -p "$stamps" --quiet --header-filter="^$PWD/(hls|host|model|sim|tests)/" \
    --warnings-as-errors='*' --extra-arg=-Wno-unknown-warning-option "$1" 2>/dev/null
}

check() {
  local stamp=$stamps/$1 file=$2 output source failed=0
  shift 2
  if ! output=$(look_at "$file"); then
    failed=1
    # What does not compile may do so source by source: two of them may have the same name for what each has to itself.
    if (($# > 1)) && [[ $output == *'[clang-diagnostic-error'* ]]; then
      failed=0
      grep -m 1 'clang-diagnostic-error' <<<"$output" | sed 's/^/tidy.sh: looked at one by one: /'
      for source; do
        output=$(look_at "$source") || { failed=1; printf 'tidy.sh: %s:\n%s\n' "$source" "$output" >&2; }
      done
    else
      printf 'tidy.sh: %s\n' "$output" >&2
    fi
  fi
  ((failed == 0)) && touch "$stamp"
}

failed=0
running=0
count=0
for job in "${jobs[@]}"; do
  read -ra words <<<"$job"
  [[ -f $stamps/${words[0]} ]] && continue
  count=$((count + ${#words[@]} - 2))
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
echo "tidy.sh: ${#sources[@]} sources are clean, $count of them looked at now"
