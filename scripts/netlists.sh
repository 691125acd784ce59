#!/usr/bin/env bash
# netlists.sh [NAME...]: runs the tests of tests/rtl on synthesized netlists in place of the RTL: every block and the
# board, mapped to the iCE40 by Yosys. It builds them in build/release and prints one line for each, with the tests that
# passed and the time. A NAME (streams, packetizer, board, ...) is the source of a test; by default all run.
# SELFPROJ_SEED=N runs one random case of each test instead of all. The exit status is 1 if a test fails.
set -euo pipefail
[[ ${1:-} != -h && ${1:-} != --help ]] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0; }
cd "$(dirname "${BASH_SOURCE[0]}")/.."

[[ ${1:-} != -* ]] || { echo "netlists.sh: $1: unknown; usage: scripts/netlists.sh [NAME...]" >&2; exit 2; }
build=build/release
[[ -e $build/build.ninja ]] || cmake --preset release --log-level=NOTICE
targets=("${@/#/mapped_}")
((${#targets[@]})) || targets=(mapped_all)
cmake --build "$build" --target "${targets[@]}"
if [[ ${targets[0]} == mapped_all ]]; then
  mapfile -t targets < <(cd "$build/tests/netlist" &&
    find . -maxdepth 1 -type f -executable -name 'mapped_*' -printf '%f\n' | sort)
fi

failed=0
for target in "${targets[@]}"; do
  started=$EPOCHREALTIME
  if said=$("$build/tests/netlist/$target" --gtest_brief=1 2>&1); then
    result=$(grep -o '[0-9]* tests\? from .* ran' <<<"$said" | head -1)
  else
    result="FAILED: $(grep -c '^\[  FAILED  \].*ms)' <<<"$said")"
    printf '%s\n' "$said" >"$build/tests/netlist/$target.log"
    failed=1
  fi
  printf '%-28s %s, %.1f s\n' "$target" "$result" "$(awk "BEGIN { print $EPOCHREALTIME - $started }")"
done
exit "$failed"
